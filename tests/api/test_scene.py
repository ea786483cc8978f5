"""Scenes that are loaded."""

from __future__ import annotations

import re
from typing import Any

import pytest

import graphengine as ge


@pytest.fixture(scope="module")
def scene() -> ge.Scene:
    return ge.load("dd100_flat", rays="mujoco")


def test_a_scene_lists_its_robots_graphs_and_topics(scene: ge.Scene) -> None:
    assert list(scene.graphs) == ["clock", "dd100/joint_states", "dd100/scan", "dd100/cmd_vel"]
    assert scene.graphs["dd100/cmd_vel"].nodes["ArtController"] == "isaacsim.core.nodes.IsaacArticulationController"
    assert scene.graphs["clock"].prim_path == "/World/clock"
    robot = scene.robots["dd100"]
    assert (robot.prim_path, robot.namespace) == ("/dd100", "dd100_0000")
    assert robot.joints == ("front_left_wheel_joint", "front_right_wheel_joint")
    topics = {claim.topic: claim.message_type for claim in scene.topics}
    assert topics["/dd100_0000/odom"] == "nav_msgs/msg/Odometry"
    assert not scene.findings
    assert repr(scene) == "<Scene dd100_flat: 4 graphs, robots: dd100>"


def test_values_are_set_as_the_command_line_sets_them() -> None:
    scene = ge.load("dd100_flat", set={"DiffController.maxLinearSpeed": 0.25})
    for seed in (0, 1):
        with scene.session(seed=seed) as sim:
            assert sim.value("DiffController.maxLinearSpeed") == 0.25


@pytest.mark.parametrize(
    ("address", "complaint"),
    [
        (
            "DiffController.linearVelocity",
            "dd100/cmd_vel/DiffController.linearVelocity is wired\n  only unwired inputs",
        ),
        ("*.execIn", "has no input 'execIn'|have no input 'execIn'"),
        ("substeps", "write NODE.PORT\nother values, such as those of physics and drives, are keys of"),
    ],
)
def test_setting_an_unknown_or_wired_input_is_refused(address: str, complaint: str) -> None:
    with pytest.raises(ge.UsageError, match=f"^--set {re.escape(address)}: .*(?:{complaint})"):
        ge.load("dd100_flat", set={address: 1.0})


def test_sessions_of_a_scene_are_apart(scene: ge.Scene) -> None:
    with scene.session() as one, scene.session() as other:
        one.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        one.run(1.0)
        other.run(1.0)
        assert one.robots["dd100"].pose.position[0] > 0.2
        assert abs(other.robots["dd100"].pose.position[0]) < 0.01


def test_errors_include_the_warnings_found_before_them() -> None:
    with pytest.raises(ge.CheckError) as caught:
        ge.load("tutorial/flat_grid", set={"D*Controller.maxLinearSpeed": "fast"})
    severities = [finding.severity for finding in caught.value.findings]
    assert (severities.count("error"), severities.count("note")) == (1, 6)
    assert "DiffController.maxLinearSpeed is a double: expected a number" in str(caught.value)


@pytest.mark.parametrize(
    ("source", "arguments", "words"),
    [
        ("dd100_flta", {}, "did you mean 'dd100_flat' or"),
        ("dd100_flat", {"set": {"DifController.maxLinearSpeed": 1.0}}, "no node 'DifController'"),
        ("dd100_flat", {"rays": "fats"}, "rays: unknown value 'fats'; legal: auto, mujoco, fast"),
        ("dd100_flat", {"allow": "/tmp"}, "allow: expected a list, got '/tmp'"),
        ("dd100_flat", {"allow": ["/nowhere"]}, "allow: there is no folder /nowhere"),
        ("dd100_flat", {"message_paths": ["/nowhere"]}, "message_paths: there is no folder or file /nowhere"),
        ("dd100_flat", {"modules": ["no_such_module"]}, "modules: No module named 'no_such_module'"),
    ],
)
def test_arguments_that_make_no_sense_are_usage_errors(source: str, arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ge.UsageError) as caught:
        ge.load(source, **arguments)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"record": "out.txt"}, "expected a file name that ends in .mcap, in an existing folder"),
        ({"simulation_interfaces": "two words"}, "namespace 'two words' has ' ' at character 4"),
        ({"domain": 1000}, "ROS domain id 1000 is out of range; legal: 0 to 232"),
        ({"bad_values": "keep"}, "bad_values: unknown value 'keep'; legal: drop, stop"),
    ],
)
def test_invalid_session_options_are_reported(scene: ge.Scene, arguments: dict[str, Any], words: str) -> None:
    with pytest.raises(ge.GraphError) as caught:
        scene.session(**arguments)
    assert words in str(caught.value)


def test_a_graph_that_needs_a_scene_is_refused_without_one() -> None:
    scene = ge.load("dd100/cmd_vel")
    with pytest.raises(ge.UsageError, match="uses prims of a scene"):
        scene.session()
