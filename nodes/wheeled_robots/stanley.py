"""The path follower with the Stanley control law (G. M. Hoffmann et al., Autonomous automobile trajectory tracking, 2007)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from graphengine.node import BadValueError, Bools, Double2, Double3, Doubles, In, Out, State, Vector3d
from graphengine.nodes.checked import check_finite, check_outcome
from graphengine.nodes.wheeled_robots.limits import limited
from graphengine.nodes.wheeled_robots.planar import Heading, PlanarNode, wrapped

Speeds = tuple[float, float]
"""Forward speed (m/s) and counter-clockwise turn rate (rad/s)."""

SLOWEST = 0.05
"""Minimum speed (m/s) on a path, and speed at which a base drives to a target that it has missed."""
FASTEST_TURN = 1.0
"""Maximum turn rate (rad/s) of a base that turns on the spot."""
FACING = 0.1
"""Maximum angle (rad) between the yaw of a base and the direction to a missed target at which the base drives.

At a larger angle, the base only turns towards the target.
"""


class Path(NamedTuple):
    """The points of a path: positions (m), yaws (rad) and speeds; all arrays have one element per point."""

    shares: Doubles
    """Speed at each point, as a fraction of `maxVelocity`."""
    x: Doubles
    y: Doubles
    yaws: Doubles


class StanleyControlPID(PlanarNode, type="isaacsim.robot.wheeled_robots.StanleyControlPID"):
    """Computes the speed and turn rate with which a base follows a path and then turns on the spot to the target's yaw.

    The base steers like a bicycle whose front axle is at the distance b = `gains[1]` x `wheelBase` ahead of the base. Let e be
    the signed distance from the front axle to the path, and v the measured speed. The steering angle d is the yaw of the path
    point nearest to the front axle, minus the yaw of the base, plus atan(`gains[0]` e / v), limited to `gains[2]`. A small e
    decays as exp(-`gains[0]` t). The turn rate is tan(d) / b times `linearVelocity`.

    The speeds of the path are scaled so that the largest one is `maxVelocity`. Over the last third of the path's length L, they
    are multiplied by sqrt(3 r / L), where r is the remaining length. Each execution reduces the difference between the measured
    speed and the speed of the path by the fraction `gains[1]`. If the base passes the end of the path without reaching the
    target, it turns towards the target and drives straight to it.
    """

    current_speed: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m/s", doc="velocity of the base; z is ignored")
    max_velocity: float = In(default=1.5, ge=0.0, unit="m/s", doc="largest speed on the path")
    reached_goal: Bools = In(
        default=(False, False), doc="[position reached, yaw reached], from CheckGoal2D; the base stops if both are true"
    )
    path_arrays: Doubles = In(
        required=True,
        unit="m/s, m, m, rad",
        doc="`pathArrays` of QuinticPathPlanner: the speeds at all points of the path, then all x, all y and all yaws",
    )
    target: Double3 = In(default=(0.0, 0.0, 0.0), unit="m, m, rad", doc="x, y and yaw at the end of the path")
    target_changed: bool = In(
        default=False, doc="true: start the path from its first point; a change of `pathArrays` has the same effect"
    )
    wheel_base: float = In(
        default=0.4132, gt=0.0, unit="m", doc="axle distance; the steering law uses `gains[1]` x `wheelBase`"
    )
    thresholds: Double2 = In(
        default=(0.1, 0.1),
        ge=0.0,
        unit="m, rad",
        doc="two numbers: the first is the distance from the target within which the base turns on the spot to the target's "
        "yaw; the second has no effect",
    )
    draw_path: bool = In(default=False, doc="no effect: there is no window")
    step: float = In(
        default=0.16666666667,
        gt=0.0,
        unit="s",
        doc="sets the turn rate on the spot, which is `gains[1]` / `step` times the remaining angle, at most 1 rad/s",
    )
    gains: Double3 = In(
        default=(0.5, 0.1, 0.0872665), unit="1/s, 1, rad", doc="[gain of path error, gain of speed, steering limit]"
    )
    linear_velocity: float = Out(unit="m/s", doc="forward speed of the base")
    angular_velocity: float = Out(unit="rad/s", doc="turn rate of the base, counter-clockwise")

    path: Path | None = State(default=None)
    taken: Doubles | None = State(default=None)
    nearest: int = State(default=0)
    missed: bool = State(default=False)

    def compute(self) -> None:
        """Compute and output the speeds for following the path, turning on the spot, or stopping.

        Raises:
            BadValueError: a number is not finite or is out of range, or the path is missing.
        """
        if len(self.reached_goal) >= 2 and all(self.reached_goal[:2]):
            self.linear_velocity = self.angular_velocity = 0.0
            return
        self.check()
        base = self.heading()
        path, nearest, missed = self.path, self.nearest, self.missed
        if self.target_changed or self.is_another(self.path_arrays):
            path, nearest, missed = path_of(self.path_arrays) if len(self.path_arrays) else None, 0, False
        away = math.hypot(base[0] - self.target[0], base[1] - self.target[1])
        if away <= self.thresholds[0] or any(self.reached_goal[:1]):
            speeds = self.turn(self.target[2] - base[2])
        elif path is None:
            raise BadValueError("pathArrays", [], "a path (wire pathArrays of QuinticPathPlanner to it)")
        elif missed or _is_behind(path, nearest, base):
            missed, speeds = True, self.approach(base)
        else:
            nearest, speeds = self.follow(path, nearest, base)
        check_outcome(self, *speeds)
        self.path, self.taken, self.nearest, self.missed = path, self.path_arrays, nearest, missed
        self.linear_velocity, self.angular_velocity = speeds

    def check(self) -> None:
        """Check the numeric inputs, except the pose and the path.

        Raises:
            BadValueError: a number is not finite or is out of range.
        """
        check_finite(self, "gains")
        _, gain, steering = self.gains
        if not (gain > 0.0 and 0.0 < steering < math.pi / 2):
            legal = "three numbers, the second above 0 and the third between 0 and pi/2"
            raise BadValueError("gains", self.gains, legal)
        if not self.step > 0.0:
            raise BadValueError("step", self.step, "above 0")
        if not self.wheel_base * gain > 0.0:
            raise BadValueError("wheelBase", self.wheel_base, "above 0")
        check_finite(self, "current_speed", "target", "max_velocity")

    def is_another(self, arrays: Doubles) -> bool:
        """Return whether the values of a path differ from those of the current path.

        Values are compared, because a wire that converts types makes a new array in every tick.
        """
        return arrays is not self.taken and (self.taken is None or not np.array_equal(arrays, self.taken))

    def turn(self, angle: float) -> Speeds:
        """Return the forward speed and turn rate of a turn on the spot by an angle (rad), in the shorter direction."""
        return 0.0, limited(self.gains[1] / self.step * wrapped(angle), FASTEST_TURN)

    def approach(self, base: Heading) -> Speeds:
        """Return the forward speed and turn rate with which a base turns towards the target and then drives straight to it."""
        angle = wrapped(math.atan2(self.target[1] - base[1], self.target[0] - base[0]) - base[2])
        return min(SLOWEST, self.max_velocity) if abs(angle) <= FACING else 0.0, self.turn(angle)[1]

    def follow(self, path: Path, nearest: int, base: Heading) -> tuple[int, Speeds]:
        """Return the index of the nearest path point, and the forward speed and turn rate with which a base follows the path.

        Args:
            path: path to follow.
            nearest: index of the point at which the search for the nearest point starts.
            base: pose of the base.

        Returns:
            Index of the path point nearest to the front axle, and the forward speed and turn rate.
        """
        control, gain, steering = self.gains
        ahead = gain * self.wheel_base
        front = base[0] + ahead * math.cos(base[2]), base[1] + ahead * math.sin(base[2])
        index = _nearest(path, front, nearest)
        yaw = float(path.yaws[index])
        error = (path.y[index] - front[1]) * math.cos(yaw) - (path.x[index] - front[0]) * math.sin(yaw)
        measured = math.hypot(*self.current_speed[:2])
        angle = limited(wrapped(yaw - base[2] + math.atan2(control * error, measured)), steering)
        wanted = max(float(path.shares[index]) * self.max_velocity, min(SLOWEST, self.max_velocity))
        linear = measured + gain * (wanted - measured)
        return index, (linear, linear * math.tan(angle) / ahead)


def _is_behind(path: Path, nearest: int, base: Heading) -> bool:
    """Return whether the base has passed the end of the path; `nearest` is the index of the nearest path point."""
    x, y, yaw = path.x[-1], path.y[-1], path.yaws[-1]
    along = (base[0] - x) * math.cos(yaw) + (base[1] - y) * math.sin(yaw)
    return nearest == len(path.x) - 1 and bool(along >= 0.0)


def path_of(arrays: Doubles) -> Path:
    """Return the path in an array that holds all speeds, then all x, all y and all yaws.

    The absolute speeds are divided by the largest one. Over the last third of the path's length L, they are multiplied by
    sqrt(3 r / L), where r is the remaining length. A constant speed thus becomes a constant deceleration to 0.

    Raises:
        BadValueError: the array's length is not a multiple of 4, a number is not finite, or the path's length overflows.
    """
    legal = f"four arrays of the same length, all finite, not {len(arrays)} numbers"
    if len(arrays) % 4:
        raise BadValueError("pathArrays", arrays, legal)
    speeds, x, y, yaws = arrays.reshape(4, -1)
    with np.errstate(all="ignore"):
        gone = np.concatenate(([0.0], np.hypot(np.diff(x), np.diff(y)).cumsum()))
        if not np.isfinite((*arrays, gone[-1])).all():
            raise BadValueError("pathArrays", arrays, legal)
        slowing = np.sqrt(np.clip((gone[-1] - gone) / (gone[-1] / 3.0 or 1.0), 0.0, 1.0))
    return Path(np.abs(speeds) / (np.abs(speeds).max() or 1.0) * slowing, x, y, yaws)


def _nearest(path: Path, point: tuple[float, float], index: int) -> int:
    """Return the index of the path point nearest to `point`, searched forward from `index`.

    The search stops at the first point whose successor is farther away, so it finds the earlier one of two points at a crossing.
    """
    distance = math.dist(point, (path.x[index], path.y[index]))
    while index + 1 < len(path.x):
        following = math.dist(point, (path.x[index + 1], path.y[index + 1]))
        if following > distance:
            break
        index, distance = index + 1, following
    return index
