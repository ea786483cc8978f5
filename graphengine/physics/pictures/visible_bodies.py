"""Converts the visible geoms of a model to shapes of its bodies, for viewers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.geoms import geom_colours, height_field_triangles, mesh_faces, mesh_vertices
from graphengine.devices.rotation import vector
from graphengine.devices.visible import Bodies, ShapeKind, Surface, VisibleShape
from graphengine.physics.pictures import textures
from graphengine.physics.pictures.frame_capture import SEEN

_GEOM = mujoco.mjtGeom
_KINDS: Mapping[int, ShapeKind] = {
    _GEOM.mjGEOM_PLANE.value: "plane",
    _GEOM.mjGEOM_SPHERE.value: "sphere",
    _GEOM.mjGEOM_CAPSULE.value: "capsule",
    _GEOM.mjGEOM_ELLIPSOID.value: "ellipsoid",
    _GEOM.mjGEOM_CYLINDER.value: "cylinder",
    _GEOM.mjGEOM_BOX.value: "box",
    _GEOM.mjGEOM_MESH.value: "mesh",
    _GEOM.mjGEOM_HFIELD.value: "mesh",
}
"""Kind of shape by MuJoCo geom type; geoms of other types are not shown."""


def visible_bodies(model: mujoco.MjModel) -> Bodies:
    """Return all bodies of a model with their visible shapes, meshes and textures."""
    shapes: list[VisibleShape] = []
    meshes: dict[str, int] = {}
    surfaces: dict[str, Surface] = {}
    painted: dict[str, int] = {}
    colours = geom_colours(model)
    for geom in range(model.ngeom):
        kind = _KINDS.get(int(model.geom_type[geom]))
        if kind is None or not SEEN[model.geom_group[geom]] or colours[geom, 3] == 0.0:
            continue
        shape = _shape(model, geom, kind, colours[geom])
        shapes.append(shape)
        if shape.mesh and _is_height_field(model, geom):
            surfaces[shape.mesh] = _terrain(model, int(model.geom_dataid[geom]))
        elif shape.mesh:
            meshes[shape.mesh] = int(model.geom_dataid[geom])
        if shape.texture:
            painted[shape.texture] = textures.texture_of(model, geom)
    corners = {name: textures.corner_coordinates(model, mesh) for name, mesh in meshes.items() if painted}
    return Bodies(
        [model.body(body).name for body in range(model.nbody)],
        ((model.body_weldid != 0) | (model.body_mocapid >= 0)).tolist(),
        shapes,
        surfaces | {name: _surface(model, mesh) for name, mesh in meshes.items()},
        {name: textures.pixels(model, texture) for name, texture in painted.items()},
        {name: found for name, found in corners.items() if found is not None},
    )


def _surface(model: mujoco.MjModel, mesh: int) -> Surface:
    return mesh_vertices(model, mesh).astype(np.float32), np.asarray(mesh_faces(model, mesh), np.int32)


def _is_height_field(model: mujoco.MjModel, geom: int) -> bool:
    return bool(model.geom_type[geom] == _GEOM.mjGEOM_HFIELD)


def _terrain(model: mujoco.MjModel, field: int) -> Surface:
    corners = height_field_triangles(model, field).reshape(-1, 3)
    return corners.astype(np.float32), np.arange(len(corners), dtype=np.int32).reshape(-1, 3)


def _surface_name(model: mujoco.MjModel, geom: int) -> str:
    data = int(model.geom_dataid[geom])
    return f"height field {data}" if _is_height_field(model, geom) else model.mesh(data).name


def _shape(model: mujoco.MjModel, geom: int, kind: ShapeKind, colour: NDArray[np.float32]) -> VisibleShape:
    texture = textures.texture_of(model, geom)
    flat = texture >= 0 and textures.is_flat(model, texture) and not _is_height_field(model, geom)
    if texture >= 0 and not flat:
        colour = colour.copy()
        colour[:3] *= textures.pixels(model, texture)[..., :3].mean(axis=(0, 1)) / 255
    red, green, blue, opacity = colour.tolist()
    w, x, y, z = model.geom_quat[geom].tolist()
    return VisibleShape(
        kind,
        vector(model.geom_size[geom]),
        int(model.geom_bodyid[geom]),
        (vector(model.geom_pos[geom]), (x, y, z, w)),
        (red, green, blue, opacity),
        _surface_name(model, geom) if kind == "mesh" else "",
        f"texture {texture}" if flat else "",
        textures.repeats(model, geom) if flat else (0.0, 0.0),
    )
