"""ROS2SubscribeTwist."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.devices.rotation import Vector3
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.nodes.ros2.subscribers import ROS2SubscribeTwist
from graphengine.ros.network import LOOK_EVERY
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, ready, twist

STILL = (0.0, 0.0, 0.0)


class Listening:
    """A node that listens to /cmd_vel."""

    def __init__(self, **inputs: Any) -> None:
        self.context = RecordingContext()
        self.node = ready(ROS2SubscribeTwist, self.context, **inputs)

    def hears(self, *arriving: Any) -> bool:
        """Whether the node fires in a tick before which these messages arrive."""
        for message in arriving:
            self.context.transport.inject("/cmd_vel", message)
        self.context.tick()
        return self.node.compute() == self.node.exec_out

    def silence(self, ticks: int) -> list[bool]:
        """Whether each of the next ticks fires."""
        return [self.hears() for _ in range(ticks)]

    @property
    def velocities(self) -> tuple[Vector3, Vector3]:
        return self.node.linear_velocity, self.node.angular_velocity


def test_before_a_message_the_velocities_are_0_and_nothing_fires() -> None:
    listening = Listening()
    assert not listening.hears()
    assert listening.velocities == (STILL, STILL)


numbers = st.floats(allow_nan=False, allow_infinity=False)
vectors = st.tuples(numbers, numbers, numbers)


@given(linear=vectors, angular=vectors)
def test_the_first_message_is_output_completely_in_its_tick(linear: Vector3, angular: Vector3) -> None:
    listening = Listening()
    assert listening.hears(messages.Twist(messages.Vector3(*linear), messages.Vector3(*angular)))
    assert listening.velocities == (linear, angular)


@pytest.mark.parametrize("speed", [float("nan"), float("inf"), float("-inf")])
def test_a_twist_that_is_not_finite_is_dropped_and_logged(speed: float) -> None:
    listening = Listening()
    assert [listening.hears(twist(1.0, 2.0)), listening.hears(twist(speed, 0.0))] == [True, False]
    assert listening.velocities == ((1.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    assert listening.context.logged == [("warning", "/cmd_vel: a Twist that is not finite was dropped")]


# The command timeout


def test_without_a_timeout_a_command_holds_for_ever() -> None:
    listening = Listening()
    listening.hears(twist(1.0, 0.0))
    listening.context.tick(100_000)
    assert not listening.hears()
    assert listening.velocities == ((1.0, 0.0, 0.0), STILL)


def test_silence_for_the_timeout_zeroes_and_fires_once() -> None:
    listening = Listening(timeout=0.5)
    listening.hears(twist(1.0, 2.0))
    assert listening.silence(29) == [False] * 29
    assert listening.velocities == ((1.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    assert listening.silence(61) == [True] + [False] * 60  # 30 ticks of 1/60 s after the message, and no more
    assert listening.velocities == (STILL, STILL)


def test_a_message_before_the_timeout_restarts_the_timeout() -> None:
    listening = Listening(timeout=0.5)
    for _ in range(5):
        assert listening.hears(twist(1.0, 0.0))
        assert listening.silence(20) == [False] * 20


def test_before_the_first_message_silence_is_no_timeout() -> None:
    assert Listening(timeout=0.1).silence(60) == [False] * 60


def test_a_message_after_a_timeout_sets_the_velocities_again() -> None:
    listening = Listening(timeout=0.5)
    for _ in range(2):
        listening.hears(twist(1.0, 0.0))
        assert listening.velocities == ((1.0, 0.0, 0.0), STILL)
        assert sum(listening.silence(60)) == 1
        assert listening.velocities == (STILL, STILL)


def test_a_stop_ends_the_wait_for_the_timeout() -> None:
    listening = Listening(timeout=0.5)
    listening.context.tick(100)
    listening.hears(twist(1.0, 0.0))
    listening.context.stop(listening.node)
    assert listening.silence(60) == [False] * 60


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
def test_only_messages_of_the_selected_type_are_read(
    kind: str, message_type: str, alternatives: tuple[str, ...]
) -> None:
    (claim,) = Listening(type_in=kind).context.services.claims
    assert (claim.message_type, claim.alternatives) == (message_type, alternatives)


def test_a_stamped_twist_is_delivered_without_its_stamp() -> None:
    listening = Listening(type_in="twist_stamped")
    assert listening.hears(stamped(1.0, 2.0))
    assert listening.velocities == ((1.0, 0.0, 0.0), (0.0, 0.0, 2.0))


def test_auto_reads_the_type_of_the_publisher_and_changes_with_it() -> None:
    listening = Listening()
    for kind, message, speed in [(STAMPED, stamped(1.0, 0.0), 1.0), (TWIST, twist(2.0, 0.0), 2.0)] * 2:
        writer = listening.context.transport.writer("/cmd_vel", kind, QoS())
        listening.context.tick(LOOK_EVERY)
        writer.write(messages.encode(message))
        assert listening.hears()
        assert listening.velocities == ((speed, 0.0, 0.0), STILL)
        writer.close()


def test_auto_keeps_its_type_while_a_publisher_of_this_type_exists() -> None:
    listening = Listening()
    for kind in (STAMPED, TWIST):
        listening.context.transport.writer("/cmd_vel", kind, QoS())
    listening.context.tick(2 * LOOK_EVERY)
    assert listening.hears(twist(1.0, 0.0))


# In a graph

GRAPH = """
    nodes: {Tick: OnPlaybackTick, Twist: {type: SubscribeTwist, inputs: {timeout: 0.1}}, Heard: PublishClock}
    connections: [Tick.tick -> Twist.execIn, Twist.execOut -> Heard.execIn, Tick.frame -> Heard.timeStamp]
    """


def test_in_a_graph_the_nodes_downstream_run_on_each_message_and_once_on_a_timeout(play: Player) -> None:
    playing = play.graph(GRAPH).tick(2)
    playing.transport.inject("/cmd_vel", twist(1.0, 0.0))
    playing.tick(20)
    # A message at tick 3, and 0.1 s or 6 ticks later silence.
    assert [m.clock.sec for m in playing.published("/clock")] == [3, 9]


def test_in_a_graph_undecodable_bytes_are_dropped_and_logged_once(play: Player) -> None:
    playing = play.graph(GRAPH)
    for _ in range(2):
        playing.transport.inject("/cmd_vel", b"\x00\x01\x00\x00abc")
        playing.tick()
    assert playing.published("/clock") == []
    assert len(playing.complaints) == 1
    assert "/cmd_vel" in playing.complaints[0]
