"""The path planner with quintic polynomials.

Position, velocity and acceleration at both ends of a path determine the six coefficients of each polynomial (A. Takahashi et al.,
Local path planning and motion control for AGV in positioning, 1989).
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.polynomial import polynomial

from graphengine.devices.motion import Frame
from graphengine.node import BadValueError, Bound, Context, In, Out, State
from graphengine.node.types import Double3, Doubles, Quaterniond, Target, Vector3d
from graphengine.nodes.checked import check_finite
from graphengine.nodes.touched import reading_poses
from graphengine.nodes.wheeled_robots.planar import Heading, PlanarNode, heading_of, wrapped

DURATIONS = range(5, 100, 5)
"""Durations of a path (s) that the planner tries in this order; it uses the first one that respects the limits."""
SHORTEST_STEP = 0.001
"""Shortest time between two points of a path, s."""
MOVED, TURNED = 0.1, 0.05
"""Smallest changes of the target since the last plan, in x or y (m) and in yaw (rad), for which the node plans a new path."""

_ENDS = np.array(
    [
        [1, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0],
        [0, 0, 2, 0, 0, 0],
        [1, 1, 1, 1, 1, 1],
        [0, 1, 2, 3, 4, 5],
        [0, 0, 2, 6, 12, 20],
    ]
)
"""Matrix that maps the coefficients (powers 0 to 5) of a polynomial p(s) to p, p' and p'' at s = 0, then at s = 1."""


class QuinticPathPlanner(PlanarNode, type="isaacsim.robot.wheeled_robots.QuinticPathPlanner"):
    """Plans a path from the pose of a base to a target pose, with given speeds and accelerations at both ends.

    x and y are quintic polynomials of time. At each end, velocity and acceleration have the direction of the yaw. The duration
    of the path is the first of 5, 10, … 95 s for which the path respects `maxAccel` and `maxJerk`. The node plans a new path
    only if the target has moved by at least 0.1 m in x or y, or turned by at least 0.05 rad, since the last plan.
    """

    target_prim: Target = In(
        default=(), setup=True, doc="prim at the target; if empty, `targetPosition` and `targetOrientation` are used"
    )
    target_position: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m", doc="position in the world frame; z is ignored")
    target_orientation: Quaterniond = In(
        default=(0.0, 0.0, 0.0, 1.0), doc="orientation (x, y, z, w) in the world frame; only its yaw is used"
    )
    initial_velocity: float = In(default=0.5, ge=0.0, unit="m/s", doc="speed at the start, along the yaw of the base")
    initial_accel: float = In(default=0.02, unit="m/s2", doc="acceleration at the start, along the yaw of the base")
    goal_velocity: float = In(default=0.5, ge=0.0, unit="m/s", doc="speed at the target, along the target's yaw")
    goal_accel: float = In(default=0.02, unit="m/s2", doc="acceleration at the target, along the target's yaw")
    max_accel: float = In(default=1.5, ge=0.0, unit="m/s2", doc="largest acceleration on the path")
    max_jerk: float = In(default=0.3, ge=0.0, unit="m/s3", doc="largest jerk on the path")
    step: float = In(default=0.16666666667, ge=SHORTEST_STEP, unit="s", doc="longest time between two path points")
    path_arrays: Doubles = Out(unit="m/s, m, m, rad", doc="path: the speeds at all points, then all x, all y, all yaws")
    target: Double3 = Out(unit="m, m, rad", doc="x, y and yaw at the end of the path")
    target_changed: bool = Out(doc="true if this execution planned a new path")

    goal: Frame | None = Bound()
    planned: Heading | None = State(default=None)

    def setup(self, context: Context) -> None:
        """Look up the prim at `targetPrim`, if it is not empty, and keep a handle to its pose.

        Raises:
            ContextError: the prim does not exist.
        """
        self.goal = context.frame(self.target_prim[0]) if self.target_prim else None

    def compute(self) -> None:
        """Plan and output a new path if the target has moved.

        Raises:
            BadValueError: a number is not finite, `step` is too short, or no duration gives a path that respects the limits.
        """
        target = self.target_now()
        changed = self.planned is None or _differs(target, self.planned)
        if changed:
            self.path_arrays = self.plan(self.heading(), target)
            self.target = self.planned = target
        self.target_changed = changed

    def reads(self) -> Iterable[str]:
        """Return the resource keys of the target prim's pose; no keys if `targetPrim` is empty."""
        return reading_poses(self.target_prim) if self.target_prim else ()

    def target_now(self) -> Heading:
        """Return x (m), y (m) and yaw (rad) of the target, from the target prim or the inputs.

        Raises:
            BadValueError: x, y or the yaw is not finite.
        """
        goal = self.goal
        position, orientation = goal.pose() if goal else (self.target_position, self.target_orientation)
        return heading_of(("targetPosition", position), ("targetOrientation", orientation))

    def plan(self, start: Heading, target: Heading) -> Doubles:
        """Plan a path, and return all speeds, all x, all y and all yaws of its points in one array.

        Args:
            start: pose at the start of the path.
            target: pose at the end of the path.

        Raises:
            BadValueError: no duration gives a path that respects the limits, `step` is too short, or a number is not finite.
        """
        if not self.step >= SHORTEST_STEP:
            raise BadValueError("step", self.step, f"{SHORTEST_STEP} s or more")
        check_finite(self, "initial_velocity", "initial_accel", "goal_velocity", "goal_accel")
        first = _end(start, self.initial_velocity, self.initial_accel)
        ends = np.concatenate((first, _end(target, self.goal_velocity, self.goal_accel)))
        with np.errstate(all="ignore"):  # what is not finite keeps to no limit
            for duration in DURATIONS:
                coefficients = quintic(ends, duration)
                acceleration, jerk = (_most(derivative(coefficients, order, duration)) for order in (2, 3))
                if acceleration <= self.max_accel and jerk <= self.max_jerk:
                    return _arrays(coefficients, duration, math.ceil(duration / self.step), start[2], target[2])
        raise BadValueError(
            "currentPosition, currentOrientation, targetPosition, targetOrientation, initialVelocity, initialAccel, "
            "goalVelocity, goalAccel",
            (start, target),
            f"the start and the end of a path of {duration} s or less that respects maxAccel {self.max_accel:g} m/s2 and "
            f"maxJerk {self.max_jerk:g} m/s3; the path of {duration} s needs {acceleration:.3g} m/s2 and {jerk:.3g} m/s3",
        )


def quintic(ends: Doubles, duration: float) -> Doubles:
    """Return the coefficients of n quintic polynomials p(s), where s is the time divided by the duration, from 0 to 1.

    Args:
        ends: array (6, n): position (m), velocity (m/s) and acceleration (m/s2) at the start, then at the end.
        duration: time from start to end, s.

    Returns:
        Array (6, n) with the coefficients of the powers 0 to 5.
    """
    scale = np.array((1.0, duration, duration**2) * 2)
    return np.linalg.solve(_ENDS, ends * scale[:, None])


def derivative(coefficients: Doubles, order: int, duration: float, intervals: int = 100) -> Doubles:
    """Return the values of a time derivative of n polynomials, at equidistant times from start to end.

    Args:
        coefficients: coefficients (6, n) from `quintic`.
        order: 0 for the position (m), 1 for the velocity (m/s), 2 for the acceleration (m/s2), 3 for the jerk (m/s3).
        duration: time from start to end, s.
        intervals: number of intervals between the times.

    Returns:
        Array of shape (n, intervals + 1).
    """
    shares = np.linspace(0.0, 1.0, intervals + 1)
    found = polynomial.polyval(shares, polynomial.polyder(coefficients, order)) / duration**order
    return np.asarray(found, np.float64)


def _end(heading: Heading, speed: float, acceleration: float) -> Doubles:
    """Return the array (3, 2) of position (m), velocity (m/s) and acceleration (m/s2) at one end of a path.

    Args:
        heading: pose at this end.
        speed: speed along the yaw, m/s.
        acceleration: acceleration along the yaw, m/s2.
    """
    along = np.array((math.cos(heading[2]), math.sin(heading[2])))
    return np.array((heading[:2], speed * along, acceleration * along))


def _most(vectors: Doubles) -> float:
    """Return the largest length of n vectors in the plane, given as an array (2, n)."""
    return float(np.hypot(*vectors).max())


def _arrays(coefficients: Doubles, duration: float, intervals: int, first_yaw: float, last_yaw: float) -> Doubles:
    """Return all speeds, all x, all y and all yaws of the points of a path in one array.

    The yaw of a point is the direction of its velocity; a point with the speed 0 gets the yaw of the point before it.

    Args:
        coefficients: coefficients (6, 2) of x and y, from `quintic`.
        duration: duration of the path, s.
        intervals: number of intervals between the points.
        first_yaw: yaw of the first point, rad.
        last_yaw: yaw of the last point, rad.
    """
    x, y = derivative(coefficients, 0, duration, intervals)
    vx, vy = derivative(coefficients, 1, duration, intervals)
    speeds, yaws = np.hypot(vx, vy), np.arctan2(vy, vx)
    yaws[0] = first_yaw
    yaws = yaws[np.maximum.accumulate(np.where(speeds > 1e-9, np.arange(len(yaws)), 0))]
    yaws[-1] = last_yaw
    return np.concatenate((speeds, x, y, yaws))


def _differs(target: Heading, planned: Heading) -> bool:
    moved = max(abs(target[0] - planned[0]), abs(target[1] - planned[1]))
    return moved >= MOVED or abs(wrapped(target[2] - planned[2])) >= TURNED
