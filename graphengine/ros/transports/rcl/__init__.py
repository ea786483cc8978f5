"""The transport `rclpy`, which uses an installed ROS 2."""

from dataclasses import replace
from functools import partial

from graphengine.format.errors import TransportError
from graphengine.ros.transport import JoinOptions, Transport, TransportKind
from graphengine.ros.transports.rcl.installation import is_from_wheels, missing


def _not_for_auto() -> str | None:
    return "it is from PyPI: --transport rclpy uses it" if is_from_wheels() else None


def _open(options: JoinOptions) -> Transport:
    from graphengine.ros.transports.composed import ComposedTransport
    from graphengine.ros.transports.rcl.rcl import RclTransport
    from graphengine.ros.transports.rcl.rcl_profiles import is_installed

    hasty = "publishers on rclpy do not wait for slow readers" if options.patient else ""
    transport = RclTransport(replace(options, because="; ".join(filter(None, (options.because, hasty)))))
    if is_from_wheels():
        return ComposedTransport(transport, is_installed, partial(_open_embedded, options))
    return transport


def _open_embedded(options: JoinOptions) -> Transport:
    """Join the domain with embedded DDS, without announcing the node."""
    from graphengine.ros.transports import dds

    if (why := dds.TRANSPORT.missing()) is not None:
        raise TransportError(f"rclpy does not have all types, and dds cannot be used: {why}")
    from graphengine.ros.transports.dds.dds import DdsTransport

    return DdsTransport(replace(options, because=""), announces=False)


_HELP = "ROS 2 programs through rclpy of an installed ROS 2"
TRANSPORT = TransportKind("rclpy", _HELP, _open, auto=1, missing=missing, not_for_auto=_not_for_auto)
