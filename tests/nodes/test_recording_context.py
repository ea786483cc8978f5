"""The context that all other tests of nodes stand on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.devices.dry_world import BodyStub
from graphengine.devices.lidar import Lidar, LidarStub
from graphengine.devices.motion import Articulation, Body, Frame, JointSelection
from graphengine.devices.rotation import Vector3
from graphengine.format.errors import ContextError, PrimError, TransportError
from graphengine.node import Context
from graphengine.node.variable import Variable
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import matrix, twist, yaw

NAN = math.nan


def test_the_recording_context_fulfils_the_protocols_of_nodes() -> None:
    context: Context = RecordingContext()
    world = RecordingWorld()
    world.add_body("/body")
    articulation: Articulation = world.add_robot("/robot", ["joint"])
    selection: JointSelection = articulation.select()
    lidar: Lidar = world.add_device(LidarStub, "/lidar")
    body: Body = world.body(world.stage.find("/body"))
    frame: Frame = world.frame(world.stage.find("/robot/base_link"))
    assert (context.clock.time, selection.names, lidar.due, body.pose()) == (0.0, ("joint",), False, frame.pose())


def test_a_body_is_where_the_test_puts_it() -> None:
    world = RecordingWorld()
    body = world.add_body("/body", (1.0, 2.0, 3.0))
    body.linear = (4.0, 5.0, 6.0)
    handle = world.body(world.stage.find("/body"))
    assert handle is body
    assert handle.pose()[0] == (1.0, 2.0, 3.0)
    assert handle.velocity() == ((4.0, 5.0, 6.0), (0.0, 0.0, 0.0))


numbers = st.floats(-10.0, 10.0)
vectors = st.tuples(numbers, numbers, numbers)


@given(angle=st.floats(-3.0, 3.0), place=vectors, arm=vectors, linear=vectors, angular=vectors)
def test_a_carried_prim_has_the_velocity_v_plus_w_x_r(
    angle: float, place: Vector3, arm: Vector3, linear: Vector3, angular: Vector3
) -> None:
    world = RecordingWorld()
    body = world.add_body("/body", place, yaw(angle))
    body.linear, body.angular = linear, angular
    world.stage.add("/body/mount/sensor", "frame", position=arm)
    sensor = world.body(world.stage.find("/body/mount/sensor"))
    r = matrix(yaw(angle)) @ arm
    assert np.allclose(sensor.pose()[0], np.add(place, r), atol=1e-9)
    assert np.allclose(sensor.velocity()[0], np.add(linear, np.cross(angular, r)), atol=1e-9)
    assert sensor.velocity()[1] == angular


def test_a_robots_motion_carries_all_of_its_links() -> None:
    world = RecordingWorld()
    world.add_robot("/robot")
    world.stage.add("/robot/Geometry/base_link/mast", "link", position=(0.0, 0.0, 1.0))
    robot: BodyStub = world.body(world.stage.find("/robot"))
    robot.position = (5.0, 0.0, 0.0)
    assert world.frame(world.stage.find("/robot/base_link/mast")).pose()[0] == (5.0, 0.0, 1.0)


def test_commands_set_the_targets_that_are_not_nan() -> None:
    robot = RecordingWorld().add_robot("/robot", ["a", "b", "c"])
    robot.select(["c", "a"]).command(velocities=[3.0, 1.0])
    robot.select(indices=[0]).command(positions=[NAN], velocities=[2.0])
    assert np.array_equal(robot.targets["velocity"], [2.0, NAN, 3.0], equal_nan=True)
    assert np.array_equal(robot.targets["position"], [NAN] * 3, equal_nan=True)


def test_a_robots_state_is_set_by_the_test_and_every_reading_is_a_new_array() -> None:
    robot = RecordingWorld().add_robot("/robot", ["a", "b"])
    robot.state["effort"] = [1, 2]
    assert (robot.positions().tolist(), robot.velocities().tolist(), robot.efforts().tolist()) == (
        [0, 0],
        [0, 0],
        [1, 2],
    )
    assert robot.efforts() is not robot.efforts()


def test_a_command_of_the_wrong_length_raises_an_error() -> None:
    with pytest.raises(ValueError, match="zip"):
        RecordingWorld().add_robot("/robot", ["a", "b"]).select().command(velocities=[1.0])


def test_a_lidar_stub_returns_the_scan_of_the_test_and_counts_its_calls() -> None:
    lidar = RecordingWorld().add_device(LidarStub, "/lidar", angles=(0.0, 1.0, 0.5))
    assert np.isinf(lidar.scan().ranges).tolist() == [True] * 3
    lidar.see([1.0, 2.0, 3.0], 9.0, time=0.5, index=4)
    scan = lidar.scan()
    assert (scan.time, scan.index, scan.ranges.tolist(), scan.intensities.tolist()) == (0.5, 4, [1, 2, 3], [9, 9, 9])
    assert (lidar.due, lidar.casts) == (True, 2)


def test_messages_are_encoded_and_read_back() -> None:
    context = RecordingContext("/World/graph/node")
    publisher = context.publisher("geometry_msgs/msg/Twist", "cmd_vel")
    assert publisher.wanted
    publisher.publish(twist(1.0, 2.0))
    (message,) = context.transport.messages("/cmd_vel")
    assert (message.linear.x, message.angular.z) == (1.0, 2.0)


def test_a_topic_is_wanted_once_it_has_a_subscriber() -> None:
    context = RecordingContext(wanted=False)
    publisher = context.publisher("geometry_msgs/msg/Twist", "cmd_vel")
    assert not publisher.wanted
    context.subscription("geometry_msgs/msg/Twist", "cmd_vel")
    assert publisher.wanted


def test_messages_arrive_in_the_next_tick_up_to_the_depth_of_the_queue(context: RecordingContext) -> None:
    subscription = context.subscription("geometry_msgs/msg/Twist", "cmd_vel", queue_size=2)
    for speed in (1.0, 2.0, 3.0):
        context.transport.inject("/cmd_vel", twist(speed, 0.0))
    assert list(subscription.take()) == []
    context.tick()
    assert [message.linear.x for message in subscription.take()] == [2.0, 3.0]


def test_feeding_a_topic_without_subscription_is_an_error() -> None:
    with pytest.raises(TransportError, match="/cmd_vel has no readers"):
        RecordingContext().transport.inject("/cmd_vel", twist(1.0, 0.0))


def test_ticks_move_time_mailboxes_and_variables(context: RecordingContext) -> None:
    context.variables["speed"] = Variable(1.0)
    mailbox, variable = context.mailbox("event"), context.variable("speed")
    mailbox.post("now")
    variable.value = 2.0
    assert list(mailbox.take()) == []
    context.tick()
    assert list(mailbox.take()) == ["now"]
    assert (variable.value, variable.changed, context.clock.frame) == (2.0, True, 1)
    context.tick(59)
    assert (variable.changed, context.clock.time) == (False, 1.0)


def test_an_unknown_variable_or_prim_raises_the_error_of_the_engine() -> None:
    with pytest.raises(ContextError, match="no variable 'speed'"):
        RecordingContext().variable("speed")
    with pytest.raises(PrimError, match="/nowhere"):
        RecordingContext().body("/nowhere")


def test_log_messages_of_a_node_are_recorded(context: RecordingContext) -> None:
    context.log("warning", "careful")
    assert context.logged == [("warning", "careful")]


def test_undecodable_bytes_are_logged(context: RecordingContext) -> None:
    subscription = context.subscription("geometry_msgs/msg/Twist", "cmd_vel")
    context.transport.inject("/cmd_vel", b"\x00\x01\x00\x00")
    context.tick()
    assert subscription.newest() is None
    assert [severity for severity, _ in context.logged] == ["network"]
