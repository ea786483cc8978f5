"""Who can be talked to: services work between nodes on one RMW only."""

from __future__ import annotations

import pytest

from graphengine.ros.transports.vendors import warning

# GIDs as they were seen on a network; the first two bytes are the vendor's.
CYCLONE = bytes.fromhex("01105c5cf8578dcfc02b1d8b00001603")
FAST = bytes.fromhex("010f78fd8d0632b60000000000001403")
UNKNOWN = bytes.fromhex("ffff78fd8d0632b60000000000001403")


@pytest.mark.parametrize(
    ("own", "gids"),
    [
        ("rmw_cyclonedds_cpp", []),
        ("rmw_cyclonedds_cpp", [CYCLONE, CYCLONE]),
        ("rmw_fastrtps_cpp", [FAST]),
        ("rmw_fastrtps_dynamic_cpp", [FAST]),
        ("rmw_zenoh_cpp", [UNKNOWN]),  # whose GIDs are not those of DDS
    ],
)
def test_peers_on_the_same_rmw_cause_no_warning(own: str, gids: list[bytes]) -> None:
    assert warning("/reset", "client", gids, own) == ""


@pytest.mark.parametrize(
    ("own", "gids", "others"),
    [
        ("rmw_cyclonedds_cpp", [CYCLONE, FAST, FAST], "rmw_fastrtps_cpp"),
        ("rmw_fastrtps_cpp", [CYCLONE], "rmw_cyclonedds_cpp"),
        ("rmw_cyclonedds_cpp", [UNKNOWN, FAST], "another RMW and rmw_fastrtps_cpp"),
    ],
)
def test_a_warning_names_the_peer_and_a_remedy(own: str, gids: list[bytes], others: str) -> None:
    what, remedy = warning("/reset", "client", gids, own).split("\n")
    assert what == (
        f"/reset: a client on {others} is unreachable: services do not work between different RMWs of ROS 2"
    )
    assert f"RMW_IMPLEMENTATION={own}" in remedy
    assert "--transport rclpy" in remedy
    assert "graphrun ctl" in remedy


def test_all_unreachable_services_of_an_action_give_the_same_warning() -> None:
    texts = {
        warning(f"/dock/_action/{part}", "client", [FAST], "rmw_cyclonedds_cpp") for part in ("send_goal", "get_result")
    }
    (text,) = texts
    assert text.startswith(
        "/dock: a client on rmw_fastrtps_cpp is unreachable: actions do not work between different RMWs"
    )
