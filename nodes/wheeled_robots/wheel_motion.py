"""Motion of a base from the travel of its wheels: forward kinematics.

`differential`, `mecanum` and `ackermann` return the matrix (3, wheels) from the travel of the wheels (m), left ones first, to the
motion of their middle: forward (m), left (m), counter-clockwise turn (rad). All functions raise ZeroDivisionError for a geometry
in which wheels do not determine the motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def differential(left: int, right: int, distance: float) -> Floats:
    """Return the matrix from wheel speeds to forward, sideways and turning speed, for wheels that do not steer.

    Args:
        left: number of left wheels.
        right: number of right wheels.
        distance: distance between left and right wheels, m.
    """
    turn = 1.0 / distance
    ahead = [0.5 / left] * left + [0.5 / right] * right
    return np.array([ahead, [0.0] * (left + right), [-turn / left] * left + [turn / right] * right])


def mecanum(distance: float, base: float) -> Floats:
    """Return the matrix for four mecanum wheels (front left, back left, front right, back right) with roller axes in an X.

    It is the least-squares inverse of the wheel speeds v_x -+ v_y -+ w (distance + base) / 2 for velocities v_x forward and v_y
    left and a turn rate w: -v_y for the front left and back right wheels, -w for the left wheels.

    Args:
        distance: distance between left and right wheels, m.
        base: distance between the axles, m.
    """
    turn = 2.0 / (distance + base)
    return 0.25 * np.array([[1.0, 1.0, 1.0, 1.0], [-1.0, 1.0, 1.0, -1.0], [-turn, -turn, turn, turn]])


def ackermann(left: int, right: int, distance: float, curvature: float) -> Floats:
    """Return the matrix for the wheels of the unsteered axle, whose middle moves on an arc.

    Left wheels travel 1 - curvature * distance / 2 times as far as the middle, right wheels 1 + curvature * distance / 2 times;
    the matrix is the least-squares solution.

    Args:
        left: number of left wheels.
        right: number of right wheels.
        distance: distance between left and right wheels, m.
        curvature: curvature of the arc, 1/m; left is positive.
    """
    bend = curvature * distance / 2.0
    shares = np.array([1.0 - bend] * left + [1.0 + bend] * right)
    ahead: Floats = shares / (shares @ shares)
    return np.array([ahead, np.zeros(left + right), curvature * ahead])


def curvature(steering: Sequence[float], base: float, distance: float) -> float:
    """Return the curvature (1/m) of the arc on which the middle of the unsteered axle moves; left is positive.

    Args:
        steering: angle of one steered wheel in the middle, or of the left and the right wheel, rad. If the angles of
            the two wheels belong to different turning centres, the mean of the curvatures is returned.
        base: distance from the unsteered axle forward to the steered one, m.
        distance: distance between the axes about which the left and right wheels steer, m.
    """
    sides = (0.0,) if len(steering) == 1 else (distance / 2.0, -distance / 2.0)
    curvatures = [
        math.sin(angle) / (base * math.cos(angle) + side * math.sin(angle))
        for angle, side in zip(steering, sides, strict=True)
    ]
    return sum(curvatures) / len(curvatures)
