"""An arm with physics: a trajectory of fifty points, and a gripper whose second finger mimics the first."""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from graphengine.messages import goals, messages
from tests import arm_robot, arm_scene
from tests.action_peer import ActionPeer
from tests.arm_scene import DURATION, POINTS, RATE, Floats, fifty, motion
from tests.nodes.harness import Player, Playing
from tests.trajectories import FOLLOW, point, trajectory


class Arm:
    """A running scene with the arm."""

    def __init__(self, play: Player) -> None:
        self.playing: Playing = play.scene(arm_scene.files())
        self.action = ActionPeer(self.playing.transport, "/joint_trajectory_controller/follow_joint_trajectory", FOLLOW)
        self.gripper = ActionPeer(
            self.playing.transport, "/gripper_controller/gripper_cmd", "control_msgs/action/GripperCommand"
        )
        self.playing.tick()

    @property
    def state(self) -> Any:
        """The newest message of joint states."""
        return self.playing.published("/joint_states")[-1]

    def positions(self, names: Sequence[str] = arm_robot.JOINTS) -> Floats:
        of = dict(zip(self.state.name, self.state.position, strict=True))
        return np.array([of[name] for name in names])

    def send(self, peer: ActionPeer, **fields: Any) -> uuid.UUID:
        goal = uuid.uuid4()
        peer.send(goal, **fields)
        self.playing.tick()
        peer.ask_result(goal)
        return goal

    @property
    def now(self) -> float:
        return messages.seconds(self.state.header.stamp)


@pytest.fixture
def arm(play: Player) -> Arm:
    return Arm(play)


def test_fifty_points_at_half_the_speed_limits_are_followed_within_5_mrad_and_1_at_the_end(arm: Arm) -> None:
    start = arm.positions()
    arm.send(arm.action, trajectory=fifty())
    begin, worst = arm.now, 0.0
    np.testing.assert_allclose(start, motion(0.0)[0], atol=1e-3)
    for _ in range(POINTS - 1):
        arm.playing.tick(round(DURATION / (POINTS - 1) * RATE))
        expected, _ = motion(min(arm.now - begin, DURATION))
        worst = max(worst, np.abs(arm.positions() - expected).max())
    assert worst < 0.005
    arm.playing.tick(RATE)
    assert [(r.status, r.result.error_code) for r in arm.action.results] == [(goals.SUCCEEDED, 0)]
    assert np.abs(arm.positions() - motion(DURATION)[0]).max() < 0.001
    assert len(arm.action.feedback) == pytest.approx(20 * DURATION, abs=2)


def test_a_cancelled_arm_stops(arm: Arm) -> None:
    goal = arm.send(arm.action, trajectory=fifty())
    arm.playing.tick(RATE * 2)
    arm.action.cancel(goal)
    arm.playing.tick(RATE)
    before = arm.positions()
    arm.playing.tick(RATE)
    assert [r.status for r in arm.action.results] == [goals.CANCELED]
    assert np.abs(arm.positions() - before).max() < 1e-4


def test_a_goal_beyond_a_limit_moves_nothing(arm: Arm) -> None:
    before = arm.positions()
    arm.send(arm.action, trajectory=trajectory(arm_robot.JOINTS, point(1.0, (3.2, 0, 0, 0, 0, 0))))
    arm.playing.tick(RATE)
    [answer] = arm.action.results
    assert (answer.status, answer.result.error_code) == (goals.ABORTED, -1)
    assert "joint shoulder_pan cannot be at 3.2 rad in point 0, legal: -3.1 to 3.1" in answer.result.error_string
    assert np.abs(arm.positions() - before).max() < 1e-3


def test_the_second_finger_mimics_the_first_and_is_among_the_joint_states(arm: Arm) -> None:
    arm.send(arm.gripper, command=messages.message_class("control_msgs/msg/GripperCommand")(0.03, 0.0))
    arm.playing.tick(RATE)
    [answer] = arm.gripper.results
    assert (answer.status, answer.result.reached_goal) == (goals.SUCCEEDED, True)
    assert arm.state.name == [*arm_robot.JOINTS, arm_robot.FINGER, arm_robot.FOLLOWER]
    assert arm.positions([arm_robot.FINGER, arm_robot.FOLLOWER]) == pytest.approx([0.03, 0.03], abs=5e-4)


def test_a_finger_that_little_effort_moves_is_not_braked_by_the_damping_of_its_drive(arm: Arm) -> None:
    force = 0.5  # N; the drive's 60 N s/m take as much at 8 mm/s, with which the way would take 2.5 s
    arm.send(arm.gripper, command=messages.message_class("control_msgs/msg/GripperCommand")(0.03, force))
    reached = []
    for _ in range(RATE):
        arm.playing.tick()
        reached.append(arm.positions([arm_robot.FINGER])[0])
    [answer] = arm.gripper.results
    assert (answer.status, answer.result.reached_goal) == (goals.SUCCEEDED, True)
    assert max(reached) < 0.0305


def test_a_trajectory_of_the_mimicking_finger_is_refused(arm: Arm) -> None:
    arm.send(arm.action, trajectory=trajectory([arm_robot.FOLLOWER], point(1.0, (0.01,))))
    arm.playing.tick(2)
    [answer] = arm.action.results
    assert answer.result.error_code == -2
    assert answer.result.error_string == "joint other_finger follows finger and takes no commands: leave it out"
