"""ForceTorquePublisher: each sample once, as geometry_msgs/WrenchStamped defines it."""

from __future__ import annotations

import pytest

from graphengine.devices.force_torque import ForceTorqueStub
from graphengine.format.diagnostics import CheckError
from graphengine.nodes.ros2.force_torque import ForceTorquePublisher
from graphengine.testing import RecordingContext, check_node
from tests.nodes.harness import Player, dd100

CHASSIS = "/dd100/Geometry/base_link/chassis_link"
GRAPH = """
nodes:
  Tick: OnPlaybackTick
  Wrist: {type: ForceTorquePublisher, inputs: {forceTorquePrim: PRIM, frameId: wrist, topicName: wrench}}
connections: [Tick.tick -> Wrist.execIn]
"""


def made() -> RecordingContext:
    context = RecordingContext()
    for path in ("/bot", "/bot/hand"):
        context.world.stage.add(path, "link")
    context.world.add_device(ForceTorqueStub, "/bot/hand/Wrist")
    return context


def test_check_node_accepts_the_force_torque_publisher() -> None:
    check_node(ForceTorquePublisher, made, force_torque_prim=["/bot/hand/Wrist"])


def test_a_sample_is_sent_once_with_its_stamp_and_frame(play: Player) -> None:
    world = dd100()
    sensor = world.add_device(ForceTorqueStub, f"{CHASSIS}/wrist")
    sensor.measure((1.0, 2.0, 3.0), (4.0, 5.0, 6.0), time=0.25, index=7)
    (message,) = play.graph(GRAPH.replace("PRIM", f"{CHASSIS}/wrist"), world).tick(3).published("/dd100_0000/wrench")
    stamp, force, torque = message.header.stamp, message.wrench.force, message.wrench.torque
    assert (message.header.frame_id, stamp.sec, stamp.nanosec) == ("wrist", 0, 250_000_000)
    assert (force.x, force.y, force.z) == (1.0, 2.0, 3.0)
    assert (torque.x, torque.y, torque.z) == (4.0, 5.0, 6.0)


def test_a_check_finds_a_sensor_on_the_root_link(play: Player) -> None:
    scene = {
        "bot.yaml": """
            robot: bot
            extends: robots/dd100.yaml
            sensors: {wrist: {type: force_torque, parent: base_link}}
            graphs: {wrist: {use: graphs/publishers/force_torque.yaml, parameters: {sensor: base_link/wrist}}}
        """,
        "scene.yaml": """
            scene: scene
            world: worlds/flat_grid.xml
            robots: {dd100: {use: bot.yaml}}
        """,
    }
    with pytest.raises(CheckError, match="/dd100/Geometry/base_link/wrist has no joint above it"):
        play.scene(scene)


def test_a_robot_in_a_scene_publishes_the_weight_that_its_joint_carries(play: Player) -> None:
    playing = play.scene(
        {
            "bot.urdf": """
                <robot name="bot"><link name="base_link"/><link name="tool">
                <inertial><origin xyz="0.5 0 0"/><mass value="2"/>
                <inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
                <joint name="wrist" type="fixed"><parent link="base_link"/><child link="tool"/></joint></robot>
            """,
            "bot.yaml": """
                robot: bot
                urdf: bot.urdf
                fixed_base: true
                sensors: {ft: {type: force_torque, parent: tool}}
                graphs:
                  ft: {use: graphs/publishers/force_torque.yaml, parameters: {sensor: base_link/tool/ft, frame: tool}}
            """,
            "scene.yaml": """
                scene: scene
                world: worlds/flat_grid.xml
                robots: {bot: {use: bot.yaml, position: [0, 0, 1]}}
            """,
        }
    ).tick(60)
    wrenches = playing.published("/wrench")
    assert len(wrenches) == 60
    assert wrenches[-1].wrench.force.z == pytest.approx(-2.0 * 9.81)
    assert wrenches[-1].wrench.torque.y == pytest.approx(0.5 * 2.0 * 9.81)  # r x F
