"""ROS2GripperCommand: positions, efforts and stalling, with a finger that a test moves."""

from __future__ import annotations

import math
import uuid
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from graphengine.format.errors import ContextError
from graphengine.messages import goals
from graphengine.messages.definitions import DEFINITIONS
from graphengine.nodes.ros2.gripper_command import ROS2GripperCommand
from graphengine.nodes.ros2.robot_action import message
from graphengine.testing import RecordingContext, check_node
from tests.action_peer import ActionPeer
from tests.nodes.harness import ready

PLAIN, PARALLEL = "control_msgs/action/GripperCommand", "control_msgs/action/ParallelGripperCommand"
STIFFNESS = 1000.0


def surroundings() -> RecordingContext:
    context = RecordingContext()
    facts = {"leaders": ("", "finger"), "stiffness": (STIFFNESS, 0.0), "prismatic": (True, True)}
    context.world.add_robot("/hand", ["finger", "other"], **facts)
    return context


class Hand:
    """A finger that follows its set point at once, but not beyond `blocked_at`; and a client."""

    def __init__(self, action_type: str = PLAIN, **inputs: Any) -> None:
        self.context = surroundings()
        self.robot = self.context.world.articulation(self.context.world.stage.find("/hand"))
        self.blocked_at = math.inf
        kind = action_type.rpartition("/")[2]
        given = {"target_prim": "/hand", "joint_name": "finger", "action_type": kind, "goal_tolerance": 0.001, **inputs}
        self.node = ready(ROS2GripperCommand, self.context, **given)
        self.peer = ActionPeer(self.context.transport, "/gripper_controller/gripper_cmd", action_type)
        self.commands: list[float | None] = []
        self.tick()

    def tick(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            self.context.transport.messages("/unused")
            self.context.tick()
            fired = self.node.compute()
            self.commands.append(float(self.node.position_command[0]) if fired else None)
            if fired:
                before, there = self.robot.positions()[0], min(self.node.position_command[0], self.blocked_at)
                self.robot.state = {
                    "position": [there, there],
                    "velocity": [(there - before) * 60, 0.0],
                    "effort": [STIFFNESS * (self.node.position_command[0] - there), 0.0],
                }
        self.context.transport.messages("/unused")

    def send(self, command: Any) -> uuid.UUID:
        goal = uuid.UUID(int=len(self.peer.accepted) + 1)
        self.peer.send(goal, command=command)
        self.tick()
        self.peer.ask_result(goal)
        self.tick()
        return goal

    def grip(self, position: float, effort: float = 0.0) -> uuid.UUID:
        return self.send(message("control_msgs/msg/GripperCommand", position, effort))

    @property
    def result(self) -> tuple[int, bool, bool]:
        """Status, stalled and reached_goal of the last result."""
        response = self.peer.results[-1]
        return response.status, response.result.stalled, response.result.reached_goal


def joint_state(position: Sequence[float], velocity: Sequence[float] = (), name: Sequence[str] = ()) -> Any:
    header = DEFINITIONS.initial("std_msgs/msg/Header")
    return message("sensor_msgs/msg/JointState", header, list(name), *map(np.array, (position, velocity, ())))


def test_a_goal_is_reached_and_others_may_then_command_the_finger() -> None:
    hand = Hand()
    hand.grip(0.03)
    hand.tick(2)
    assert hand.result == (goals.SUCCEEDED, False, True)
    assert hand.peer.results[-1].result.position == pytest.approx(0.03)
    assert (hand.commands[1], hand.commands[-1]) == (0.03, None)


def test_a_finger_that_rests_on_an_object_ends_the_goal_as_stalled() -> None:
    hand, lenient = Hand(stall_timeout=0.5), Hand(stall_timeout=0.5, allow_stalling=True)
    for one in (hand, lenient):
        one.blocked_at = 0.02
        one.grip(0.04)
        one.tick(28)
        assert one.peer.results == []
        one.tick(6)
    assert hand.result == (goals.ABORTED, True, False)
    assert lenient.result == (goals.SUCCEEDED, True, False)
    assert lenient.peer.results[-1].result.position == 0.02


def test_the_effort_of_a_goal_limits_the_drive_during_and_after_the_goal() -> None:
    hand = Hand(stall_timeout=0.1, allow_stalling=True)
    hand.blocked_at = 0.02
    hand.grip(0.04, effort=5.0)
    hand.tick(40)
    assert hand.result == (goals.SUCCEEDED, True, False)
    assert hand.peer.results[-1].result.effort == pytest.approx(5.0)
    assert hand.commands[-1] == pytest.approx(0.02 + 5.0 / STIFFNESS)
    hand.blocked_at = 0.025  # what is held gives way
    hand.tick(3)
    assert hand.robot.efforts()[0] == pytest.approx(5.0)


def test_a_goal_without_an_effort_has_the_maximum_effort_of_the_node() -> None:
    hand = Hand(max_effort=2.0)
    hand.blocked_at = 0.0
    hand.grip(0.04)
    assert hand.commands[-1] == pytest.approx(2.0 / STIFFNESS)


def test_a_cancelled_goal_holds_the_finger() -> None:
    hand = Hand()
    hand.blocked_at = 0.01
    goal = hand.grip(0.04)
    hand.peer.cancel(goal)
    hand.tick()
    assert hand.result == (goals.CANCELED, False, False)
    assert hand.commands[-1] == 0.01
    hand.tick()
    assert hand.commands[-1] is None


def test_a_new_goal_aborts_the_current_goal() -> None:
    hand = Hand()
    hand.blocked_at = 0.01
    hand.grip(0.04)
    hand.grip(0.0)
    hand.tick(2)
    assert [response.status for response in hand.peer.results] == [goals.ABORTED, goals.SUCCEEDED]


def test_a_parallel_gripper_moves_at_the_velocity_of_its_goal() -> None:
    hand = Hand(PARALLEL)
    hand.send(joint_state([0.03], [0.06], ["finger"]))
    assert hand.commands[-2:] == pytest.approx([0.001, 0.002])
    hand.tick(30)
    assert hand.result == (goals.SUCCEEDED, False, True)
    state = hand.peer.results[-1].result.state
    assert (state.name, state.position.tolist()) == (["finger"], pytest.approx([0.03], abs=0.002))


def test_the_set_point_of_a_goal_beyond_the_range_restarts_at_the_limit() -> None:
    hand = Hand(PARALLEL)
    hand.robot.target_ranges = ((0.0, 0.04), (-math.inf, math.inf))
    hand.blocked_at = 0.04
    hand.send(joint_state([1.0], [0.06], ["finger"]))
    hand.tick(200)
    assert hand.node.position_command[0] > 0.2  # which the drive clamps and counts
    hand.send(joint_state([0.03], [0.06], ["finger"]))
    hand.tick(10)
    assert hand.result == (goals.SUCCEEDED, False, True)


def test_a_held_finger_that_rests_on_its_limit_is_commanded_to_the_limit() -> None:
    hand = Hand()
    hand.robot.target_ranges = ((0.0, 0.04), (-math.inf, math.inf))
    hand.blocked_at = 0.0401
    hand.peer.cancel(hand.grip(0.05))
    hand.tick()
    assert hand.commands[-1] == 0.04


@pytest.mark.parametrize(
    "command",
    [joint_state([]), joint_state([0.0, 0.1]), joint_state([math.nan]), joint_state([0.0], name=["other"])],
    ids=["none", "two", "nan", "other"],
)
def test_an_invalid_goal_is_rejected(command: Any) -> None:
    hand = Hand(PARALLEL)
    hand.send(command)
    assert (hand.peer.accepted, hand.commands[-1]) == ([False], None)
    assert hand.context.logged


def test_an_infinite_position_is_rejected() -> None:
    hand = Hand()
    hand.grip(math.inf)
    assert hand.peer.accepted == [False]


def test_a_finger_stops_when_the_node_is_set_up_again() -> None:
    hand = Hand(max_effort=1.0)
    hand.grip(0.04)
    hand.context.close()
    hand.node.setup(hand.context)
    present = hand.robot.positions()[0]
    hand.tick()
    assert hand.commands[-1] == present
    hand.tick()
    assert hand.commands[-1] is None
    assert [result.status for result in hand.peer.results] == [goals.ABORTED]


def test_a_mimic_joint_is_refused() -> None:
    with pytest.raises(ContextError, match="jointName is the mimic joint 'other', which follows 'finger'"):
        ready(ROS2GripperCommand, surroundings(), target_prim="/hand", joint_name="other")


def test_check_node_accepts_the_gripper_controller() -> None:
    check_node(ROS2GripperCommand, surroundings, target_prim="/hand", joint_name="finger")
