"""Reads shapes from a compiled model: colours, meshes, height fields, and the extents of geoms along the axes of a frame."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Floats, Indices, mujoco

_GEOM = mujoco.mjtGeom
_ORIGIN, _AXES = np.zeros(3), np.eye(3)


def geom_colours(model: mujoco.MjModel) -> NDArray[np.float32]:
    """Return red, green, blue and opacity (0 to 1) of each geom, from its material if it has one."""
    of_materials = model.mat_rgba[model.geom_matid] if model.nmat else model.geom_rgba
    colours: NDArray[np.float32] = np.where((model.geom_matid < 0)[:, None], model.geom_rgba, of_materials)
    return colours


def mesh_vertices(model: mujoco.MjModel, mesh: int) -> Floats:
    """Return the vertices of a mesh in the mesh's frame, shape (number of vertices, 3), m."""
    start = model.mesh_vertadr[mesh]
    vertices: Floats = model.mesh_vert[start : start + model.mesh_vertnum[mesh]].astype(float)
    return vertices


def mesh_faces(model: mujoco.MjModel, mesh: int) -> Indices:
    """Return the triangles of a mesh as indices of its vertices, shape (number of triangles, 3)."""
    start = model.mesh_faceadr[mesh]
    faces: Indices = model.mesh_face[start : start + model.mesh_facenum[mesh]]
    return faces


def height_field_points(model: mujoco.MjModel, field: int) -> Floats:
    """Return the points of a height field, shape (rows, columns, 3), m; rows are along y."""
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    half_x, half_y, height, _ = model.hfield_size[field].tolist()
    start = model.hfield_adr[field]
    heights = height * model.hfield_data[start : start + rows * columns].astype(float).reshape(rows, columns)
    x, y = np.meshgrid(np.linspace(-half_x, half_x, columns), np.linspace(-half_y, half_y, rows))
    return np.stack([x, y, heights], axis=-1)


def height_field_triangles(model: mujoco.MjModel, field: int) -> Floats:
    """Return a height field as the triangles of MuJoCo's ray casting (`mj_rayHfield`), shape (number of triangles, 3, 3), m.

    They form the terrain, the walls from height zero up to the terrain's four edges, and the box below height zero.
    """
    ground = height_field_points(model, field)
    rows, columns, _ = ground.shape
    edges = (ground[0], ground[-1], ground[:, 0], ground[:, -1])
    walls = [np.stack([edge * (1, 1, 0), edge]) for edge in edges]
    flat = ground[:: rows - 1, :: columns - 1] * (1, 1, 0)  # the four corners
    below = flat - (0, 0, model.hfield_size[field, 3])
    sides = [np.stack([below[line], flat[line]]) for line in (np.s_[0], np.s_[1], np.s_[:, 0], np.s_[:, 1])]
    return np.concatenate([_sheet_triangles(sheet) for sheet in (ground, *walls, flat, below, *sides)])


def triangles_of(model: mujoco.MjModel, geom: int) -> Floats | None:
    """Return the triangles of a mesh or height field in the geom's frame, shape (n, 3, 3), m; None for other geoms."""
    kind, number = model.geom_type[geom], int(model.geom_dataid[geom])
    if kind == _GEOM.mjGEOM_MESH:
        corners: Floats = mesh_vertices(model, number)[mesh_faces(model, number)]
        return corners
    return height_field_triangles(model, number) if kind == _GEOM.mjGEOM_HFIELD else None


def _sheet_triangles(points: Floats) -> Floats:
    """Return two triangles for each cell of a grid of points; the diagonal from the cell's first corner divides the cell."""
    here, right = points[:-1, :-1], points[:-1, 1:]
    above, opposite = points[1:, :-1], points[1:, 1:]
    pairs = [np.stack([here, right, opposite], axis=-2), np.stack([here, opposite, above], axis=-2)]
    return np.concatenate([pair.reshape(-1, 3, 3) for pair in pairs])


def extents(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int], origin: Floats = _ORIGIN, axes: Floats = _AXES
) -> tuple[Floats, Floats] | None:
    """Return the smallest and the largest coordinates of geoms along the axes of a frame, m; None without a finite geom.

    The result is exact for all shapes except height fields and signed distance fields.

    Args:
        model: model with the geoms.
        data: state with the poses of the geoms.
        geoms: ids of the geoms.
        origin: origin of the frame in the world, m.
        axes: rotation matrix from the frame to the world, shape (3, 3).
    """
    poses = {geom: (data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)) for geom in map(int, geoms)}
    there = {geom: ((position - origin) @ axes, axes.T @ turn) for geom, (position, turn) in poses.items()}
    found = [reach for geom, pose in there.items() if (reach := _reach(model, geom, *pose)) is not None]
    if not found:
        return None
    lows, highs = zip(*found, strict=True)
    return np.min(lows, axis=0), np.max(highs, axis=0)


def _reach(model: mujoco.MjModel, geom: int, centre: Floats, rotation: Floats) -> tuple[Floats, Floats] | None:
    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == _GEOM.mjGEOM_MESH:
        points = mesh_vertices(model, int(model.geom_dataid[geom])) @ rotation.T
        return centre + points.min(axis=0), centre + points.max(axis=0)
    along = np.abs(rotation)
    if kind == _GEOM.mjGEOM_PLANE:
        if not size[:2].all():  # zero stands for endless
            return None
        half = along[:, :2] @ size[:2]
    elif kind == _GEOM.mjGEOM_SPHERE:
        half = np.repeat(size[0], 3)
    elif kind == _GEOM.mjGEOM_CAPSULE:
        half = along[:, 2] * size[1] + size[0]
    elif kind == _GEOM.mjGEOM_CYLINDER:
        half = along[:, 2] * size[1] + np.sqrt(np.maximum(1.0 - along[:, 2] ** 2, 0.0)) * size[0]
    elif kind == _GEOM.mjGEOM_ELLIPSOID:
        half = np.sqrt((rotation**2) @ size**2)
    elif kind == _GEOM.mjGEOM_BOX:
        half = along @ size
    else:
        middle, own = model.geom_aabb[geom].reshape(2, 3)
        centre, half = centre + rotation @ middle, along @ own
    return centre - half, centre + half
