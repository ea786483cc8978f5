"""The transport over DDS without ROS."""

from importlib.util import find_spec

from graphengine.ros.transport import JoinOptions, Transport, TransportKind


def _open(options: JoinOptions) -> Transport:
    from graphengine.ros.transports.dds.dds import DdsTransport

    rmw = options.environ.get("RMW_IMPLEMENTATION", "")
    zenoh = f"RMW_IMPLEMENTATION is {rmw}, whose peers do not speak DDS and cannot be reached" if "zenoh" in rmw else ""
    because = "; ".join(filter(None, (options.because, zenoh)))
    node = options.node_name, options.node_namespace
    return DdsTransport(options.domain, *node, because, options.definitions, patient=options.patient)


def _missing() -> str | None:
    return None if find_spec("cyclonedds") else "the package cyclonedds is not installed"


TRANSPORT = TransportKind("dds", "ROS 2 programs on DDS, without an installed ROS 2", _open, auto=2, missing=_missing)
