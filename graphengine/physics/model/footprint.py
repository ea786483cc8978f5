"""Computes the footprint of a robot: the convex hull of its colliders, seen from above."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from graphengine.descriptions.engine import Floats, body_names, collides, mujoco
from graphengine.descriptions.geoms import mesh_vertices

DIRECTIONS = 32
"""Number of horizontal directions in which round shapes are sampled."""
TOLERANCE = 0.004
"""Default maximum distance of a corner that `simplified` removes from the line between its neighbours, m."""

_ROUND = 0.99
"""Least ratio of inscribed to circumscribed radius of a circle; that of a polygon with `DIRECTIONS` corners is 0.995."""
_GEOM = mujoco.mjtGeom
Point = tuple[float, float]


def collider_points(model: mujoco.MjModel, data: mujoco.MjData, robot: str) -> Floats:
    """Return points with the same convex hull as a robot's colliders, in the world frame, shape (number of points, 3), m.

    Round shapes are sampled: their outline is too small by up to 0.5 % of the radius.

    Args:
        model: model of the scene.
        data: state with the poses of the bodies.
        robot: name of the robot, which is the prefix of its body names.
    """
    own = [name.startswith(f"{robot}/") for name in body_names(model)]
    geoms = np.flatnonzero(collides(model) & np.array(own)[model.geom_bodyid])
    found = [points for geom in geoms.tolist() for points in _points(model, data, geom)]
    return np.concatenate(found) if found else np.empty((0, 3))


def _points(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Iterator[Floats]:
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]  # a numpy integer is in no tuple of enum members
    centre, rotation = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
    if kind == _GEOM.mjGEOM_PLANE:
        return
    if kind == _GEOM.mjGEOM_MESH:
        local = mesh_vertices(model, int(model.geom_dataid[geom]))
    elif kind in (_GEOM.mjGEOM_SPHERE, _GEOM.mjGEOM_CAPSULE, _GEOM.mjGEOM_CYLINDER, _GEOM.mjGEOM_ELLIPSOID):
        local = _extremes(kind, size, _directions() @ rotation)
    else:
        middle, half = (np.zeros(3), size) if kind == _GEOM.mjGEOM_BOX else model.geom_aabb[geom].reshape(2, 3)
        local = middle + half * np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    yield centre + local @ rotation.T


def _directions() -> Floats:
    """Return unit vectors in `DIRECTIONS` horizontal directions, down and up, shape (DIRECTIONS + 2, 3)."""
    angles = np.arange(DIRECTIONS) * (math.tau / DIRECTIONS)
    around = np.stack([np.cos(angles), np.sin(angles), np.zeros(DIRECTIONS)], axis=-1)
    return np.concatenate([around, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])


def _extremes(kind: int, size: Floats, directions: Floats) -> Floats:
    """Return the point of a round shape that is farthest in each direction, in the shape's frame."""
    if kind == _GEOM.mjGEOM_ELLIPSOID:
        extremes: Floats = _unit(directions * size) * size
    elif kind == _GEOM.mjGEOM_CYLINDER:
        extremes = _unit(directions * (1.0, 1.0, 0.0)) * size[0] + _ends(directions, size[1])
    else:
        extremes = directions * size[0] + (_ends(directions, size[1]) if kind == _GEOM.mjGEOM_CAPSULE else 0.0)
    return extremes


def _unit(vectors: Floats) -> Floats:
    """Return vectors scaled to length 1; zero vectors stay zero."""
    scaled: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
    return scaled


def _ends(directions: Floats, half: float) -> Floats:
    """Return the end of a shape's axis (along z) that is farther in each direction; `half` is half the length of the axis, m."""
    ends: Floats = np.sign(directions) * (0.0, 0.0, half)
    return ends


def convex_hull(points: Floats) -> list[Point]:
    """Return the corners of the convex hull of points in a plane, counterclockwise; `points` has shape (number of points, 2)."""
    ordered = sorted(set(map(tuple, np.round(points, 6).tolist())))
    if len(ordered) < 3:
        return ordered
    lower, upper = _half_hull(ordered), _half_hull(ordered[::-1])
    return lower[:-1] + upper[:-1]


def _half_hull(ordered: Sequence[Point]) -> list[Point]:
    """Return the corners of the hull on the right of the line from the first to the last point, including both points."""
    chain: list[Point] = []
    for point in ordered:
        while len(chain) > 1 and _turn(chain[-2], chain[-1], point) <= 0.0:
            chain.pop()
        chain.append(point)
    return chain


def _turn(a: Point, b: Point, c: Point) -> float:
    """Return twice the signed area of a triangle, m2; positive if its corners are counterclockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def simplified(corners: Sequence[Point], tolerance: float = TOLERANCE) -> list[Point]:
    """Return a convex outline without corners that are less than `tolerance` (m) from the line between their neighbours.

    At least 3 corners remain.
    """
    kept = list(corners)
    while len(kept) > 3:
        heights = [_height(kept[i - 1], kept[i], kept[(i + 1) % len(kept)]) for i in range(len(kept))]
        least = min(range(len(kept)), key=heights.__getitem__)
        if heights[least] >= tolerance:
            break
        del kept[least]
    return kept


def _height(before: Point, corner: Point, after: Point) -> float:
    """Return the distance of a corner from the line between its neighbours, m."""
    return abs(_turn(before, corner, after)) / max(math.dist(before, after), 1e-12)


def circle_radius(corners: Sequence[Point]) -> float | None:
    """Return the radius of an outline that is a circle about the origin, m; None for any other outline."""
    inscribed, circumscribed = radii(corners)
    return circumscribed if inscribed >= _ROUND * circumscribed else None


def radii(corners: Sequence[Point]) -> tuple[float, float]:
    """Return inscribed and circumscribed radius of a convex outline, for circles about the origin, m.

    The inscribed radius is 0 if the origin is outside of the outline.
    """
    edges = list(zip(corners, [*corners[1:], corners[0]], strict=True))
    inscribed = min(_turn(a, b, (0.0, 0.0)) / max(math.dist(a, b), 1e-12) for a, b in edges)
    return max(inscribed, 0.0), max(math.hypot(*corner) for corner in corners)
