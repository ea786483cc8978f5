"""Meshes and height fields of a compiled model, in the frames of their geoms."""

from __future__ import annotations

import numpy as np

from graphengine.physics.engine import Floats, Indices, mujoco


def mesh_vertices(model: mujoco.MjModel, mesh: int) -> Floats:
    """The vertices of a mesh, shape (n, 3), m."""
    start = model.mesh_vertadr[mesh]
    vertices: Floats = model.mesh_vert[start : start + model.mesh_vertnum[mesh]].astype(float)
    return vertices


def mesh_faces(model: mujoco.MjModel, mesh: int) -> Indices:
    """The triangles of a mesh as indices of its vertices, shape (n, 3)."""
    start = model.mesh_faceadr[mesh]
    faces: Indices = model.mesh_face[start : start + model.mesh_facenum[mesh]]
    return faces


def height_field_points(model: mujoco.MjModel, field: int) -> Floats:
    """The points of a height field, shape (rows, columns, 3), m; rows go along y."""
    rows, columns = int(model.hfield_nrow[field]), int(model.hfield_ncol[field])
    half_x, half_y, height, _ = model.hfield_size[field].tolist()
    start = model.hfield_adr[field]
    heights = height * model.hfield_data[start : start + rows * columns].astype(float).reshape(rows, columns)
    x, y = np.meshgrid(np.linspace(-half_x, half_x, columns), np.linspace(-half_y, half_y, rows))
    return np.stack([x, y, heights], axis=-1)
