"""Dead reckoning in the plane: functions that add a motion to a pose and propagate the covariance of the pose.

A motion has three components: the distance forward (m), the distance to the left (m) and the counter-clockwise turn (rad), in the
frame of the base before the motion. Its twist is constant, so its path is a straight line or an arc. A pose is x (m), y (m) and
yaw (rad, not wrapped).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Planar = tuple[float, float, float]

NOT_MEASURED = 1e6
"""Variance of z (m2), roll and pitch (rad2), and of their velocities; it is large, as wheel encoders do not measure them."""
_NOT_MEASURED = np.diag([0.0, 0.0, NOT_MEASURED, NOT_MEASURED, NOT_MEASURED, 0.0]).ravel()


def moved(pose: Planar, motion: Planar) -> Planar:
    """Return the pose after a motion along a straight line or an arc.

    The displacement is the chord of the arc. It is sin(turn / 2) / (turn / 2) times as long as the arc, and its direction is the
    initial direction of the motion, rotated by turn / 2.
    """
    (x, y, yaw), (ahead, left, turn) = pose, motion
    halfway = yaw + turn / 2.0
    chord = math.sin(turn / 2.0) / (turn / 2.0) if turn else 1.0
    cosine, sine = chord * math.cos(halfway), chord * math.sin(halfway)
    return x + ahead * cosine - left * sine, y + ahead * sine + left * cosine, yaw + turn


def to_origin(point: tuple[float, float]) -> Floats:
    """Return the matrix (3, 3) that maps the motion of a point of the base to the motion of the origin of the base's frame.

    Args:
        point: x and y of the point in the base's frame, m.
    """
    x, y = point
    return np.array([[1.0, 0.0, y], [0.0, 1.0, -x], [0.0, 0.0, 1.0]])


class Propagation:
    """Propagates the covariance of a pose; it keeps its matrices from one motion to the next."""

    def __init__(self) -> None:
        self._numbers = np.zeros(36)
        by_pose, self._before, by_motion, self._scaled = self._numbers.reshape(4, 3, 3)
        self._by_pose, self._by_pose_transposed, self._by_motion_transposed = by_pose, by_pose.T, by_motion.T

    def propagate(
        self, covariance: Sequence[float], pose: Planar, after: Planar, turn: float, noise: Planar
    ) -> Sequence[float]:
        """Return the covariance of the pose after a motion, by linear error propagation.

        Covariances of x, y and yaw are 9 numbers, row by row.

        Args:
            covariance: covariance of the pose before the motion.
            pose: pose before the motion.
            after: pose after the motion, as `moved` returns it.
            turn: turn of the motion, rad.
            noise: variances of the motion, which are independent: forward (m2), left (m2), turn (rad2).
        """
        (x, y, yaw), (after_x, after_y, _), (ahead, left, about) = pose, after, noise
        north, east, halfway = after_y - y, after_x - x, yaw + turn / 2.0
        cosine, sine, half_north, half_east = math.cos(halfway), math.sin(halfway), north / 2.0, east / 2.0
        self._numbers[:] = (
            *(1.0, 0.0, -north, 0.0, 1.0, east, 0.0, 0.0, 1.0),
            *covariance,
            *(cosine, -sine, -half_north, sine, cosine, half_east, 0.0, 0.0, 1.0),
            *(cosine * ahead, -sine * left, -half_north * about, sine * ahead, cosine * left, half_east * about),
            *(0.0, 0.0, about),
        )
        # `dot` has half the overhead of `@`, and does not warn of numbers that are not finite
        of_pose = self._by_pose.dot(self._before).dot(self._by_pose_transposed)
        (a, b, c), (d, e, f), (g, h, i) = (of_pose + self._scaled.dot(self._by_motion_transposed)).tolist()
        u, v, w = (b + d) / 2.0, (c + g) / 2.0, (f + h) / 2.0  # symmetric in spite of rounding
        return a, u, v, u, e, w, v, w, i


def in_space(covariance: Sequence[float]) -> Floats:
    """Return the covariance of x, y, z, roll, pitch and yaw as 36 numbers, row by row.

    Args:
        covariance: covariance of x, y and yaw as 9 numbers, row by row.
    """
    full = _NOT_MEASURED.copy()
    full[0], full[1], full[5], full[6], full[7], full[11], full[30], full[31], full[35] = covariance
    return full
