"""Nodes that measure joints take the names of actuators that move one, and refuse those of others with a reason."""

from __future__ import annotations

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import NodeError
from tests.nodes.harness import Player
from tests.physics.mjcf_models import KITCHEN_SINK

SCENE = """
    format: 1
    scene: case
    world: worlds/flat_grid.xml
    physics: {tick_rate: 60, substeps: 4}
    robots: {bot: {use: bot.xml}}
    graphs: {graph: {use: graph.yaml}}
"""
GRAPH = """
    format: 1
    graph: graph
    at: /World/graph
    nodes:
      Tick: omni.graph.action.OnPlaybackTick
      Node: {type: %s, inputs: {%s}}
    connections: [Tick.tick -> Node.execIn]
"""
NODES = [
    ("graphengine.ros2.ROS2GripperCommand", "targetPrim: /bot, jointName: {}"),
    ("graphengine.ros2.ROS2FollowJointTrajectory", "targetPrim: /bot, jointNames: [{}]"),
    (
        "isaacsim.robot.manipulators.IsaacGripperController",
        "articulationRootPrim: /bot, jointNames: [{}], gripperSpeed: [0.01]",
    ),
]


@pytest.mark.parametrize(("node", "inputs"), NODES)
def test_the_name_of_an_actuator_selects_its_joint(play: Player, node: str, inputs: str) -> None:
    elbow = KITCHEN_SINK.replace('name="pan" joint="pan"', 'name="pan_servo" joint="pan"')
    files = {"bot.xml": elbow, "scene.yaml": SCENE, "graph.yaml": GRAPH % (node, inputs.format("pan_servo"))}
    play.scene(files).tick(2)


@pytest.mark.parametrize(("node", "inputs"), NODES)
def test_an_actuator_that_moves_several_joints_or_none_is_refused(play: Player, node: str, inputs: str) -> None:
    files = {"bot.xml": KITCHEN_SINK, "scene.yaml": SCENE, "graph.yaml": GRAPH % (node, inputs.format("gripper"))}
    with pytest.raises((CheckError, NodeError), match="does not move exactly one joint"):
        play.scene(files).tick(2)
