"""Dead reckoning in the plane: functions that add a motion to a pose and propagate the covariance of the pose.

A motion has three components: the distance forward (m), the distance to the left (m) and the counter-clockwise turn (rad), in the
frame of the base before the motion. Its twist is constant, so its path is a straight line or an arc. A pose is x (m), y (m) and
yaw (rad, not wrapped).
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Planar = tuple[float, float, float]

NOT_MEASURED = 1e6
"""Variance of z (m2), roll and pitch (rad2), and of their velocities; it is large, as wheel encoders do not measure them."""
_MATRICES, _ROW, _COVARIANCE = struct.Struct("54d"), struct.Struct("3d"), struct.Struct("9d")
_NOT_MEASURED = np.diag([0.0, 0.0, NOT_MEASURED, NOT_MEASURED, NOT_MEASURED, 0.0]).ravel()


def moved(pose: Planar, motion: Planar) -> Planar:
    """Return the pose after a motion along a straight line or an arc.

    The displacement is the chord of the arc. It is sin(turn / 2) / (turn / 2) times as long as the arc, and its direction is the
    initial direction of the motion, rotated by turn / 2.
    """
    (x, y, yaw), (ahead, left, turn) = pose, motion
    half = turn / 2.0
    chord = math.sin(half) / half if half else 1.0
    cosine, sine = chord * math.cos(yaw + half), chord * math.sin(yaw + half)
    return x + ahead * cosine - left * sine, y + ahead * sine + left * cosine, yaw + turn


def to_origin(point: tuple[float, float]) -> Floats:
    """Return the matrix (3, 3) that maps the motion of a point of the base to the motion of the origin of the base's frame.

    Args:
        point: x and y of the point in the base's frame, m.
    """
    x, y = point
    return np.array([[1.0, 0.0, y], [0.0, 1.0, -x], [0.0, 0.0, 1.0]])


class Propagation:
    """Propagates the covariance of a pose; it keeps its matrices from one motion to the next.

    With the Jacobians F of the pose after a motion by the pose before it and G by the motion, the covariance P becomes
    F P F^T + (G N) G^T. Two products of larger matrices, whose blocks of zeros and ones only add terms of 0, round like the
    three products and the sum, in less time: [F P, (G N) G^T] = [F, G N] [P, 0; 0, G^T], and its product with [F^T; 1].
    """

    def __init__(self) -> None:
        numbers = np.zeros(18 + 36)
        self._left, self._right = numbers[:18].reshape(3, 6), numbers[18:].reshape(6, 6)
        self._both, self._last, self._sum = np.zeros((3, 6)), np.vstack([np.eye(3)] * 2), np.zeros((3, 3))
        self._matrices, self._row, self._result = numbers.data, self._last[2].data, self._sum.data

    def propagate(
        self, covariance: Sequence[float], pose: Planar, after: Planar, turn: float, noise: Planar
    ) -> Sequence[float]:
        """Return the covariance of the pose after a motion, by linear error propagation.

        Covariances of x, y and yaw are 9 numbers, row by row.

        Args:
            covariance: covariance of the pose before the motion.
            pose: pose before the motion.
            after: pose after the motion, from `moved`.
            turn: turn of the motion, rad.
            noise: independent variances of the motion: forward (m2), left (m2), turn (rad2).
        """
        (x, y, yaw), (after_x, after_y, _), (ahead, left, about) = pose, after, noise
        north, east, halfway = after_y - y, after_x - x, yaw + turn / 2.0
        cosine, sine, half_north, half_east = math.cos(halfway), math.sin(halfway), north / 2.0, east / 2.0
        a, b, c, d, e, f, g, h, i = covariance
        _MATRICES.pack_into(
            self._matrices,
            0,
            *(1.0, 0.0, -north, cosine * ahead, -sine * left, -half_north * about),
            *(0.0, 1.0, east, sine * ahead, cosine * left, half_east * about),
            *(0.0, 0.0, 1.0, 0.0, 0.0, about),
            *(a, b, c, 0.0, 0.0, 0.0, d, e, f, 0.0, 0.0, 0.0, g, h, i, 0.0, 0.0, 0.0),
            *(0.0, 0.0, 0.0, cosine, sine, 0.0, 0.0, 0.0, 0.0, -sine, cosine, 0.0),
            *(0.0, 0.0, 0.0, -half_north, half_east, 1.0),
        )
        _ROW.pack_into(self._row, 0, -north, east, 1.0)
        # `dot` has half the overhead of `@`, and does not warn of numbers that are not finite
        self._left.dot(self._right, self._both).dot(self._last, self._sum)
        a, b, c, d, e, f, g, h, i = _COVARIANCE.unpack_from(self._result)
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
