"""ROS2SubscribeTwist."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.nodes.ros2.subscribers import ROS2SubscribeTwist
from graphengine.ros.network import LOOK_EVERY
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, ready, twist

STILL = (0.0, 0.0, 0.0)


def subscribing(context: RecordingContext, **inputs: Any) -> ROS2SubscribeTwist:
    return ready(ROS2SubscribeTwist, context, **inputs)


def hear(context: RecordingContext, *arriving: messages.Twist) -> None:
    """Let messages arrive, and begin a tick."""
    for message in arriving:
        context.transport.inject("/cmd_vel", message)
    context.tick()


def test_before_a_message_the_velocities_are_0_and_nothing_fires(context: RecordingContext) -> None:
    node = subscribing(context)
    hear(context)
    assert node.compute() is None
    assert (node.linear_velocity, node.angular_velocity) == (STILL, STILL)


numbers = st.floats(allow_nan=False, allow_infinity=False)


@given(linear=st.tuples(numbers, numbers, numbers), angular=st.tuples(numbers, numbers, numbers))
def test_the_first_message_is_delivered_whole_in_the_tick_that_sees_it(
    linear: tuple[float, float, float], angular: tuple[float, float, float]
) -> None:
    context = RecordingContext()
    node = subscribing(context)
    hear(context, messages.Twist(messages.Vector3(*linear), messages.Vector3(*angular)))
    assert node.compute() == node.exec_out
    assert (node.linear_velocity, node.angular_velocity) == (linear, angular)


@pytest.mark.parametrize("speed", [float("nan"), float("inf"), float("-inf")])
def test_a_twist_that_is_not_finite_is_dropped_and_told(speed: float, context: RecordingContext) -> None:
    node = subscribing(context)
    hear(context, twist(1.0, 2.0))
    node.compute()
    hear(context, twist(speed, 0.0))
    assert node.compute() is None
    assert (node.linear_velocity, node.angular_velocity) == ((1.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    assert context.logged == [("warning", "/cmd_vel: a Twist that is not finite was dropped")]


def test_what_arrives_during_a_tick_is_seen_in_the_next(context: RecordingContext) -> None:
    node = subscribing(context)
    context.tick()
    context.transport.inject("/cmd_vel", twist(1.0, 0.0))
    assert node.compute() is None
    context.tick()
    assert node.compute() == node.exec_out


# The command timeout


def test_without_a_timeout_a_command_holds_for_ever(context: RecordingContext) -> None:
    node = subscribing(context)
    hear(context, twist(1.0, 0.0))
    node.compute()
    context.tick(100_000)
    assert node.compute() is None
    assert node.linear_velocity == (1.0, 0.0, 0.0)


def run(context: RecordingContext, node: ROS2SubscribeTwist, ticks: int) -> list[bool]:
    """Whether each of the next ticks fires."""
    fired = []
    for _ in range(ticks):
        context.tick()
        fired.append(node.compute() is not None)
    return fired


def test_silence_for_the_timeout_zeroes_and_fires_once(context: RecordingContext) -> None:
    node = subscribing(context, timeout=0.5)
    hear(context, twist(1.0, 2.0))
    node.compute()
    assert run(context, node, 29) == [False] * 29
    assert node.linear_velocity == (1.0, 0.0, 0.0)
    assert run(context, node, 61) == [True] + [False] * 60  # 30 ticks of 1/60 s after the message, and no more
    assert (node.linear_velocity, node.angular_velocity) == (STILL, STILL)


def test_a_message_in_time_puts_the_timeout_off(context: RecordingContext) -> None:
    node = subscribing(context, timeout=0.5)
    for _ in range(5):
        hear(context, twist(1.0, 0.0))
        assert node.compute() == node.exec_out
        assert run(context, node, 20) == [False] * 20


def test_before_the_first_message_silence_is_no_timeout(context: RecordingContext) -> None:
    assert run(context, subscribing(context, timeout=0.1), 60) == [False] * 60


def test_a_message_after_a_timeout_is_a_command_again(context: RecordingContext) -> None:
    node = subscribing(context, timeout=0.5)
    for _ in range(2):
        hear(context, twist(1.0, 0.0))
        node.compute()
        assert node.linear_velocity == (1.0, 0.0, 0.0)
        assert sum(run(context, node, 60)) == 1
        assert node.linear_velocity == STILL


def test_a_stop_forgets_that_a_command_was_heard(context: RecordingContext) -> None:
    node = subscribing(context, timeout=0.5)
    context.tick(100)
    hear(context, twist(1.0, 0.0))
    node.compute()
    context.stop(node)
    assert run(context, node, 60) == [False] * 60


def test_a_negative_timeout_is_refused() -> None:
    with pytest.raises(ValueError, match="timeout: expected a value ≥ 0"):
        ROS2SubscribeTwist(timeout=-1.0)


# Twist or TwistStamped

TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"


def stamped(v: float, w: float) -> messages.TwistStamped:
    return messages.TwistStamped(messages.header(7.0, "base_link"), twist(v, w))


@pytest.mark.parametrize(
    ("kind", "message_type", "alternatives"),
    [("auto", TWIST, (STAMPED,)), ("twist", TWIST, ()), ("twist_stamped", STAMPED, ())],
)
def test_the_type_that_is_asked_for_is_read(kind: str, message_type: str, alternatives: tuple[str, ...]) -> None:
    context = RecordingContext()
    subscribing(context, type_in=kind)
    (claim,) = context.services.claims
    assert (claim.message_type, claim.alternatives) == (message_type, alternatives)


def test_a_stamped_twist_is_delivered_without_its_stamp(context: RecordingContext) -> None:
    node = subscribing(context, type_in="twist_stamped")
    context.transport.inject("/cmd_vel", stamped(1.0, 2.0))
    context.tick()
    assert node.compute() == node.exec_out
    assert (node.linear_velocity, node.angular_velocity) == ((1.0, 0.0, 0.0), (0.0, 0.0, 2.0))


def test_auto_takes_what_others_publish_and_goes_along_when_that_changes() -> None:
    context, heard = RecordingContext(), list[float]()
    node = subscribing(context)
    for number, (kind, message) in enumerate([(STAMPED, stamped(1.0, 0.0)), (TWIST, twist(2.0, 0.0))] * 2):
        writer = context.transport.writer("/cmd_vel", kind, QoS())
        context.tick(LOOK_EVERY)
        writer.write(messages.encode(message))
        context.tick()
        if node.compute():
            heard.append(node.linear_velocity[0])
        writer.close()
        assert len(heard) == number + 1
    assert heard == [1.0, 2.0, 1.0, 2.0]


def test_auto_stays_with_what_it_reads_for_as_long_as_that_is_published(context: RecordingContext) -> None:
    node = subscribing(context)
    for kind in (STAMPED, TWIST):
        context.transport.writer("/cmd_vel", kind, QoS())
    context.tick(2 * LOOK_EVERY)
    context.transport.inject("/cmd_vel", twist(1.0, 0.0))
    context.tick()
    assert node.compute() == node.exec_out


# In a graph

GRAPH = """
    nodes: {Tick: OnPlaybackTick, Twist: {type: SubscribeTwist, inputs: {timeout: 0.1}}, Heard: PublishClock}
    connections: [Tick.tick -> Twist.execIn, Twist.execOut -> Heard.execIn, Tick.frame -> Heard.timeStamp]
    """


def test_in_a_graph_what_hangs_on_it_runs_on_a_message_and_once_on_a_timeout(play: Player) -> None:
    playing = play.graph(GRAPH).tick(2)
    playing.transport.inject("/cmd_vel", twist(1.0, 0.0))
    playing.tick(20)
    # A message at tick 3, and 0.1 s or 6 ticks later silence.
    assert [m.clock.sec for m in playing.published("/clock")] == [3, 9]


def test_in_a_graph_bytes_that_are_no_twist_are_dropped_and_told_once(play: Player) -> None:
    playing = play.graph(GRAPH)
    for _ in range(2):
        playing.transport.inject("/cmd_vel", b"\x00\x01\x00\x00abc")
        playing.tick()
    assert playing.published("/clock") == []
    assert len(playing.complaints) == 1
    assert "/cmd_vel" in playing.complaints[0]
