"""Directions of rays, and vectors."""

from __future__ import annotations

import math

from graphengine.descriptions.engine import Floats
from graphengine.physics.kernels.compiled import part

Vector = tuple[float, float, float]
Spread = tuple[float, float, float, float, float, float]
"""Inverse bounds of the directions of several rays: 1 / the greatest x, y and z, then 1 / the least x, y and z."""

TINY = 1e-15
"""MuJoCo's mjMINVAL: numbers with a smaller magnitude count as zero."""


@part
def over(bound: float, outwards: float) -> float:
    """Return 1 / bound; for a bound of 0 a huge number with the sign of `outwards`, which widens the range of directions."""
    return 1.0 / bound if bound != 0.0 else outwards * 1e300


@part
def reach(spread: Spread, origin: Vector, low: Floats | Vector, high: Floats | Vector, farthest: float) -> float:
    """Return the distance from which rays with directions within the bounds can hit a box; infinity if not within `farthest`.

    At distance t from the origin, the rays span the range from least * t to most * t along each axis. They reach the box where
    most * t >= low and least * t <= high. Each condition bounds t from below or from above, depending on the sign of its factor.
    """
    nearest = 0.0
    for axis in range(3):
        bound = (low[axis] - origin[axis]) * spread[axis]
        if spread[axis] > 0.0:
            nearest = max(nearest, bound)
        else:
            farthest = min(farthest, bound)
        bound = (high[axis] - origin[axis]) * spread[3 + axis]
        if spread[3 + axis] < 0.0:
            nearest = max(nearest, bound)
        else:
            farthest = min(farthest, bound)
    return nearest if nearest <= farthest else math.inf


@part
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@part
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product of two vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
