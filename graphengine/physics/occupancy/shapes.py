"""Converts MuJoCo's geoms to shapes that occupy cells.

An obstacle is any geom that a robot can collide with or that its lidar can hit. Contacts use the convex hull of a mesh, and rays
use its triangles. So a mesh that collides becomes both, and a mesh that only rays hit becomes its triangles. Contacts use the
half space behind a plane, whatever its size. So a plane that collides, or is infinite, becomes a half space; any other plane
becomes a rectangle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Protocol

import numpy as np

from graphengine.descriptions.engine import Floats, Indices, collides, mujoco
from graphengine.descriptions.geoms import height_field_points, mesh_faces, mesh_vertices
from graphengine.physics.occupancy.grid import MARGIN, Canvas, Window
from graphengine.physics.occupancy.polyhedra import Triangles
from graphengine.physics.occupancy.quadrics import Cylinders, Ellipsoids

_CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
_CUBE_FACES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
_CUBE_TRIANGLES = np.concatenate([_CUBE_FACES[:, [0, 1, 2]], _CUBE_FACES[:, [0, 2, 3]]])
_PRISM_TRIANGLES = np.array(
    [[0, 1, 2], [3, 4, 5], [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]]
)  # of corners 0 to 2 and what lies below them, 3 to 5


class Shape(Protocol):
    """Several bodies with one kind of shape."""

    def bounds(self) -> tuple[Floats, Floats]:
        """Return smallest x and y, and largest x and y, m; inf and -inf if the bodies are infinite."""

    def draw(self, canvas: Canvas, window: Window) -> None:
        """Occupy the cells that the bodies intersect within the height range."""


@dataclass(frozen=True, slots=True)
class HalfSpace:
    """The half space behind a plane: the points p with `normal` p <= `offset`."""

    normal: Floats
    offset: float

    def bounds(self) -> tuple[Floats, Floats]:
        """Return inf as smallest and -inf as largest x and y, because infinite shapes do not enlarge a map."""
        return np.full(2, np.inf), np.full(2, -np.inf)

    def draw(self, canvas: Canvas, window: Window) -> None:
        """Occupy the cells that the half space intersects within the height range."""
        rows = np.arange(canvas.grid.rows)
        south, north = canvas.grid.bands(rows)
        nx, ny, nz = self.normal.tolist()
        height = min(nz * (window[0] + MARGIN), nz * (window[1] - MARGIN))
        rest = self.offset - height - np.minimum(ny * south, ny * north)  # nx x <= rest
        everywhere = np.full(len(rows), np.inf)
        if abs(nx) > 1e-12:
            border = rest / nx
            low, high = (-everywhere, border) if nx > 0 else (border, everywhere)
        else:
            low, high = np.where(rest >= 0, -np.inf, np.inf), everywhere
        canvas.fill(rows, low, high)


def shapes(model: mujoco.MjModel, data: mujoco.MjData, geoms: Indices) -> Iterator[Shape]:
    """Yield the shapes of the given geoms in the world frame.

    Args:
        model: compiled model.
        data: state in which the poses of geoms are up to date.
        geoms: ids of the geoms.
    """
    kinds, kind = mujoco.mjtGeom, model.geom_type[geoms]
    solid = collides(model)
    yield from _boxes(model, data, geoms[kind == kinds.mjGEOM_BOX])
    yield from _round(model, data, geoms)
    for geom in geoms[kind == kinds.mjGEOM_PLANE].tolist():
        yield _plane(model, data, geom, solid[geom])
    for geom in geoms[kind == kinds.mjGEOM_MESH].tolist():
        yield from _mesh(model, data, geom, solid[geom])
    for geom in geoms[kind == kinds.mjGEOM_SDF].tolist():
        yield from _mesh(model, data, geom, False)  # contacts see its surface, of which the mesh is a likeness
    for geom in geoms[kind == kinds.mjGEOM_HFIELD].tolist():
        yield from _field(model, data, geom)


def _placed(data: mujoco.MjData, geom: int, points: Floats) -> Floats:
    """Transform points from a geom's frame to the world frame."""
    world: Floats = points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return world


def _plane(model: mujoco.MjModel, data: mujoco.MjData, geom: int, solid: bool) -> Shape:
    x, y, _ = model.geom_size[geom].tolist()  # half the sides, 0 without end
    if solid or x * y == 0:
        normal = data.geom_xmat[geom].reshape(3, 3)[:, 2]
        return HalfSpace(normal, float(normal @ data.geom_xpos[geom]))
    corners = _placed(data, geom, np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]))
    return Triangles.skin(corners[[[0, 1, 2], [0, 2, 3]]])


def _mesh(model: mujoco.MjModel, data: mujoco.MjData, geom: int, solid: bool) -> Iterator[Shape]:
    mesh = int(model.geom_dataid[geom])
    vertices = mesh_vertices(model, mesh)
    corners, margin = _placed(data, geom, vertices), _margin(vertices)
    yield Triangles.skin(corners[mesh_faces(model, mesh)], margin)
    if solid and model.mesh_graphadr[mesh] >= 0:
        hull = corners[_hull(model, mesh)]
        yield Triangles(hull, np.zeros(len(hull), np.intp), margin)


def _field(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Iterator[Shape]:
    for prisms in _strips(model, int(model.geom_dataid[geom])):
        corners = _placed(data, geom, prisms)[:, _PRISM_TRIANGLES]
        owner = np.repeat(np.arange(len(corners)), len(_PRISM_TRIANGLES))
        yield Triangles(corners.reshape(-1, 3, 3), owner, _margin(prisms))


def _margin(points: Floats) -> float:
    """Return the margin (m) for coordinates in a geom's frame that MuJoCo stores in single precision."""
    return MARGIN + float(np.finfo(np.float32).eps * np.abs(points).max(initial=0.0))


def _boxes(model: mujoco.MjModel, data: mujoco.MjData, geoms: Indices) -> Iterator[Shape]:
    if not len(geoms):
        return
    rotations = data.geom_xmat[geoms].reshape(-1, 3, 3)
    corners = (_CUBE * model.geom_size[geoms, None]) @ rotations.transpose(0, 2, 1) + data.geom_xpos[geoms, None]
    triangles = corners[:, _CUBE_TRIANGLES].reshape(-1, 3, 3)
    yield Triangles(triangles, np.repeat(np.arange(len(geoms)), len(_CUBE_TRIANGLES)))


def _round(model: mujoco.MjModel, data: mujoco.MjData, geoms: Indices) -> Iterator[Shape]:
    """Yield the shapes of spheres, ellipsoids, cylinders and capsules; a capsule becomes a cylinder and two spheres."""
    kinds, kind = mujoco.mjtGeom, model.geom_type[geoms]
    rotations = data.geom_xmat.reshape(-1, 3, 3)

    spheres = geoms[kind == kinds.mjGEOM_SPHERE]
    ellipsoids = geoms[kind == kinds.mjGEOM_ELLIPSOID]
    capsules = geoms[kind == kinds.mjGEOM_CAPSULE]
    ends = model.geom_size[capsules, 1, None] * rotations[capsules, :, 2]
    balls = np.concatenate([spheres, capsules, capsules])
    centres = [data.geom_xpos[g] for g in (spheres, capsules, capsules, ellipsoids)]
    centres[1], centres[2] = centres[1] - ends, centres[2] + ends
    axes = [
        model.geom_size[balls, 0, None, None] * np.eye(3),
        rotations[ellipsoids] * model.geom_size[ellipsoids, None],
    ]
    if len(balls) or len(ellipsoids):
        yield Ellipsoids(np.concatenate(centres), np.concatenate(axes))

    long = geoms[np.isin(kind, (kinds.mjGEOM_CYLINDER, kinds.mjGEOM_CAPSULE))]
    if len(long):
        yield Cylinders(data.geom_xpos[long], rotations[long, :, 2], *model.geom_size[long, :2].T)


def _hull(model: mujoco.MjModel, mesh: int) -> Indices:
    """Return the vertex ids of the triangles of a mesh's convex hull, shape (n, 3).

    They are the last part of the mesh's graph; see `mesh_graph` in MuJoCo's documentation.
    """
    graph = model.mesh_graph[model.mesh_graphadr[mesh] :]
    vertices, faces = graph[:2].tolist()
    start = 2 + 3 * vertices + 3 * faces
    triangles: Indices = graph[start : start + 3 * faces].reshape(-1, 3)
    return triangles


def _strips(model: mujoco.MjModel, field: int) -> Iterator[Floats]:
    """Yield the prisms that contacts use for a height field, two for each cell, one row of cells at a time.

    The corners of the prisms of a row have the shape (n, 6, 3), in the geom's frame.
    """
    base = float(model.hfield_size[field, 3])
    for south, north in pairwise(height_field_points(model, field)):
        one = np.stack([south[:-1], south[1:], north[1:]], axis=1)
        other = np.stack([south[:-1], north[1:], north[:-1]], axis=1)
        top = np.concatenate([one, other])
        yield np.concatenate([top, top * (1, 1, 0) - (0, 0, base)], axis=1)
