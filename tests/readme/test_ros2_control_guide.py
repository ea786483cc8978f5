"""The files and commands of docs/guide/ros2_control_and_moveit.md, with the tests' arm."""

from __future__ import annotations

import shlex
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

import graphengine as ge
from graphengine.bringup.robots import topic_based
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.messages import goals
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.message_input import parse
from graphengine.physics.loading import load_robot_file
from tests import arm_robot
from tests.action_peer import ActionPeer
from tests.cli.harness import ROOT
from tests.nodes.harness import Player, Playing
from tests.readme.test_readme import blocks

GUIDE = (ROOT / "docs/guide/ros2_control_and_moveit.md").read_text(encoding="utf-8")
OWN, MOVEIT, OVER_TOPICS, CONTROLLERS, BASE, BASE_CONTROLLERS = (yaml.safe_load(text) for text in blocks(GUIDE, "yaml"))
XML, BASE_XML = blocks(GUIDE, "xml")
COMMANDS = [
    shlex.split(line)
    for block in blocks(GUIDE, "sh")
    for line in block.splitlines()
    if line.startswith("ros2 action send_goal")
]
SCENE = """
    format: 1
    scene: arm
    world: worlds/flat_grid.xml
    physics: {tick_rate: 60, substeps: 4}
    robots: {arm: {use: arm.yaml}}
"""


@pytest.fixture
def play(tmp_path: Path) -> Iterator[Player]:
    player = Player(tmp_path)
    yield player
    player.close()


def running(play: Player, graphs: Any) -> Playing:
    """A scene of the arm whose robot file has these graphs."""
    robot = arm_robot.robot_file() + yaml.safe_dump(graphs)
    return play.scene({"arm.urdf": arm_robot.urdf(), "arm.yaml": robot, "scene.yaml": SCENE})


def test_the_commands_move_the_arm_and_the_gripper(play: Player) -> None:
    playing = running(play, OWN)
    assert len(COMMANDS) == 2
    for words in COMMANDS:
        *_, action, action_type, goal = words
        peer, identity = ActionPeer(playing.transport, action, action_type), uuid.uuid4()
        message = parse(goal, f"{action_type}_Goal").message
        fields = [name for name, _ in DEFINITIONS.fields(f"{action_type}_Goal")]
        peer.send(identity, **{name: getattr(message, name) for name in fields})
        playing.tick()
        peer.ask_result(identity)
        playing.tick(180)
        assert [result.status for result in peer.results] == [goals.SUCCEEDED], action


def test_moveit_finds_the_actions_of_its_controllers(play: Player) -> None:
    playing = running(play, OWN)
    served = {claim.topic: claim.message_type for claim in playing.session.services.claims if claim.is_service}
    manager = MOVEIT["moveit_simple_controller_manager"]
    for name in manager["controller_names"]:
        controller = manager[name]
        service = f"/{name}/{controller['action_ns']}/_action/send_goal"
        assert served[service] == f"control_msgs/action/{controller['type']}_SendGoal"
        assert set(controller["joints"]) <= {*arm_robot.JOINTS, arm_robot.FINGER}


def test_the_graphs_have_the_topics_of_the_element(play: Player) -> None:
    playing = running(play, OVER_TOPICS)
    topics = {claim.direction: claim.topic for claim in playing.session.services.claims}
    assert f'<param name="joint_states_topic">{topics["publish"]}</param>' in XML
    assert f'<param name="joint_commands_topic">{topics["subscribe"]}</param>' in XML
    robot = load_robot_file(play.folder / "arm.yaml", Files.of(play.folder / "arm.yaml"), Findings())
    assert robot is not None
    assert topic_based.block("arm", list(robot.description.joints.values()), robot.starts).startswith(XML)


def test_the_controllers_command_the_interfaces_of_the_element() -> None:
    parameters = CONTROLLERS["joint_trajectory_controller"]["ros__parameters"]
    assert parameters["joints"] == list(arm_robot.JOINTS)
    for kind in ("command", "state"):
        for name in parameters[f"{kind}_interfaces"]:
            assert f'<{kind}_interface name="{name}"' in XML


def test_a_base_is_driven_by_the_commands_of_its_element(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text(yaml.safe_dump(BASE), encoding="utf-8")
    scene = {"scene": "base", "world": "worlds/flat_grid.xml", "robots": {"base": {"use": "base.yaml"}}}
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(scene | {"settle": True}), encoding="utf-8")
    parameters = BASE_CONTROLLERS["diff_drive_controller"]["ros__parameters"]
    wheels = [*parameters["left_wheel_names"], *parameters["right_wheel_names"]]
    with ge.load(tmp_path / "scene.yaml").session() as sim:
        commands, states = (f"/dd100_0000/topic_based_joint_{what}" for what in ("commands", "states"))
        assert f'<param name="joint_commands_topic">{commands}</param>' in BASE_XML
        assert f'<param name="joint_states_topic">{states}</param>' in BASE_XML
        received = sim.subscribe(states)
        speed = 0.5 / parameters["wheel_radius"]
        sim.publish(commands, {"name": wheels, "velocity": [speed, speed]}, every=0.05)
        sim.run(2.0)
        assert [name for name in wheels if f'<joint name="{name}">' not in BASE_XML] == []
        assert received.latest is not None
        assert list(received.latest.name) == wheels
        assert sim.robots["base"].velocity.linear[0] == pytest.approx(0.5, rel=0.01)
