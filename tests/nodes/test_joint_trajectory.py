"""Trajectory messages as splines: order of joints, start, time stamps, full turns, and what is refused with which code."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.format.errors import ContextError
from graphengine.nodes.ros2 import joint_trajectory as codes
from graphengine.nodes.ros2.joint_spline import JointPoint, JointSpline
from graphengine.nodes.ros2.joint_trajectory import ControlledJoints, TrajectoryError, excess_speed, read_trajectory
from graphengine.nodes.ros2.robot_action import duration
from graphengine.nodes.ros2.trajectory_tolerances import Tolerances
from graphengine.testing import RecordingWorld
from tests.trajectories import goal, point, tolerance, trajectory

NAMES = ("pan", "lift", "slide")
NOW = 10.0
INFINITE = (-math.inf, math.inf)


def joints(*names: str) -> ControlledJoints:
    """A continuous joint, one with limits, one that slides, and a follower of the last."""
    robot = RecordingWorld().add_robot(
        "/arm",
        [*NAMES, "finger"],
        prismatic=(False, False, True, True),
        ranges=(INFINITE, (-1.0, 2.0), (0.0, 0.5), (0.0, 0.5)),
        max_velocities=(1.0, 2.0, math.inf, math.inf),
        leaders=("", "", "", "slide"),
    )
    return ControlledJoints.of(robot, names or NAMES, robot.joint_names)


def start(*positions: float, speed: float = 0.0) -> JointPoint:
    return JointPoint(NOW, np.array(positions or (0.0, 0.0, 0.0)), np.full(3, speed), np.zeros(3))


def read(message: Any, at: JointPoint | None = None, *, partial: bool = False) -> JointSpline:
    return read_trajectory(message, joints(), at or start(), partial=partial)


def refusal(message: Any, *, partial: bool = False) -> tuple[int, str]:
    with pytest.raises(TrajectoryError) as error:
        read(message, partial=partial)
    return error.value.code, str(error.value)


TO = (0.3, 0.2, 0.1)


def test_a_trajectory_starts_at_the_current_set_point_with_joints_in_any_order() -> None:
    spline = read(trajectory(("slide", "pan", "lift"), point(2.0, (0.1, 0.3, 0.2))), start(0.0, 0.1, 0.0))
    assert spline.sample(NOW)[0].tolist() == [0.0, 0.1, 0.0]
    assert spline.sample(NOW + 1.0)[0] == pytest.approx([0.15, 0.15, 0.05])
    assert (spline.sample(NOW + 2.0)[0].tolist(), spline.end) == (list(TO), NOW + 2.0)


def test_the_spline_starts_with_the_set_points_velocity_if_points_have_velocities() -> None:
    spline = read(trajectory(NAMES, point(2.0, TO, (0.0, 0.0, 0.0))), start(speed=0.4))
    assert spline.sample(NOW)[1] == pytest.approx([0.4] * 3)


def test_times_of_points_count_from_a_stamp_in_the_future() -> None:
    spline = read(trajectory(NAMES, point(1.0, TO), stamp=NOW + 3.0))
    assert spline.end == NOW + 4.0
    assert spline.sample(NOW + 2.0)[0] == pytest.approx(np.array(TO) / 2)  # on the way from now on


def test_points_in_the_past_are_skipped() -> None:
    message = trajectory(NAMES, point(1.0, (9.0, 1.0, 0.3)), point(3.0, TO), stamp=NOW - 2.0)
    spline = read(message)
    assert [len(spline.points), spline.end] == [2, NOW + 1.0]
    assert spline.sample(NOW)[0].tolist() == [0.0, 0.0, 0.0]


def test_a_last_point_that_is_due_is_commanded_at_once() -> None:
    assert read(trajectory(NAMES, point(0.0, TO))).sample(NOW)[0].tolist() == list(TO)


def test_a_first_point_at_time_zero_is_replaced_by_the_set_point() -> None:
    spline = read(trajectory(NAMES, point(0.0, (0.01, 0.0, 0.0)), point(1.0, TO)))
    assert spline.sample(NOW)[0].tolist() == [0.0, 0.0, 0.0]
    assert len(spline.points) == 2


def test_joints_missing_in_a_partial_trajectory_keep_their_set_points() -> None:
    spline = read(trajectory(("lift",), point(1.0, (0.5,), (0.0,))), start(1.0, 0.0, 0.2), partial=True)
    assert spline.sample(NOW + 1.0)[0].tolist() == [1.0, 0.5, 0.2]


def test_continuous_joints_take_the_shorter_way_and_other_joints_are_not_shifted() -> None:
    spline = read(trajectory(NAMES, point(1.0, TO), point(2.0, (1.3, 0.0, 0.0))), start(4 * math.tau, 0.0, 0.0))
    assert spline.sample(NOW + 1.0)[0] == pytest.approx([4 * math.tau + 0.3, 0.2, 0.1])
    assert spline.sample(NOW + 2.0)[0] == pytest.approx([4 * math.tau + 1.3, 0.0, 0.0])


NAN = math.nan


@pytest.mark.parametrize(
    ("message", "code", "reason"),
    [
        (trajectory((*NAMES[:2], "slid"), point(1, TO)), codes.INVALID_JOINTS, "did you mean 'slide'"),
        (trajectory((), point(1)), codes.INVALID_JOINTS, "missing joints: pan, lift, slide"),
        (trajectory(NAMES[:2], point(1, TO[:2])), codes.INVALID_JOINTS, "missing joints: slide"),
        (trajectory((*NAMES, "pan"), point(1, (*TO, 0))), codes.INVALID_JOINTS, "pan is named twice"),
        (trajectory((*NAMES, "finger"), point(1, (*TO, 0))), codes.INVALID_JOINTS, "finger follows slide"),
        (trajectory(NAMES, point(1, TO[:2])), codes.INVALID_GOAL, "point 0 has 2 positions for 3 joints"),
        (trajectory(NAMES, point(1, (), TO)), codes.INVALID_GOAL, "point 0 has 0 positions"),
        (trajectory(NAMES, point(1, TO), point(2, TO, TO[:1])), codes.INVALID_GOAL, "point 1 has 1 velocities"),
        (trajectory(NAMES, point(1, TO, TO, (*TO, 0))), codes.INVALID_GOAL, "point 0 has 4 accelerations"),
        (trajectory(NAMES, point(1, TO, effort=TO)), codes.INVALID_GOAL, "efforts"),
        (trajectory(NAMES, point(1, (NAN, 0, 0))), codes.INVALID_GOAL, "positions of point 0 must be finite numbers"),
        (trajectory(NAMES, point(1, TO, (0, math.inf, 0))), codes.INVALID_GOAL, "velocities of point 0"),
        (trajectory(NAMES, point(1, (1e7, 0, 0))), codes.INVALID_GOAL, "numbers up to 1e"),
        (trajectory(NAMES, point(1, TO), point(1, TO)), codes.INVALID_GOAL, "time of point 1, 1 s, must be later"),
        (trajectory(NAMES, point(2, TO), point(1, TO)), codes.INVALID_GOAL, "must be later than that of point 0, 2 s"),
        (trajectory(NAMES, point(-1, TO)), codes.INVALID_GOAL, "time of point 0, -1 s, must not be before 0"),
        (trajectory(NAMES, point(1, TO, (0, 0.1, 0))), codes.INVALID_GOAL, "joint lift in the last point must be 0"),
        (trajectory(NAMES, point(1, (0, 2.1, 0))), codes.INVALID_GOAL, "joint lift cannot be at 2.1 rad in point 0"),
        (trajectory(NAMES, point(1, TO), point(2, (0, 0, -1))), codes.INVALID_GOAL, "-1 m in point 1, legal: 0 to 0.5"),
        (trajectory(NAMES, point(1, TO), stamp=NOW - 2), codes.OLD_HEADER_TIMESTAMP, "ends at 9 s, but it is 10 s now"),
        (trajectory(NAMES, *[point(1, TO)] * 100_001), codes.INVALID_GOAL, "100001 points are too many"),
    ],
)
def test_an_invalid_trajectory_is_refused_with_the_error_code_of_the_action_and_a_reason(
    message: Any, code: int, reason: str
) -> None:
    assert refusal(message)[0] == code
    assert reason in refusal(message)[1]


def test_a_partial_trajectory_without_joints_is_refused() -> None:
    assert refusal(trajectory((), point(1)), partial=True) == (codes.INVALID_JOINTS, "the trajectory names no joints")


def test_a_point_slightly_beyond_a_limit_is_legal_because_joints_rest_there() -> None:
    assert read(trajectory(NAMES, point(1.0, (0.0, 2.0005, 0.0)))).end == NOW + 1.0


def test_a_trajectory_beyond_a_velocity_limit_gives_a_warning() -> None:
    slow = read(trajectory(NAMES, point(1.0, (0.9, 1.9, 0.4))))
    fast = read(trajectory(NAMES, point(1.0, (1.5, 1.9, 0.4))))
    assert excess_speed(slow, joints()) == ""
    assert excess_speed(fast, joints()) == "joint pan moves at 1.5 rad/s, its limit is 1 rad/s"


@pytest.mark.parametrize("chosen", [("pan", "pan"), ("finger",)])
def test_a_controller_refuses_repeated_and_mimic_joints(chosen: tuple[str, ...]) -> None:
    with pytest.raises(ContextError):
        joints(*chosen)


# Tolerances

DEFAULTS = Tolerances.by_default(3, np.array([0.1]), np.array([0.0, 0.2, 0.3]), 0.01, 0.0)


def violation(tolerances: Tolerances, *errors: float, speed: float = 0.0) -> str:
    return tolerances.goal.violation(joints(), np.array(errors), np.full(3, speed))


def test_one_tolerance_applies_to_all_joints_and_zero_means_no_limit() -> None:
    assert DEFAULTS.path.violation(joints(), np.array([0.0, -0.11, 0.0]), np.full(3, 9.0)) == (
        "joint lift: position error 0.11 rad, tolerance 0.1 rad"
    )
    assert violation(DEFAULTS, 99.0, 0.2, 0.3) == ""
    assert violation(DEFAULTS, 0.0, 0.0, 0.31) == "joint slide: position error 0.31 m, tolerance 0.3 m"
    assert (
        violation(DEFAULTS, 0.0, 0.0, 0.0, speed=0.02) == "joint pan: velocity error 0.02 rad/s, tolerance 0.01 rad/s"
    )
    assert DEFAULTS.goal_time == math.inf


def test_a_goal_sets_keeps_and_removes_tolerances() -> None:
    given = [tolerance("pan", 0.05), tolerance("lift", 0.0, -1.0), tolerance("slide", -1.0)]
    made = DEFAULTS.of_goal(goal(None, goal_tolerance=given, goal_time_tolerance=duration(0.5)), joints())
    assert made.goal.positions.tolist() == [0.05, 0.2, math.inf]
    assert made.goal.velocities.tolist() == [0.01, math.inf, 0.01]
    assert (made.path.positions.tolist(), made.goal_time) == ([0.1] * 3, 0.5)
    assert DEFAULTS.goal.positions.tolist() == [math.inf, 0.2, 0.3]


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        (
            {"path_tolerance": [tolerance("pam", 0.1)]},
            "path_tolerance: 'pam' is not a joint of this controller; did you mean 'pan'?",
        ),
        ({"goal_tolerance": [tolerance("pan", -0.5)]}, "goal_tolerance of position of joint pan cannot be -0.5"),
        ({"goal_tolerance": [tolerance("pan", 0.0, NAN)]}, "goal_tolerance of velocity of joint pan cannot be nan"),
        ({"goal_time_tolerance": duration(-3.0)}, "goal_time_tolerance cannot be -3"),
    ],
)
def test_an_invalid_tolerance_is_refused(fields: dict[str, Any], reason: str) -> None:
    with pytest.raises(TrajectoryError) as error:
        DEFAULTS.of_goal(goal(None, **fields), joints())
    assert error.value.code == codes.INVALID_GOAL
    assert reason in str(error.value)
