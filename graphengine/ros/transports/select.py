"""Which transport carries a session: an installed ROS 2 where there is one, else DDS, or none."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

from graphengine.ros.domain import Domain
from graphengine.ros.transport import Transport

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions

TransportKind = Literal["auto", "dds", "rclpy", "memory"]


def open_transport(
    kind: TransportKind,
    domain: Domain,
    node_name: str = "graphengine",
    node_namespace: str = "/",
    environ: Mapping[str, str] = MappingProxyType({}),
    definitions: Definitions | None = None,
    *,
    patient: bool = False,
) -> Transport:
    """Join a domain as one ROS 2 node; the transport's description says what was chosen, and why.

    Args:
        kind: `auto` takes rclpy when it can be imported, else dds.
        domain: where to be.
        node_name: what `ros2 node list` shows.
        node_namespace: absolute; `/` for none.
        environ: where RMW_IMPLEMENTATION may tell that peers cannot be reached.
        definitions: message types, those that ship when None; rclpy knows those that are installed, and no others.
        patient: let dds wait for readers that do not keep up, as `DdsTransport` says.

    Raises:
        TopicError: ROS 2 would refuse the node's name or namespace.
        TransportError: the domain cannot be joined.
    """
    # Each is imported only when it is used: they cost from 0.1 to 0.3 s, and rclpy may not be there.
    from graphengine.messages.definitions import DEFINITIONS

    if kind == "memory":
        from graphengine.ros.transports.memory.memory import MemoryTransport

        return MemoryTransport(keeps=False, definitions=definitions or DEFINITIONS)
    reasons = []
    if kind in ("auto", "rclpy"):
        from graphengine.ros.transports.rcl.rcl import RclTransport, import_error

        missing = import_error() if kind == "auto" else None
        if missing is None:
            because = "chosen because rclpy is installed" if kind == "auto" else ""
            return RclTransport(domain, node_name, node_namespace, because, definitions or DEFINITIONS)
        reasons.append(f"chosen because rclpy cannot be imported ({missing})")
    from graphengine.ros.transports.dds.dds import DdsTransport

    rmw = environ.get("RMW_IMPLEMENTATION", "")
    if "zenoh" in rmw:
        reasons.append(f"RMW_IMPLEMENTATION is {rmw}, whose peers do not speak DDS and cannot be reached")
    because = "; ".join(reasons)
    return DdsTransport(domain, node_name, node_namespace, because, definitions or DEFINITIONS, patient=patient)
