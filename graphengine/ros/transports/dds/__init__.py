"""The transport `dds`, which does not need an installed ROS 2."""

import importlib
from dataclasses import replace

from graphengine.ros.transport import JoinOptions, Transport, TransportKind


def _open(options: JoinOptions) -> Transport:
    from graphengine.ros.transports.dds.dds import DdsTransport

    rmw = options.environ.get("RMW_IMPLEMENTATION", "")
    zenoh = f"RMW_IMPLEMENTATION is {rmw}, whose peers do not speak DDS and cannot be reached" if "zenoh" in rmw else ""
    because = "; ".join(filter(None, (options.because, zenoh)))
    return DdsTransport(replace(options, because=because))


def _missing() -> str | None:
    try:
        importlib.import_module("cyclonedds")
    except ImportError as error:
        where = "PyPI has cyclonedds for Linux on x86_64, for macOS and for Windows, and for Python 3.11 to 3.13"
        remedy = "use one of these, or a sourced ROS 2 with --transport rclpy, or no network with --transport memory"
        return f"{error}\n{where}\n{remedy}"
    return None


TRANSPORT = TransportKind("dds", "ROS 2 programs over DDS, without an installed ROS 2", _open, auto=2, missing=_missing)
