"""Thickens flat meshes of colliders, for which MuJoCo cannot compute a convex hull, to plates."""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np

from graphengine.descriptions.engine import REFUSALS, Floats, compiled, mujoco
from graphengine.descriptions.files import meshes

THICKNESS = 0.001
"""Thickness of the plate that replaces a flat mesh, m."""
_FARTHEST = 1e12
"""Largest coordinate of a vertex in an examined mesh, m; MuJoCo reports larger coordinates as mistakes."""
_FLAT = 1e-6
"""Largest ratio of the standard deviation of a flat mesh's vertices across its plane to the deviation along its plane."""


def is_flat(data: bytes, suffix: str) -> bool:
    """Return whether all vertices of an STL, OBJ or MSH file lie in a plane, and MuJoCo therefore refuses it as a collider."""
    vertices = _vertices(data, suffix)
    if vertices is None:
        return False
    least, _, most = _deviations(vertices)[0]
    return bool(least <= _FLAT * most) and compiled_shell(f"mesh{suffix}", data) is None


def compiled_shell(name: str, data: bytes) -> mujoco.MjModel | None:
    """Return a model that contains only a mesh, as a shell without volume; None if MuJoCo refuses the mesh.

    Args:
        name: name of the mesh file; its suffix determines the format.
        data: content of the file.
    """
    spec = mujoco.MjSpec()
    spec.assets = {name: data}
    spec.add_mesh(name="mesh", file=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
    try:
        return compiled(spec)[0]
    except REFUSALS:
        return None


def thickened(data: bytes, scale: Sequence[float]) -> bytes | None:
    """Return a plate with both sides of a flat mesh, as MSH; None if all vertices lie on one line.

    Args:
        data: flat mesh in MuJoCo's MSH format.
        scale: scale factors along x, y and z, by which MuJoCo will multiply the plate; its thickness takes account of them.
    """
    vertices = _vertices(data, ".msh")
    if vertices is None or len(scale) != 3 or not all(scale):
        return None
    scaled = vertices * scale
    deviations, axes = _deviations(scaled)
    if deviations[1] <= _FLAT * deviations[2]:
        return None
    offset = axes[:, 0] * (THICKNESS / 2)
    number, normals, coordinates, triangles = struct.unpack_from("<4i", data)
    faces = np.frombuffer(data, "<i4", 3 * triangles, 16 + 12 * (number + normals) + 8 * coordinates).reshape(-1, 3)
    both = np.concatenate([scaled + offset, scaled - offset]) / scale
    return meshes.msh(meshes.Part(both, np.concatenate([faces, faces[:, ::-1] + number]).astype(np.int64)))


def _vertices(data: bytes, suffix: str) -> Floats | None:
    """Return the vertices of a mesh file, shape (number of vertices, 3); None if it has none, or they cannot be read."""
    try:
        if suffix == ".stl":
            vertices = meshes.stl_corners(data).astype(float)
        elif suffix == ".msh":
            number = struct.unpack_from("<i", data)[0]
            vertices = np.frombuffer(data, "<f4", 3 * number, 16).reshape(-1, 3).astype(float)
        else:
            lines = (line.split() for line in data.splitlines() if line[:2] in (b"v ", b"v\t"))
            vertices = np.array([words[1:4] for words in lines], float).reshape(-1, 3)
    except (ValueError, struct.error):  # MuJoCo reports what is wrong with the file
        return None
    return vertices if len(vertices) and np.abs(vertices).max() < _FARTHEST else None


def _deviations(vertices: Floats) -> tuple[Floats, Floats]:
    """Return the standard deviations of points along their principal axes, in ascending order, and the axes as columns."""
    centred = vertices - vertices.mean(axis=0)
    variances, axes = np.linalg.eigh(centred.T @ centred / len(vertices))
    return np.sqrt(np.maximum(variances, 0.0)), axes
