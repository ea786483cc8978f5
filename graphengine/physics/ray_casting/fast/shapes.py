"""Finds where a ray hits the surface of a geom. The surfaces are the same as in `mj_ray`."""

from __future__ import annotations

import math

from graphengine.physics.kernels.compiled import part
from graphengine.physics.ray_casting.fast.directions import TINY, Vector, dot
from graphengine.physics.ray_casting.fast.table import BOX, CAPSULE, CYLINDER, ELLIPSOID, PLANE, SPHERE

_CLEAR = 1e-9
"""How far below 0 a discriminant must be for a ray to miss an endless cylinder despite rounding, m2."""


@part
def distance_to(kind: int, size: Vector, start: Vector, way: Vector) -> float:
    """Return the distance along a ray to the surface of a geom, in the geom's frame; infinity without a hit."""
    if kind == BOX:
        return _box(size, start, way)
    if kind == CYLINDER:
        return _cylinder(size, start, way)
    if kind == PLANE:
        return _plane(size, start, way)
    if kind == CAPSULE:
        return _capsule(size, start, way)
    if kind == SPHERE:
        return _first(*_roots(dot(way, way), dot(way, start), dot(start, start) - size[0] * size[0]))
    if kind == ELLIPSOID:
        shrunk = (start[0] / size[0], start[1] / size[1], start[2] / size[2])
        along = (way[0] / size[0], way[1] / size[1], way[2] / size[2])
        return _first(*_roots(dot(along, along), dot(along, shrunk), dot(shrunk, shrunk) - 1.0))
    return math.inf


@part
def _roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the real roots of a t^2 + 2 b t + c, the smaller one first; infinities if there are none."""
    discriminant = b * b - a * c
    if discriminant < 0.0 or a < TINY:
        return math.inf, math.inf
    root = math.sqrt(discriminant)
    return (-b - root) / a, (-b + root) / a


@part
def _first(near: float, far: float) -> float:
    """Return the smaller non-negative one of the distances at which a line enters and leaves a shape; infinity without one."""
    if near >= 0.0:
        return near
    return far if far >= 0.0 else math.inf


@part
def _box(size: Vector, start: Vector, way: Vector) -> float:
    near, far = -math.inf, math.inf
    for axis in range(3):
        if abs(way[axis]) > TINY:
            over = 1.0 / way[axis]
            one, other = (-size[axis] - start[axis]) * over, (size[axis] - start[axis]) * over
            near = max(near, min(one, other))
            far = min(far, max(one, other))
        elif abs(start[axis]) > size[axis]:
            return math.inf
    return _first(near, far) if near <= far else math.inf


@part
def _plane(size: Vector, start: Vector, way: Vector) -> float:
    """Return the distance to the front of a plane; infinity without a hit. A `size` of 0 stands for an infinite plane."""
    if way[2] > -TINY or start[2] < 0.0:
        return math.inf
    distance = -start[2] / way[2]
    x, y = start[0] + distance * way[0], start[1] + distance * way[1]
    if (size[0] > 0.0 and abs(x) > size[0]) or (size[1] > 0.0 and abs(y) > size[1]):
        return math.inf
    return distance


@part
def _side(size: Vector, start: Vector, way: Vector) -> float:
    """Return the distance along a ray to the round side of a cylinder whose `size` is radius and half height."""
    distance = _first(*_roots(*_flat(size, start, way)))
    return distance if abs(start[2] + distance * way[2]) <= size[1] else math.inf


@part
def _flat(size: Vector, start: Vector, way: Vector) -> Vector:
    """Return the coefficients for `_roots` of a ray and the round side of an endless cylinder; `size` begins with its radius."""
    across = way[0] * way[0] + way[1] * way[1]
    towards = way[0] * start[0] + way[1] * start[1]
    return across, towards, start[0] * start[0] + start[1] * start[1] - size[0] * size[0]


@part
def _cylinder(size: Vector, start: Vector, way: Vector) -> float:
    distance = _side(size, start, way)
    if abs(way[2]) > TINY:
        for end in (-size[1], size[1]):
            flat = (end - start[2]) / way[2]
            x, y = start[0] + flat * way[0], start[1] + flat * way[1]
            if 0.0 <= flat < distance and x * x + y * y <= size[0] * size[0]:
                distance = flat
    return distance


@part
def _capsule(size: Vector, start: Vector, way: Vector) -> float:
    across, towards, outside = _flat(size, start, way)
    if towards * towards - across * outside < -_CLEAR:  # far from the endless cylinder that contains the capsule
        return math.inf
    distance = _side(size, start, way)
    for end in (-1.0, 1.0):
        centre = (start[0], start[1], start[2] - end * size[1])
        for cap in _roots(dot(way, way), dot(way, centre), dot(centre, centre) - size[0] * size[0]):
            if 0.0 <= cap < distance and end * (start[2] + cap * way[2]) >= size[1]:
                distance = cap
    return distance
