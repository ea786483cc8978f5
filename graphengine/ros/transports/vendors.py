"""The RMWs of ROS 2 and their DDS vendors; services do not work between different RMWs."""

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
    """Return a warning about peers of a service that run on another RMW; empty if there are none.

    Args:
        service: name of the service.
        peer: role of the peers, `server` or `client`.
        gids: GIDs of the peers' endpoints, or only the first two bytes of each GID.
        own: RMW of this process; the result is empty if this is not a known DDS RMW.
    """
    own = own.replace("_dynamic", "")  # Fast DDS has two RMWs, which are compatible
    others = {_RMWS.get(gid[:2], "another RMW") for gid in gids} - {own}
    if not others or own not in _RMWS.values():
        return ""
    action = action_of(service)  # the warnings of its services are equal
    return (
        f"{action or service}: a {peer} on {' and '.join(sorted(others))} is unreachable:"
        f" {'actions' if action else 'services'} do not work between different"
        f" RMWs of ROS 2\n  run it with RMW_IMPLEMENTATION={own} if it has that RMW, or run graphrun with --transport rclpy"
        " if its rclpy is on the same RMW and has the type; `graphrun ctl` controls the simulation in any case"
    )
