"""Checks trajectory_msgs/JointTrajectory messages, and converts them to splines that start at the joints' set points."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.backend import joint_numbers
from graphengine.devices.motion import Articulation
from graphengine.format.errors import ContextError, GraphError
from graphengine.format.stateful import Shared
from graphengine.format.wording import did_you_mean, listing, printable
from graphengine.messages import messages
from graphengine.nodes.ros2.joint_spline import Floats, JointPoint, JointSpline

# Error codes of control_msgs/action/FollowJointTrajectory.
SUCCESSFUL, INVALID_GOAL, INVALID_JOINTS, OLD_HEADER_TIMESTAMP = 0, -1, -2, -3
PATH_TOLERANCE_VIOLATED, GOAL_TOLERANCE_VIOLATED = -4, -5

MAX_POINTS = 10_000
"""Maximum number of points of a trajectory; checking so many points takes as long as some ticks."""
_SLACK = 1e-3
"""Distance by which a point may exceed a joint's range, rad or m, because simulated joint limits are slightly soft."""
_FASTER = 1.01
"""Ratio of a joint's speed to its velocity limit above which a warning is logged."""
_LARGEST = 1e6
"""Maximum magnitude of positions, velocities and accelerations of a trajectory point; the physics accepts up to 1e10."""
_SOON = 1e-6
"""A point that is due in less than this time, s, counts as passed, because a spline cannot reach it in so short a time."""
_AT_REST = float(np.finfo(np.float32).eps)
"""Maximum speed of a joint in the last point, rad/s or m/s; joint_trajectory_controller uses the same value."""


class TrajectoryError(GraphError):
    """A trajectory or goal is invalid for the joints of the controller.

    Args:
        code: error code of control_msgs/action/FollowJointTrajectory.
        message: reason why the trajectory or goal is invalid.
    """

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


@dataclass(frozen=True, slots=True)
class ControlledJoints(Shared):
    """The joints that a controller moves, in the controller's order, with their limits from the robot description."""

    names: tuple[str, ...]
    """Names of the joints in ROS messages."""
    indices: tuple[int, ...]
    """Indices of the joints in the articulation."""
    units: tuple[str, ...]
    """Unit of each joint's position: `rad` or `m`."""
    ranges: Floats
    """Lowest and highest position of each joint, rad or m, shape (joints, 2); infinite for a joint without limits."""
    max_velocities: Floats
    leaders: Mapping[str, str]
    """A dict from the name of each mimic joint of the robot to the name of the joint that it follows."""

    @property
    def continuous(self) -> NDArray[np.bool_]:
        """Whether each joint is continuous: revolute and without limits. A full turn of such a joint leads to the same pose."""
        endless: NDArray[np.bool_] = np.isinf(self.ranges).all(axis=1) & (np.array(self.units) == "rad")
        return endless

    @classmethod
    def of(cls, robot: Articulation, chosen: Sequence[str], published: Sequence[str]) -> ControlledJoints:
        """Return the joints of a robot that a controller moves.

        Args:
            robot: the robot.
            chosen: names of the controller's joints, in the controller's order, as in the robot description.
            published: names of all joints of the robot in ROS messages, in the articulation's order.

        Raises:
            JointError: the robot has no joint with a name in `chosen`.
            ContextError: `chosen` is empty, contains a joint twice, or contains a mimic joint.
        """
        indices = joint_numbers(robot, chosen)
        if not chosen or len(set(indices)) < len(indices):
            text = "a controller needs at least one joint, and no joint twice"
            raise ContextError(text, list(chosen), "name joints with a position drive")
        for name, index in zip(chosen, indices, strict=True):
            if leader := robot.leaders[index]:
                raise ContextError(f"mimic joint {name!r} follows {leader!r}", name, f"command {leader!r} instead")
        return cls(
            tuple(published[index] for index in indices),
            tuple(indices),
            tuple("m" if robot.prismatic[index] else "rad" for index in indices),
            np.array([robot.ranges[index] for index in indices]),
            np.array([robot.max_velocities[index] for index in indices]),
            {name: leader for name, leader in zip(published, robot.leaders, strict=True) if leader},
        )


def read_trajectory(message: Any, joints: ControlledJoints, start: JointPoint, *, partial: bool) -> JointSpline:
    """Convert a trajectory to a spline.

    The spline begins at the current set point; points in the past are skipped. Joints that the message does not name keep their
    set points. All positions of a continuous joint are shifted by the same number of full turns: the joint takes the shorter way
    to the first point.

    Args:
        message: trajectory_msgs/JointTrajectory with one point or more.
        joints: joints of the controller.
        start: current set point of these joints, with velocities and accelerations, at the current time.
        partial: whether the message may leave out joints of the controller.

    Raises:
        TrajectoryError: the message is not a trajectory that the joints can follow.
    """
    columns = _columns(message.joint_names, joints, partial=partial)
    _check_numbers(message.points, len(columns))
    times = _times(message, start.time)
    passed = min(int(np.searchsorted(times, start.time + _SOON, side="right")), len(times) - 1)
    remaining = zip(times[passed:].tolist(), message.points[passed:], strict=True)
    points = _turned([_point(time, point, columns, start) for time, point in remaining], joints, start)
    _check_end(points[-1], joints)
    _check_ranges(points, passed, joints)
    if points[0].time <= start.time + _SOON:  # the last point is due at once
        return JointSpline((points[0],))
    return JointSpline((start, *points))


def excess_speed(spline: JointSpline, joints: ControlledJoints) -> str:
    """Return a warning about the first joint that exceeds its velocity limit by more than 1 %, or an empty string."""
    limits = joints.max_velocities * _FASTER
    for before, after in zip(spline.points, spline.points[1:], strict=False):
        speeds = np.abs(after.positions - before.positions) / (after.time - before.time)
        if after.velocities is not None:
            speeds = np.maximum(speeds, np.abs(after.velocities))
        if (speeds > limits).any():
            joint = int(np.argmax(speeds / limits))
            unit = f"{joints.units[joint]}/s"
            limit = f"{joints.max_velocities[joint]:.4g} {unit}"
            return f"joint {joints.names[joint]} moves at {speeds[joint]:.4g} {unit}, its limit is {limit}"
    return ""


def _columns(names: Sequence[str], joints: ControlledJoints, *, partial: bool) -> list[int]:
    """Return the index of each named joint among the joints of the controller.

    Args:
        names: joint names of a message.
        joints: joints of the controller.
        partial: whether the names may leave out joints of the controller.

    Raises:
        TrajectoryError: a joint is unknown, a mimic joint, named twice or missing, or no joint is named.
    """
    known = {name: number for number, name in enumerate(joints.names)}
    for name in names:
        if name in known:
            continue
        if name in joints.leaders:
            text = f"joint {name} follows {joints.leaders[name]} and takes no commands: leave it out"
        else:
            hint = did_you_mean(name, known) or listing(known, "joints")
            text = f"joint '{printable(name)}' is not a joint of this controller; {hint}"
        raise TrajectoryError(INVALID_JOINTS, text)
    given = set(names)
    if len(given) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise TrajectoryError(INVALID_JOINTS, f"joint {twice} is named twice")
    missing = [name for name in joints.names if name not in given]
    if missing and not partial:
        raise TrajectoryError(INVALID_JOINTS, f"partial goals are not allowed; {listing(missing, 'missing joints')}")
    if not names:
        raise TrajectoryError(INVALID_JOINTS, "the trajectory names no joints")
    return [known[name] for name in names]


def _check_numbers(points: Sequence[Any], joints: int) -> None:
    """Check that each point has one position per joint, and one velocity and acceleration per joint or no such numbers.

    The numbers must be finite and not too large, and there must be no efforts and not too many points.
    """
    if len(points) > MAX_POINTS:
        raise TrajectoryError(INVALID_GOAL, f"{len(points)} points are too many, legal: up to {MAX_POINTS}")
    for name in ("positions", "velocities", "accelerations", "effort"):
        rows = [getattr(point, name) for point in points]
        for number, row in enumerate(rows):
            if len(row) and name == "effort":
                text = f"point {number} has efforts, but the joints follow positions and velocities"
                raise TrajectoryError(INVALID_GOAL, text)
            if len(row) != joints and (len(row) or name == "positions"):
                raise TrajectoryError(INVALID_GOAL, f"point {number} has {len(row)} {name} for {joints} joints")
        if not (np.abs(np.concatenate(rows)) <= _LARGEST).all():  # false for NaN
            number = next(number for number, row in enumerate(rows) if not (np.abs(row) <= _LARGEST).all())
            text = f"{name} of point {number} must be finite numbers up to {_LARGEST:g}"
            raise TrajectoryError(INVALID_GOAL, text)


def _times(message: Any, now: float) -> Floats:
    """Return the simulation time of each point of a JointTrajectory message, s.

    Raises:
        TrajectoryError: the times do not increase, the first one is negative, or the trajectory ends in the past.
    """
    stamp = messages.seconds(message.header.stamp)
    offsets = np.array([messages.seconds(point.time_from_start) for point in message.points])
    times: Floats = offsets + (stamp or now)
    wrong = np.flatnonzero(np.diff(times) <= 0.0)
    if len(wrong) or offsets[0] < 0.0:
        number = int(wrong[0]) + 1 if len(wrong) else 0
        before = f"that of point {number - 1}, {offsets[number - 1]:g} s" if number else "0"
        relation = "must be later than" if number else "must not be before"
        raise TrajectoryError(INVALID_GOAL, f"time of point {number}, {offsets[number]:g} s, {relation} {before}")
    if stamp and times[-1] < now - _SOON:
        text = f"the trajectory starts at {stamp:.9g} s and ends at {times[-1]:.9g} s, but it is {now:.9g} s now"
        raise TrajectoryError(OLD_HEADER_TIMESTAMP, text)
    return times


def _point(time: float, point: Any, columns: Sequence[int], start: JointPoint) -> JointPoint:
    """Return a point for all joints of the controller; a joint that the message does not name keeps its set point.

    Args:
        time: simulation time of the point, s.
        point: trajectory_msgs/JointTrajectoryPoint.
        columns: index in the controller of each joint of the message.
        start: current set point.
    """

    def spread(values: NDArray[Any], rest: Floats) -> Floats | None:
        if not len(values):
            return None
        made = rest.copy()
        made[columns] = values
        return made

    positions, zeros = spread(point.positions, start.positions), np.zeros_like(start.positions)
    assert positions is not None
    return JointPoint(time, positions, spread(point.velocities, zeros), spread(point.accelerations, zeros))


def _check_end(last: JointPoint, joints: ControlledJoints) -> None:
    for name, velocity in zip(joints.names, () if last.velocities is None else last.velocities.tolist(), strict=False):
        if abs(velocity) > _AT_REST:
            text = f"the velocity of joint {name} in the last point must be 0, it is {velocity:g}"
            raise TrajectoryError(INVALID_GOAL, text)


def _turned(points: Sequence[JointPoint], joints: ControlledJoints, start: JointPoint) -> list[JointPoint]:
    """Return the points with continuous joints shifted by full turns, which bring their first positions near the set point."""
    turns = np.round((start.positions - points[0].positions) / math.tau) * joints.continuous
    if not turns.any():
        return list(points)
    return [
        JointPoint(point.time, point.positions + turns * math.tau, point.velocities, point.accelerations)
        for point in points
    ]


def _check_ranges(points: Sequence[JointPoint], first: int, joints: ControlledJoints) -> None:
    positions = np.array([point.positions for point in points])
    outside = (positions < joints.ranges[:, 0] - _SLACK) | (positions > joints.ranges[:, 1] + _SLACK)
    if outside.any():
        point, joint = np.argwhere(outside)[0]
        low, high = joints.ranges[joint]
        raise TrajectoryError(
            INVALID_GOAL,
            f"joint {joints.names[joint]} cannot be at {positions[point, joint]:.6g} {joints.units[joint]} "
            f"in point {first + point}, legal: {low:.6g} to {high:.6g}",
        )
