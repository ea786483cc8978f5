"""The visible geoms of a model as shapes of its bodies."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from graphengine.devices.rotation import vector
from graphengine.devices.visible import Bodies, ShapeKind, Surface, VisibleShape
from graphengine.physics.engine import mujoco
from graphengine.physics.model.geoms import mesh_faces, mesh_vertices
from graphengine.physics.pictures.frame_capture import SEEN
from graphengine.physics.sensors.rays import geom_colours

_GEOM = mujoco.mjtGeom
_KINDS: Mapping[int, ShapeKind] = {
    _GEOM.mjGEOM_PLANE.value: "plane",
    _GEOM.mjGEOM_SPHERE.value: "sphere",
    _GEOM.mjGEOM_CAPSULE.value: "capsule",
    _GEOM.mjGEOM_ELLIPSOID.value: "ellipsoid",
    _GEOM.mjGEOM_CYLINDER.value: "cylinder",
    _GEOM.mjGEOM_BOX.value: "box",
    _GEOM.mjGEOM_MESH.value: "mesh",
}
"""Shapes by geom type; height fields are not among them."""


def visible_bodies(model: mujoco.MjModel) -> Bodies:
    """All bodies of a model, and the shapes that pictures show."""
    shapes: list[VisibleShape] = []
    surfaces: dict[str, Surface] = {}
    colours = geom_colours(model).tolist()
    for geom in range(model.ngeom):
        kind = _KINDS.get(int(model.geom_type[geom]))
        red, green, blue, opacity = colours[geom]
        if kind is None or not SEEN[model.geom_group[geom]] or opacity == 0.0:
            continue
        name = ""
        if kind == "mesh":
            mesh = int(model.geom_dataid[geom])
            name = model.mesh(mesh).name
            if name not in surfaces:
                surfaces[name] = (
                    mesh_vertices(model, mesh).astype(np.float32),
                    np.asarray(mesh_faces(model, mesh), np.int32),
                )
        w, x, y, z = model.geom_quat[geom].tolist()
        pose = (vector(model.geom_pos[geom]), (x, y, z, w))
        shapes.append(
            VisibleShape(
                kind,
                vector(model.geom_size[geom]),
                int(model.geom_bodyid[geom]),
                pose,
                (red, green, blue, opacity),
                name,
            )
        )
    moving = ((model.body_weldid != 0) | (model.body_mocapid >= 0)).tolist()
    return Bodies([model.body(body).name for body in range(model.nbody)], moving, shapes, surfaces)
