"""Splines through the points of a joint trajectory.

Between two points, the positions follow a polynomial, as in joint_trajectory_controller: it is linear if the points have only
positions, cubic if both have velocities too, and quintic if both have velocities and accelerations.
"""

from __future__ import annotations

import bisect
import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphengine.format.stateful import Shared

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class JointPoint(Shared):
    """Positions (rad or m) of joints at one time, and their velocities and accelerations if known.

    A point equals only itself, because `_polynomial` remembers its results by points.
    """

    time: float
    """Simulation time since play, s."""
    positions: Floats
    velocities: Floats | None = None
    accelerations: Floats | None = None


@dataclass(frozen=True, slots=True)
class JointSpline(Shared):
    """The motion of joints through a sequence of points; before the first point and after the last point, the joints rest."""

    points: tuple[JointPoint, ...]
    """One point or more, in order of time; no two points have the same time."""

    @property
    def end(self) -> float:
        """Time of the last point, s."""
        return self.points[-1].time

    def sample(self, time: float) -> tuple[Floats, Floats]:
        """Return the positions (rad or m) and the velocities (rad/s or m/s) of the joints at a time (s)."""
        points = self.points
        following = bisect.bisect_right(points, time, key=lambda point: point.time)
        if following in (0, len(points)):
            positions = points[max(following - 1, 0)].positions
            return positions, np.zeros_like(positions)
        before, after = points[following - 1], points[following]
        coefficients, elapsed = _polynomial(before, after), time - before.time
        position = coefficients[-1]
        velocity: Floats = position + 0.0  # without negative zeros
        position = position * elapsed + coefficients[-2]
        for coefficient in coefficients[-3::-1]:  # Horner's rule for the polynomial and its derivative
            velocity = velocity * elapsed + position
            position = position * elapsed + coefficient
        return position, velocity


@functools.lru_cache(maxsize=256)
def _polynomial(before: JointPoint, after: JointPoint) -> list[Floats]:
    """Return the coefficients of the polynomial between two points, lowest power first, for the time since the first point.

    They are computed for a time that runs from 0 to 1, in which velocities and accelerations are multiplied by the duration and
    by its square, and then scaled to seconds.
    """
    duration = after.time - before.time
    start, step = before.positions, after.positions - before.positions
    if before.velocities is None or after.velocities is None:
        return [start, step / duration]
    v0, v1 = before.velocities * duration, after.velocities * duration
    if before.accelerations is None or after.accelerations is None:
        scaled = [v0, 3.0 * step - 2.0 * v0 - v1, v0 + v1 - 2.0 * step]
    else:
        a0, a1 = before.accelerations * duration**2, after.accelerations * duration**2
        scaled = [
            v0,
            0.5 * a0,
            10.0 * step - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1,
            -15.0 * step + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1,
            6.0 * step - 3.0 * (v0 + v1) - 0.5 * a0 + 0.5 * a1,
        ]
    return [start, *(value / duration**power for power, value in enumerate(scaled, 1))]
