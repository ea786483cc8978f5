"""Cases of ROS2SubscribeJointState."""

from __future__ import annotations

import numpy as np
import pytest

from graphengine.messages import messages
from graphengine.nodes.ros2.subscribers import ROS2SubscribeJointState
from graphengine.testing import RecordingContext
from tests.nodes import scenes
from tests.nodes.harness import Player, ready
from tests.nodes.isaac.book import Case, runs

SUBSCRIBER = "isaacsim.ros2.bridge.ROS2SubscribeJointState"
JOINTS = ["CenterRevoluteJoint", "PrismaticJoint", "DistalRevoluteJoint"]
GRAPH = """
    graph: graph
    nodes:
      Tick: OnPlaybackTick
      Commands: SubscribeJointState
      Control: {type: ArticulationController, inputs: {targetPrim: /robot}}
      States: {type: PublishJointState, inputs: {targetPrim: /robot}}
    connections:
      - Tick.tick -> Commands.execIn
      - Tick.tick -> States.execIn
      - Commands.execOut -> Control.execIn
      - Commands.jointNames -> Control.jointNames
      - Commands.positionCommand -> Control.positionCommand
      - Commands.velocityCommand -> Control.velocityCommand
      - Commands.effortCommand -> Control.effortCommand
    """


def command(case: Case) -> messages.JointState:
    """The message of a case; arrays that it does not have are empty."""
    arrays = (np.array(case["inputs"].get(name, ()), np.float64) for name in ("position", "velocity", "effort"))
    return messages.JointState(messages.header(1.5, ""), JOINTS, *arrays)


@runs(SUBSCRIBER, "all arrays")
def all_arrays_come_through(case: Case, play: Player) -> None:
    context = RecordingContext()
    node = ready(ROS2SubscribeJointState, context)
    context.transport.inject("/joint_command", command(case))
    context.tick()
    assert node.compute() == node.exec_out
    assert (node.joint_names, node.time_stamp) == (tuple(JOINTS), 1.5)
    for name, output in (
        ("position", "position_command"),
        ("velocity", "velocity_command"),
        ("effort", "effort_command"),
    ):
        assert getattr(node, output).tolist() == pytest.approx(case["inputs"][name], abs=case["tolerance"])


@runs(SUBSCRIBER, "missing arrays become NaN and are skipped by the articulation controller")
def what_is_missing_is_left_alone(case: Case, play: Player) -> None:
    playing = play.scene({**scenes.arm(JOINTS, stiffness=2000.0, damping=200.0), "graph.yaml": GRAPH})
    playing.transport.inject("/joint_command", command(case))
    playing.tick(120)
    commands = playing.node("Commands")
    assert np.isnan(commands.velocity_command).tolist() == np.isnan(commands.effort_command).tolist() == [True] * 3
    position = playing.published("/joint_states")[-1].position.tolist()
    assert position == pytest.approx(case["inputs"]["position"], abs=case["expect"]["robot reaches position"])
