"""The DDS implementations of ROS 2's RMWs: services do not work between different ones."""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.messages.names import action_of

CYCLONE = b"\x01\x10"
"""First two bytes of GIDs of Eclipse Cyclone DDS: the RTPS vendor id."""
FAST_DDS = b"\x01\x0f"
"""First two bytes of GIDs of eProsima Fast DDS: the RTPS vendor id."""
CYCLONE_RMW = "rmw_cyclonedds_cpp"

_RMWS = {b"\x01\x01": "rmw_connextdds", FAST_DDS: "rmw_fastrtps_cpp", CYCLONE: CYCLONE_RMW}
"""RMW implementations by RTPS vendor id (omg.org/spec/DDSI-RTPS)."""


def warning(service: str, peer: str, gids: Iterable[bytes], own: str) -> str:
    """Return a warning about incompatible peers of a service; empty if there are none.

    Args:
        service: service that the peers offer or call.
        peer: whether they are a server or a client.
        gids: GIDs of their endpoints, of which the first two bytes are sufficient.
        own: RMW of this process; if it is not based on DDS, nothing is reported.
    """
    own = own.replace("_dynamic", "")  # Fast DDS has two RMWs, which understand each other
    others = {_RMWS.get(gid[:2], "another RMW") for gid in gids} - {own}
    if not others or own not in _RMWS.values():
        return ""
    action = action_of(service)  # the warnings of its services are equal
    return (
        f"{action or service}: a {peer} on {' and '.join(sorted(others))} is unreachable:"
        f" {'actions' if action else 'services'} do not work between different"
        f" RMWs of ROS 2\n  run it with RMW_IMPLEMENTATION={own}, or graphrun with --transport rclpy on its RMW; `graphrun ctl`"
        " controls the simulation in any case"
    )
