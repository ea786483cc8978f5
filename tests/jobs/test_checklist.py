"""The tutorial's verification steps with `graphrun` in the place of ros2cli and view_frames, on a machine without ROS."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from tests.cli.harness import ROOT, Result, live, process
from tests.waiting import reserved_domain

PLAIN = [
    "/cmd_vel",
    "/diagnostics",
    "/odom",
    "/parameter_events",
    "/platform/joint_states",
    "/rosout",
    "/scan",
    "/tf",
    "/tf_static",
]
"""What `ros2 topic list` prints after "Building OmniGraph Nodes", in its order, and the diagnostics of the session."""
NAMESPACED = [
    "/clock",
    "/dd100_0000/cmd_vel",
    "/dd100_0000/odom",
    "/dd100_0000/platform/joint_states",
    "/dd100_0000/sim_lidar/scan",
    "/dd100_0000/tf",
    "/dd100_0000/tf_static",
    "/diagnostics",
    "/parameter_events",
    "/rosout",
]
"""The same after "Add Automatic Namespace Attributes", and with the clock of the scene."""
LINKS = {
    link.get("name") for link in ElementTree.parse(ROOT / "scenes/robots/dd100/dd100.urdf").getroot().findall("link")
}
ATTEMPTS = 20  # a busy machine may find its peers late

Tool = Callable[..., Result]


@contextmanager
def simulation(*arguments: str) -> Iterator[Tool]:
    """A running scene, and `graphrun` in another process of its domain."""
    with reserved_domain() as number:
        variables = {"ROS_DOMAIN_ID": str(number), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        with live("run", *arguments, "--transport", "dds", env=variables) as running:
            assert running.hear(lambda said: " Hz, " in said), running.said
            yield lambda *words, **ended: process(*words, "--transport", "dds", env=variables, **ended)


@pytest.fixture(scope="module")
def tool() -> Iterator[Tool]:
    with simulation("tutorial/navigation", "--robot-state") as made:
        yield made


def listed(tool: Tool, expected: list[str]) -> list[str]:
    """What `topic list` prints, once peers were found."""
    for _ in range(ATTEMPTS):
        result = tool("topic", "list", code=0)
        if len(result.lines) >= len(expected):
            break
    return result.lines


def test_topic_list_shows_exactly_the_topics_of_the_tutorial() -> None:
    with simulation("tutorial/flat_grid") as tool:
        assert listed(tool, PLAIN) == PLAIN


def test_topic_list_shows_exactly_the_namespaced_topics_and_what_robot_state_adds(tool: Tool) -> None:
    expected = sorted([*NAMESPACED, "/dd100_0000/robot_description"])
    assert listed(tool, expected) == expected


def test_one_twist_moves_the_robot(tool: Tool) -> None:
    def place() -> float:
        field = ("--field", "pose.pose.position.x", "--once", "--spin-time", "20")
        result = tool("topic", "echo", "/dd100_0000/odom", *field, code=0, err="")
        return float(result.out.removesuffix("\n---\n"))

    before = place()
    twist = "{linear: {x: 1.0}, angular: {z: 1.0}}"

    def moved() -> bool:
        published = tool("topic", "pub", "/dd100_0000/cmd_vel", "geometry_msgs/msg/Twist", twist, "--once")
        assert (published.code, published.err) == (0, "")
        assert published.out.startswith("publisher: beginning loop\npublishing #1: geometry_msgs.msg.Twist(linear=")
        return abs(place() - before) > 0.05

    # One that the robot's process has not found in time is lost, as it is with `ros2 topic pub`.
    assert any(moved() for _ in range(ATTEMPTS))


def test_echo_shows_the_scan_of_the_lidar(tool: Tool) -> None:
    result = tool("topic", "echo", "/dd100_0000/sim_lidar/scan", "--once", "--no-arr", "--spin-time", "20")
    assert "frame_id: sim_lidar\n" in result.out
    assert "ranges: '<sequence type: float, length: 2751>'\n" in result.out


def test_the_tf_tree_is_whole_with_the_robots_own_links(tool: Tool) -> None:
    for _ in range(ATTEMPTS):
        result = tool("tf", "tree", "--wait-time", "1", "--strict", "--namespace", "dd100_0000")
        if result.code == 0 and " Hz " in result.out:
            break
    assert (result.code, result.err.splitlines()[1:]) == (0, [])
    rows = [re.match(r"([│├└─ ]*)(\w+) ", f"{line} ") for line in result.lines[1:]]
    frames = [row[2] for row in rows if row]
    assert frames[0] == "odom"
    assert set(frames) == LINKS | {"odom", "sim_lidar"}
    assert len(frames) == len(set(frames)) == len(result.lines) - 1
    assert all(" /navigation " in line for line in result.lines[2:])
    assert re.search(r"└─ base_link +/navigation +[56]\d\.\d Hz ", result.out)
