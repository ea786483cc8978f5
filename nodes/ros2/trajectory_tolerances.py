"""Tolerances for joint errors during and at the end of a trajectory, as defined by control_msgs/action/FollowJointTrajectory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from graphengine.format.stateful import Shared
from graphengine.format.wording import did_you_mean, listing, printable
from graphengine.messages import messages
from graphengine.nodes.ros2.joint_spline import Floats
from graphengine.nodes.ros2.joint_trajectory import INVALID_GOAL, ControlledJoints, TrajectoryError

_ERASED = -1.0
"""Value of a tolerance in a goal that means no limit, instead of the default."""


@dataclass(frozen=True, slots=True)
class StateTolerances(Shared):
    """Maximum errors of the position and velocity of each joint; infinite if there is no limit."""

    positions: Floats
    velocities: Floats

    def has_limits(self) -> bool:
        """Return whether a joint has a limit."""
        return bool(np.isfinite(self.positions).any() or np.isfinite(self.velocities).any())

    def violation(self, joints: ControlledJoints, positions: Floats, velocities: Floats) -> str:
        """Return a message about the first joint whose error exceeds its tolerance, or an empty string.

        Args:
            joints: the joints, whose names and units appear in the message.
            positions: position errors, rad or m.
            velocities: velocity errors, rad/s or m/s.
        """
        kinds = (("position", "", positions, self.positions), ("velocity", "/s", velocities, self.velocities))
        for kind, per, errors, limits in kinds:
            beyond = np.abs(errors) > limits
            if beyond.any():
                joint = int(np.argmax(beyond))
                unit = f"{joints.units[joint]}{per}"
                error, limit = f"{abs(errors[joint]):.4g} {unit}", f"{limits[joint]:.4g} {unit}"
                return f"joint {joints.names[joint]}: {kind} error {error}, tolerance {limit}"
        return ""


@dataclass(frozen=True, slots=True)
class Tolerances(Shared):
    """Tolerances of one trajectory: `path` until its last point, `goal` from then on."""

    path: StateTolerances
    goal: StateTolerances
    goal_time: float
    """Time after the end of the trajectory during which the joints may still reach the goal, s; infinite if there is no limit."""
    limits_path: bool
    """Whether a joint has a limit in `path`; without limits, errors during the trajectory have no effect."""

    @classmethod
    def by_default(cls, joints: int, path: Floats, goal: Floats, stopped: float, goal_time: float) -> Tolerances:
        """Return the tolerances for goals that set none.

        Args:
            joints: number of joints.
            path: maximum position errors during a trajectory, rad or m: one per joint, one for all joints, or none.
            goal: maximum position errors at the end of a trajectory, in the same form.
            stopped: maximum velocity error at the end of a trajectory, rad/s or m/s.
            goal_time: time after the end of a trajectory during which the joints may still reach the goal, s.

        In all arguments but `joints`, 0 means no limit.
        """
        during = StateTolerances(_limits(path, joints), np.full(joints, np.inf))
        end = StateTolerances(_limits(goal, joints), _limits(np.array([stopped]), joints))
        return cls(during, end, goal_time or np.inf, during.has_limits())

    def of_goal(self, goal: Any, joints: ControlledJoints) -> Tolerances:
        """Return the tolerances of a goal. Tolerances that the goal does not set are taken from this object.

        In a goal, a tolerance of 0 is not set, and -1 means no limit. Tolerances of accelerations have no effect, because
        accelerations are not measured.

        Raises:
            TrajectoryError: a tolerance is NaN or negative but not -1, or is for a joint that the controller does not have.
        """
        time = messages.seconds(goal.goal_time_tolerance)
        path = _with(self.path, goal.path_tolerance, "path_tolerance", joints)
        end = _with(self.goal, goal.goal_tolerance, "goal_tolerance", joints)
        return Tolerances(path, end, _limit(time, self.goal_time, "goal_time_tolerance"), path.has_limits())


def _limits(numbers: Floats, joints: int) -> Floats:
    limits: Floats = np.full(joints, np.inf)
    if len(numbers):
        limits[:] = numbers
    limits[limits <= 0.0] = np.inf
    return limits


def _with(default: StateTolerances, given: Sequence[Any], field: str, joints: ControlledJoints) -> StateTolerances:
    made = replace(default, positions=default.positions.copy(), velocities=default.velocities.copy())
    for tolerance in given:
        if tolerance.name not in joints.names:
            hint = did_you_mean(tolerance.name, joints.names) or listing(joints.names, "joints")
            text = f"{field}: '{printable(tolerance.name)}' is not a joint of this controller; {hint}"
            raise TrajectoryError(INVALID_GOAL, text)
        joint = joints.names.index(tolerance.name)
        for kind, limits in (("position", made.positions), ("velocity", made.velocities)):
            place = f"{field} of {kind} of joint {tolerance.name}"
            limits[joint] = _limit(getattr(tolerance, kind), limits[joint], place)
    return made


def _limit(given: float, default: float, place: str) -> float:
    if given == 0.0:
        return default
    if given == _ERASED:
        return np.inf
    if not given > 0.0:
        text = f"{place} cannot be {given:g}, legal: above 0, 0 for the default, -1 for no limit"
        raise TrajectoryError(INVALID_GOAL, text)
    return given
