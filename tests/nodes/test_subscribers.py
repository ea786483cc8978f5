"""Subscribers of one kind of message: clocks, commands for joints, commands for a vehicle that steers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.compiler.registry import default_registry
from graphengine.format.errors import TopicError
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.nodes.ros2.subscribers import (
    ROS2SubscribeAckermannDrive,
    ROS2SubscribeClock,
    ROS2SubscribeJointState,
    ROS2SubscribeTwist,
    SubscriberNode,
)
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, ready, twist

HEAD = messages.header(1.25, "base")
NONE = np.zeros(0)


def joints(*arrays: Any, names: tuple[str, ...] = ("left", "right")) -> messages.JointState:
    """A command; arrays are positions, velocities, efforts."""
    return messages.JointState(HEAD, list(names), *(np.array(array, np.float64) for array in arrays))


def drive(*numbers: float) -> Any:
    """A command; numbers are steering angle and velocity, speed, acceleration, jerk."""
    command = messages.message_class("ackermann_msgs/msg/AckermannDrive")(*numbers)
    return messages.message_class("ackermann_msgs/msg/AckermannDriveStamped")(HEAD, command)


SUBSCRIBERS: dict[type[SubscriberNode], tuple[str, Any, Any]] = {
    ROS2SubscribeTwist: ("cmd_vel", twist(1.0, 2.0), twist(3.0, 0.0)),
    ROS2SubscribeClock: ("clock", messages.Clock(messages.stamp(2.5)), messages.Clock(messages.stamp(1.0))),
    ROS2SubscribeJointState: ("joint_command", joints([1, 2], [3, 4], [5, 6]), joints([7, 8], [], [])),
    ROS2SubscribeAckermannDrive: ("ackermann_cmd", drive(0.5, 0.25, 2.0, 1.0, 0.125), drive(1.0, 1.0, 1.0, 1.0, 1.0)),
}
"""Default topics, a message, and another."""
every_subscriber = pytest.mark.parametrize("cls", SUBSCRIBERS)


def hear(context: RecordingContext, node: SubscriberNode, *arriving: Any) -> int | None:
    """Let messages arrive, begin a tick, and run."""
    for message in arriving:
        context.transport.inject(f"/{SUBSCRIBERS[type(node)][0]}", message)
    context.tick()
    return node.compute()


def outputs(node: Any) -> list[Any]:
    """Values of all outputs, for comparison."""
    found = [getattr(node, port.field) for port in node.fields.values() if port.side == "outputs" and not port.is_exec]
    return [value.tolist() if isinstance(value, np.ndarray) else value for value in found]


# What all of them have in common


def test_the_tests_of_this_file_cover_every_subscriber_of_one_message_type() -> None:
    assert {cls for cls in default_registry().types.values() if issubclass(cls, SubscriberNode)} == set(SUBSCRIBERS)


@every_subscriber
def test_the_default_topic_is_isaac_sims(cls: type[SubscriberNode], context: RecordingContext) -> None:
    ready(cls, context)
    (claim,) = context.services.claims
    assert (claim.topic, claim.direction) == (f"/{SUBSCRIBERS[cls][0]}", "subscribe")


@every_subscriber
def test_a_subscriber_fires_only_in_ticks_with_a_message(cls: type[SubscriberNode], context: RecordingContext) -> None:
    node = ready(cls, context)
    assert hear(context, node) is None
    assert hear(context, node, SUBSCRIBERS[cls][1]) == node.exec_out
    assert hear(context, node) is None


@every_subscriber
def test_outputs_keep_their_values_until_a_stop(cls: type[SubscriberNode], context: RecordingContext) -> None:
    node = ready(cls, context)
    before = outputs(node)
    hear(context, node, SUBSCRIBERS[cls][1])
    delivered = outputs(node)
    assert delivered != before
    hear(context, node)
    assert outputs(node) == delivered
    context.stop(node)
    assert outputs(node) == before


@every_subscriber
def test_only_the_newest_of_several_messages_is_output_and_the_others_are_counted(cls: type[SubscriberNode]) -> None:
    context, alone = RecordingContext(), RecordingContext()
    node, spared = ready(cls, context), ready(cls, alone)
    _, message, other = SUBSCRIBERS[cls]
    assert hear(context, node, other, other, message) == hear(alone, spared, message) == node.exec_out
    assert outputs(node) == outputs(spared)
    assert node.subscription.skipped == 2
    assert hear(context, node) is None


@every_subscriber
def test_the_qos_comes_from_the_inputs(cls: type[SubscriberNode], context: RecordingContext) -> None:
    ready(cls, context, queue_size=3)
    ready(cls, context, queue_size=3, qos_profile='{"depth": 1, "reliability": "bestEffort"}')
    assert [claim.qos for claim in context.services.claims] == [QoS(depth=3), QoS(depth=1, reliability="bestEffort")]


@every_subscriber
def test_the_namespace_is_collected_from_the_ancestors_of_the_node_unless_given(cls: type[SubscriberNode]) -> None:
    context = RecordingContext("/robot/graph/Subscribe")
    context.world.add_robot("/robot")
    context.world.stage.find("/robot").namespace = "robot_1"
    for given in ("", "given"):
        ready(cls, context, topic_name="/up/down", node_namespace=given)
    assert [claim.topic for claim in context.services.claims] == ["/robot_1/up/down", "/given/up/down"]


@every_subscriber
@pytest.mark.parametrize("inputs", [{"topic_name": ""}, {"topic_name": "a b"}, {"qos_profile": "{"}])
def test_illegal_names_and_profiles_are_refused_in_setup(cls: type[SubscriberNode], inputs: dict[str, str]) -> None:
    with pytest.raises(TopicError):
        ready(cls, RecordingContext(), **inputs)


# The clock


@pytest.mark.parametrize(("sec", "nanosec", "seconds"), [(0, 0, 0.0), (2, 500_000_000, 2.5), (-1, 750_000_000, -0.25)])
def test_a_clock_is_output_in_seconds(sec: int, nanosec: int, seconds: float, context: RecordingContext) -> None:
    node = ready(ROS2SubscribeClock, context)
    hear(context, node, messages.Clock(messages.Time(sec, nanosec)))
    assert node.time_stamp == seconds


# Commands for joints


def test_a_joint_command_is_output_with_joint_names_and_time(context: RecordingContext) -> None:
    node = ready(ROS2SubscribeJointState, context)
    hear(context, node, joints([1, 2], [3, 4], [5, 6]))
    assert outputs(node) == [1.25, ("left", "right"), [1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]
    assert node.position_command.dtype == np.float64


@pytest.mark.parametrize("velocities", [[], [1.0], [1.0, 2.0, 3.0]])
def test_an_array_without_one_number_per_joint_is_output_as_nan(velocities: list[float]) -> None:
    context = RecordingContext()
    node = ready(ROS2SubscribeJointState, context)
    assert hear(context, node, joints([1, 2], velocities, [])) == node.exec_out
    assert node.position_command.tolist() == [1.0, 2.0]
    assert np.isnan([node.velocity_command, node.effort_command]).all()
    assert len(node.velocity_command) == len(node.effort_command) == 2


@pytest.mark.parametrize(
    ("message", "told"),
    [
        (joints([], [], [], names=()), "a JointState without joints"),
        (joints([1, 2], [], [], names=()), "a JointState without joints"),
        (joints([1], [], [1, 2, 3]), "a JointState of 2 joints with 1, 0, 3 positions, velocities and efforts"),
        (joints([1, math.inf], [], []), "a JointState with an infinite number"),
        (joints([1, 2], [], [-math.inf, 0]), "a JointState with an infinite number"),
    ],
)
def test_an_empty_or_infinite_joint_command_is_dropped_and_logged(message: Any, told: str) -> None:
    context = RecordingContext()
    node = ready(ROS2SubscribeJointState, context)
    hear(context, node, joints([1, 2], [3, 4], [5, 6]))
    before = outputs(node)
    assert hear(context, node, message) is None
    assert outputs(node) == before
    assert context.logged == [("warning", f"/joint_command: {told} was dropped")]


def test_dropped_commands_are_counted_and_logged_at_counts_that_double(context: RecordingContext) -> None:
    node = ready(ROS2SubscribeJointState, context)
    for _ in range(9):
        hear(context, node, joints([1], [], [1, 2, 3]))
    fault = "/joint_command: a JointState of 2 joints with 1, 0, 3 positions, velocities and efforts was dropped"
    others = ["", *(f", as in {before} of the ticks before" for before in (1, 3, 7))]
    assert context.logged == [("warning", fault + other) for other in others]
    assert context.services.dropped is not None
    assert list(context.services.dropped.ticks.values()) == [9]


def test_nan_in_a_joint_command_is_output(context: RecordingContext) -> None:
    node = ready(ROS2SubscribeJointState, context)
    assert hear(context, node, joints([math.nan, 2], [], [])) == node.exec_out
    assert np.isnan(node.position_command).tolist() == [True, False]


# Commands for a vehicle that steers


def test_a_drive_command_is_output_completely(context: RecordingContext) -> None:
    node = ready(ROS2SubscribeAckermannDrive, context)
    hear(context, node, drive(0.5, 0.25, 2.0, 1.0, 0.125))
    assert outputs(node) == ["base", 1.25, 0.5, 0.25, 2.0, 1.0, 0.125]


@pytest.mark.parametrize("place", range(5))
def test_a_drive_command_that_is_not_finite_is_dropped_and_logged(place: int, context: RecordingContext) -> None:
    node = ready(ROS2SubscribeAckermannDrive, context)
    numbers = [0.5, 0.25, 2.0, 1.0, 0.125]
    numbers[place] = math.nan
    assert hear(context, node, drive(*numbers)) is None
    assert context.logged == [("warning", "/ackermann_cmd: an AckermannDrive that is not finite was dropped")]


GRAPH = """
    nodes:
      Tick: OnPlaybackTick
      Hear: SubscribeAckermannDrive
      Say: {type: PublishAckermannDrive, inputs: {topicName: echo}}
    connections:
      - Tick.tick -> Hear.execIn
      - Hear.execOut -> Say.execIn
      - Hear.frameId -> Say.frameId
      - Hear.timeStamp -> Say.timeStamp
      - Hear.steeringAngle -> Say.steeringAngle
      - Hear.steeringAngleVelocity -> Say.steeringAngleVelocity
      - Hear.speed -> Say.speed
      - Hear.acceleration -> Say.acceleration
      - Hear.jerk -> Say.jerk
    """


def test_in_a_graph_a_drive_command_is_published_as_received(play: Player) -> None:
    playing = play.graph(GRAPH)
    playing.transport.inject("/ackermann_cmd", drive(0.1, 0.2, 0.3, 0.4, 0.5))
    playing.tick(2)
    assert playing.transport.raw("/echo") == [messages.encode(drive(0.1, 0.2, 0.3, 0.4, 0.5))]
