"""RMWs of ROS 2 by the implementations of DDS that they are on: services do not work from one to another."""

from __future__ import annotations

from collections.abc import Iterable

CYCLONE = b"\x01\x10"
"""What GIDs of Eclipse Cyclone DDS begin with."""
FAST_DDS = b"\x01\x0f"
"""The same of eProsima's."""
CYCLONE_RMW = "rmw_cyclonedds_cpp"

_RMWS = {b"\x01\x01": "rmw_connextdds", FAST_DDS: "rmw_fastrtps_cpp", CYCLONE: CYCLONE_RMW}
"""By vendor, in the two bytes that the RTPS specification gives each (omg.org/spec/DDSI-RTPS)."""


def warning(service: str, peer: str, gids: Iterable[bytes], own: str) -> str:
    """What to tell people about peers that cannot be talked to; empty where there are none.

    Args:
        service: that they offer or call.
        peer: whether they are a server or a client.
        gids: of endpoints of theirs; their first two bytes will do.
        own: RMW of those who can be talked to. Of one that is not on DDS, nothing is known.
    """
    own = own.replace("_dynamic", "")  # Fast DDS has two RMWs, which understand each other
    others = {_RMWS.get(gid[:2], "another RMW") for gid in gids} - {own}
    if not others or own not in _RMWS.values():
        return ""
    return (
        f"{service}: a {peer} on {' and '.join(sorted(others))} cannot be talked to: ROS 2's RMWs do not interoperate on"
        f" services\n  run it with RMW_IMPLEMENTATION={own}, or graphrun with --transport rclpy on its RMW; `graphrun ctl`"
        " controls the simulation in any case"
    )
