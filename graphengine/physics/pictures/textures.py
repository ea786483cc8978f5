"""Reads two-dimensional textures of a model, and their mapping to geoms.

Cube textures are not supported: a geom with a cube texture gets the texture's mean colour.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco

_ROLES = (mujoco.mjtTextureRole.mjTEXROLE_RGB.value, mujoco.mjtTextureRole.mjTEXROLE_RGBA.value)
_MESH, _FLAT = mujoco.mjtGeom.mjGEOM_MESH.value, mujoco.mjtTexture.mjTEXTURE_2D.value
_ROUND = tuple(
    kind.value for kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE)
)
"""Geom types with the same width along x and y; the second number of their MuJoCo size is not a width along y."""


def texture_of(model: mujoco.MjModel, geom: int) -> int:
    """Return the id of the colour texture of a geom's material; -1 if there is no texture."""
    material = int(model.geom_matid[geom])
    found = [int(model.mat_texid[material, role]) for role in _ROLES] if material >= 0 else []
    return max(found, default=-1)


def is_flat(model: mujoco.MjModel, texture: int) -> bool:
    """Return whether a texture is two-dimensional."""
    return bool(model.tex_type[texture] == _FLAT)


def pixels(model: mujoco.MjModel, texture: int) -> NDArray[np.uint8]:
    """Return a texture as a view of the model's data, shape (height, width, channels), the top row first."""
    shape = int(model.tex_height[texture]), int(model.tex_width[texture]), int(model.tex_nchannel[texture])
    start = int(model.tex_adr[texture])
    found: NDArray[np.uint8] = model.tex_data[start : start + shape[0] * shape[1] * shape[2]].reshape(shape)
    return found


def repeats(model: mujoco.MjModel, geom: int) -> tuple[float, float]:
    """Return how often a texture repeats per metre along the geom's x and y axes; zeros for meshes with texture coordinates."""
    if model.geom_type[geom] == _MESH and model.mesh_texcoordadr[model.geom_dataid[geom]] >= 0:
        return 0.0, 0.0
    material = int(model.geom_matid[geom])
    x, y = model.mat_texrepeat[material].tolist()
    if model.mat_texuniform[material]:
        return x / 2, y / 2  # MuJoCo repeats a uniform texture over two metres
    half_x, half_y, _ = model.geom_size[geom].tolist()
    if model.geom_type[geom] in _ROUND:
        half_y = half_x
    return x / (2 * (half_x or 1.0)), y / (2 * (half_y or 1.0))


def corner_coordinates(model: mujoco.MjModel, mesh: int) -> NDArray[np.float32] | None:
    """Return the texture coordinates of a mesh's triangle corners, shape (triangles, 3, 2); None if the mesh has none.

    The origin of texture coordinates is the upper left corner of the texture.
    """
    if model.mesh_texcoordadr[mesh] < 0:
        return None
    first, face, count = model.mesh_texcoordadr[mesh], model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    corners: NDArray[np.float32] = model.mesh_texcoord[first + model.mesh_facetexcoord[face : face + count]]
    return corners.astype(np.float32)
