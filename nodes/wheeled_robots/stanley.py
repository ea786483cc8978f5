"""Following a path by the law that steered Stanley (G. M. Hoffmann et al., Autonomous automobile trajectory tracking, 2007)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphengine.node import In, Out, State
from graphengine.types import Bools, Double2, Double3, Doubles, Vector3d
from nodes.wheeled_robots.limits import limited
from nodes.wheeled_robots.planar import Heading, PlanarNode, wrapped

Floats = NDArray[np.float64]

SLOWEST = 0.05
"""m/s at which a path is followed to its end, and the target approached from beyond it."""
FASTEST_TURN = 1.0
"""rad/s of a turn on the spot."""
FACING = 0.1
"""rad by which a base may look past the target and still drive to it."""


class Path(NamedTuple):
    """Points of a path."""

    shares: Floats
    """Of `maxVelocity`, with which to pass."""
    x: Floats
    y: Floats
    yaws: Floats


class StanleyControlPID(PlanarNode, type="isaacsim.robot.wheeled_robots.StanleyControlPID"):
    """Speeds with which a base follows a path and then, at the target, turns to its yaw on the spot.

    It is steered as a bicycle whose front axle is b = gains[1] x wheelBase ahead: by the yaw of the nearest point of the path
    less its own, plus atan(gains[0] e / v), with e from the front axle to the path and v the measured speed, and by no more than
    gains[2]. A small e then decays as exp(-gains[0] t). With the steering angle d the base turns at v tan(d) / b.

    The path's speeds are scaled so that the greatest is maxVelocity; over the last third of its length the base slows down
    evenly. From one compute to the next its speed comes nearer to the path's by gains[1]. Should it miss the target, it turns
    towards it at the path's end and goes there straight.
    """

    current_speed: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m/s", doc="of the base; what counts is hypot(x, y)")
    max_velocity: float = In(default=1.5, ge=0.0, unit="m/s")
    reached_goal: Bools = In(default=(False, False), doc="from CheckGoal2D; when both are true, the base stands")
    path_arrays: Doubles = In(required=True, unit="m/s, m, m, rad", doc="from QuinticPathPlanner")
    target: Double3 = In(default=(0.0, 0.0, 0.0), unit="m, m, rad", doc="x, y and yaw at which the path ends")
    target_changed: bool = In(default=False, doc="the path begins anew, as it does when it is another")
    wheel_base: float = In(default=0.4132, gt=0.0, unit="m", doc="from axle to axle, before gains[1] scales it")
    thresholds: Double2 = In(
        default=(0.1, 0.1), unit="m, rad", doc="as in CheckGoal2D; within [0] it turns on the spot"
    )
    draw_path: bool = In(default=False, doc="means nothing here: there is no window")
    step: float = In(
        default=0.16666666667, gt=0.0, unit="s", doc="on the spot it turns at gains[1] / step of the angle"
    )
    gains: Double3 = In(default=(0.5, 0.1, 0.0872665), unit="1/s, 1, rad", doc="to the path, of speed, most steering")
    linear_velocity: float = Out(unit="m/s", doc="forward")
    angular_velocity: float = Out(unit="rad/s", doc="counter-clockwise")

    path: Path | None = State(default=None)
    taken: Doubles | None = State(default=None)
    nearest: int = State(default=0)
    missed: bool = State(default=False)

    def compute(self) -> None:
        """Drive, turn, or stand."""
        if len(self.reached_goal) >= 2 and all(self.reached_goal[:2]):
            self.linear_velocity = self.angular_velocity = 0.0
            return
        self.check()
        base = self.heading()
        if self.target_changed or self.is_another(self.path_arrays):
            self.path = path_of(self.path_arrays) if len(self.path_arrays) else None
            self.taken, self.nearest, self.missed = self.path_arrays, 0, False
        away = math.hypot(base[0] - self.target[0], base[1] - self.target[1])
        if away <= self.thresholds[0] or any(self.reached_goal[:1]):
            self.turn(self.target[2] - base[2])
        elif self.path is None:
            raise ValueError("pathArrays is empty; wire pathArrays of QuinticPathPlanner to it")
        elif self.missed or self.is_behind(self.path, base):
            self.missed = True
            self.approach(base)
        else:
            self.follow(self.path, base)

    def check(self) -> None:
        """Refuse numbers that mean nothing.

        Raises:
            ValueError: there is one.
        """
        _, gain, steering = self.gains
        if not (self.wheel_base > 0.0 and self.step > 0.0 and gain > 0.0 and 0.0 < steering < math.pi / 2):
            raise ValueError(
                "wheelBase, step and gains[1] must be more than 0 and gains[2] between 0 and pi/2, "
                f"they are {self.wheel_base:g}, {self.step:g}, {gain:g} and {steering:g}"
            )
        if not all(map(math.isfinite, (*self.current_speed, *self.target, *self.gains, self.max_velocity))):
            raise ValueError(
                "currentSpeed, target, gains and maxVelocity must be finite, "
                f"they are {self.current_speed}, {self.target}, {self.gains} and {self.max_velocity:g}"
            )

    def is_another(self, arrays: Doubles) -> bool:
        """Whether a path is another than the one that was taken; what converts on its way is a new array in every tick."""
        return arrays is not self.taken and (self.taken is None or not np.array_equal(arrays, self.taken))

    def turn(self, angle: float) -> None:
        """Turn by an angle on the spot, the shorter way."""
        self.linear_velocity = 0.0
        self.angular_velocity = limited(self.gains[1] / self.step * wrapped(angle), FASTEST_TURN)

    def approach(self, base: Heading) -> None:
        """Go straight to the target, as soon as the base looks there."""
        angle = wrapped(math.atan2(self.target[1] - base[1], self.target[0] - base[0]) - base[2])
        self.turn(angle)
        if abs(angle) <= FACING:
            self.linear_velocity = min(SLOWEST, self.max_velocity)

    def is_behind(self, path: Path, base: Heading) -> bool:
        """Whether the base has come to the path's end, and beyond."""
        x, y, yaw = path.x[-1], path.y[-1], path.yaws[-1]
        along = (base[0] - x) * math.cos(yaw) + (base[1] - y) * math.sin(yaw)
        return self.nearest == len(path.x) - 1 and bool(along >= 0.0)

    def follow(self, path: Path, base: Heading) -> None:
        """Steer towards the path, and along it."""
        control, gain, steering = self.gains
        ahead = gain * self.wheel_base
        front = base[0] + ahead * math.cos(base[2]), base[1] + ahead * math.sin(base[2])
        self.nearest = index = _nearest(path, front, self.nearest)
        yaw = float(path.yaws[index])
        error = (path.y[index] - front[1]) * math.cos(yaw) - (path.x[index] - front[0]) * math.sin(yaw)
        measured = math.hypot(*self.current_speed[:2])
        angle = limited(wrapped(yaw - base[2] + math.atan2(control * error, measured)), steering)
        wanted = max(float(path.shares[index]) * self.max_velocity, min(SLOWEST, self.max_velocity))
        self.linear_velocity = measured + gain * (wanted - measured)
        self.angular_velocity = self.linear_velocity * math.tan(angle) / ahead


def path_of(arrays: Doubles) -> Path:
    """A path from its arrays in one row: speeds, x, y, yaws.

    Where a base slows down evenly to stand, the square of its speed is proportional to the way that remains.

    Raises:
        ValueError: they are not four of one length, or not finite.
    """
    if len(arrays) % 4 or not np.isfinite(arrays).all():
        raise ValueError(f"pathArrays must be four arrays of one length, all finite; it has {len(arrays)} numbers")
    speeds, x, y, yaws = arrays.reshape(4, -1)
    gone = np.concatenate(([0.0], np.hypot(np.diff(x), np.diff(y)).cumsum()))
    slowing = np.sqrt(np.clip((gone[-1] - gone) / (gone[-1] / 3.0 or 1.0), 0.0, 1.0))
    return Path(np.abs(speeds) / (np.abs(speeds).max() or 1.0) * slowing, x, y, yaws)


def _nearest(path: Path, point: tuple[float, float], index: int) -> int:
    """The nearest point of the path from there on; where it passes by itself again, what comes first."""
    distance = math.dist(point, (path.x[index], path.y[index]))
    while index + 1 < len(path.x):
        following = math.dist(point, (path.x[index + 1], path.y[index + 1]))
        if following > distance:
            break
        index, distance = index + 1, following
    return index
