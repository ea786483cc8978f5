"""Dead reckoning in the plane: functions that add a motion to a pose and propagate the covariance of the pose.

A motion has three components: the distance forward (m), the distance to the left (m) and the counter-clockwise turn (rad), in the
frame of the base before the motion. Its twist is constant, so its path is a straight line or an arc. A pose is x (m), y (m) and
yaw (rad, not wrapped).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Planar = tuple[float, float, float]

_MEASURED = np.ix_([0, 1, 5], [0, 1, 5])
"""Index of the 3 x 3 part for x, y and yaw in a 6 x 6 covariance of x, y, z, roll, pitch and yaw."""
NOT_MEASURED = 1e6
"""Variance of z (m2), roll and pitch (rad2), and of their velocities; it is large, as wheel encoders do not measure them."""


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


def uncertainty(covariance: Floats, pose: Planar, motion: Planar, noise: Floats) -> Floats:
    """Return the covariance (3, 3) of the pose after a motion, by linear error propagation.

    Args:
        covariance: covariance (3, 3) of the pose before the motion.
        pose: pose before the motion.
        motion: the motion.
        noise: covariance (3, 3) of the motion.
    """
    (x, y, yaw), (after_x, after_y, _) = pose, moved(pose, motion)
    east, north, halfway = after_x - x, after_y - y, yaw + motion[2] / 2.0
    cosine, sine = math.cos(halfway), math.sin(halfway)
    by_pose = np.array([[1.0, 0.0, -north], [0.0, 1.0, east], [0.0, 0.0, 1.0]])
    by_motion = np.array([[cosine, -sine, -north / 2.0], [sine, cosine, east / 2.0], [0.0, 0.0, 1.0]])
    after: Floats = by_pose @ covariance @ by_pose.T + by_motion @ noise @ by_motion.T
    return (after + after.T) / 2.0  # symmetric in spite of rounding


def in_space(covariance: Floats) -> Floats:
    """Return the covariance of x, y, z, roll, pitch and yaw as 36 numbers, row by row.

    Args:
        covariance: covariance (3, 3) of x, y and yaw.
    """
    full = np.diag([0.0, 0.0, NOT_MEASURED, NOT_MEASURED, NOT_MEASURED, 0.0])
    full[_MEASURED] = covariance
    return full.ravel()
