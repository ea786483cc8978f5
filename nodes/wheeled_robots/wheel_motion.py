"""Forward kinematics: functions that compute the motion of a base from the travel of its wheels.

`differential`, `mecanum` and `ackermann` return a matrix (3, wheels). It maps the travel of the wheels (m), left wheels first, to
the motion of the middle between the wheels: forward (m), left (m), counter-clockwise turn (rad). The same matrix maps speeds. All
functions raise ZeroDivisionError if the geometry does not determine the motion, for example if a distance is 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def differential(left: int, right: int, distance: float) -> Floats:
    """Return the matrix from wheel travel to base motion, for left and right wheels that do not steer.

    Args:
        left: number of left wheels.
        right: number of right wheels.
        distance: distance between left and right wheels, m.
    """
    turn = 1.0 / distance
    ahead = [0.5 / left] * left + [0.5 / right] * right
    return np.array([ahead, [0.0] * (left + right), [-turn / left] * left + [turn / right] * right])


def mecanum(distance: float, base: float) -> Floats:
    """Return the matrix from wheel travel to base motion, for four mecanum wheels whose roller axes form an X seen from above.

    The order of the wheels is front left, back left, front right, back right. If the base moves forward at v_x, to the left at
    v_y, and turns at w, the speed of a wheel is v_x ± v_y ± w (distance + base) / 2. The sign of v_y is negative for the front
    left and back right wheels, the sign of w for the left wheels. The matrix is the least-squares inverse of these equations.

    Args:
        distance: distance between left and right wheels, m.
        base: distance between the axles, m.
    """
    turn = 2.0 / (distance + base)
    return 0.25 * np.array([[1.0, 1.0, 1.0, 1.0], [-1.0, 1.0, 1.0, -1.0], [-turn, -turn, turn, turn]])


def ackermann(left: int, right: int, distance: float, curvature: float) -> Floats:
    """Return the matrix from wheel travel to base motion, for the wheels of the unsteered axle of a base that moves on an arc.

    Left wheels travel 1 - curvature * distance / 2 times as far as the middle of the axle, right wheels
    1 + curvature * distance / 2 times as far. The matrix is the least-squares solution of these equations.

    Args:
        left: number of left wheels.
        right: number of right wheels.
        distance: distance between left and right wheels, m.
        curvature: curvature of the arc on which the middle of the axle moves, 1/m; left is positive.
    """
    bend = curvature * distance / 2.0
    shares = np.array([1.0 - bend] * left + [1.0 + bend] * right)
    ahead: Floats = shares / (shares @ shares)
    return np.array([ahead, np.zeros(left + right), curvature * ahead])


def curvature(steering: Sequence[float], base: float, distance: float) -> float:
    """Return the curvature (1/m) of the arc on which the middle of the unsteered axle moves; left is positive.

    Args:
        steering: steering angle of a single wheel in the middle, or steering angles of the left and the right wheel, rad.
            If the two wheels have different turning centres, the mean of their curvatures is returned.
        base: distance from the unsteered axle to the steered axle, m; negative if the steered axle is behind.
        distance: distance between the steering axes of the left wheel and the right wheel, m.
    """
    sides = (0.0,) if len(steering) == 1 else (distance / 2.0, -distance / 2.0)
    curvatures = [
        math.sin(angle) / (base * math.cos(angle) + side * math.sin(angle))
        for angle, side in zip(steering, sides, strict=True)
    ]
    return sum(curvatures) / len(curvatures)
