"""Completes masses and inertias of bodies from their shapes, as the specification of UsdPhysics says.

A mass of a body outranks masses and densities of its shapes. A shape's own density outranks that of the body, and both outrank
that of a material. Without any, the density is that of water. MuJoCo computes volumes and inertias; those of meshes are of hulls.
"""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.descriptions.engine import REFUSALS, compiled, mujoco
from graphengine.descriptions.inertia import WATER
from graphengine.descriptions.robot_description import Inertial
from graphengine.descriptions.usd_model import StageBody, StageShape
from graphengine.devices.rotation import Pose, compose, pose_of, relative

_TYPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
}


def inertial_of(body: StageBody, frame: Pose, meshes: Sequence[bytes]) -> Inertial | None:
    """Return mass, centre and inertia of a body in the frame of its link; None for a body without mass and colliders.

    Args:
        body: body of the stage.
        frame: pose of the link's frame in the frame of the body.
        meshes: meshes of the stage, in MSH.
    """
    whole = _of_shapes(body, meshes) if not (body.mass and body.moments and body.centre is not None) else None
    mass = body.mass or (whole.mass if whole is not None else 0.0)
    if not mass:
        return None
    (centre, axes), moments = whole.pose if whole is not None else ((0.0, 0.0, 0.0), body.axes), body.moments
    if moments is not None:
        axes = body.axes
    elif whole is not None and whole.moments is not None:
        xx, yy, zz = (each * mass / whole.mass for each in whole.moments[:3])
        moments = xx, yy, zz
    pose = compose(relative(frame, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))), (body.centre or centre, axes))
    return Inertial(mass, (*moments, 0.0, 0.0, 0.0) if moments is not None else None, pose)


def _of_shapes(body: StageBody, meshes: Sequence[bytes]) -> Inertial | None:
    """Return the mass and inertia that the colliders of a body give it; None if they have no volume."""
    spec = mujoco.MjSpec()
    made = spec.worldbody.add_body(name="body")
    made.add_freejoint()
    for shape in body.shapes:
        if shape.solid and shape.kind != "plane" and 0.0 not in shape.sizes:
            _add(spec, made, shape, body, meshes)
    if not list(made.geoms):
        return None
    try:
        model = compiled(spec)[0]
    except REFUSALS:  # a flat mesh; the model of the whole robot reports it
        return None
    xx, yy, zz = model.body_inertia[1].tolist()
    return Inertial(
        float(model.body_mass[1]), (xx, yy, zz, 0.0, 0.0, 0.0), pose_of(model.body_ipos[1], model.body_iquat[1])
    )


def _add(
    spec: mujoco.MjSpec, made: mujoco.MjsBody, shape: StageShape, body: StageBody, meshes: Sequence[bytes]
) -> None:
    position, (x, y, z, w) = relative(body.pose, shape.pose)
    geom = made.add_geom(pos=position, quat=(w, x, y, z))
    geom.density = (shape.density if shape.outranks else body.density or shape.density) or WATER
    if shape.mass:
        geom.mass = shape.mass
    if shape.kind == "mesh":
        name = f"{shape.mesh}.msh"
        if not any(mesh.file == name for mesh in spec.meshes):
            spec.assets = {**spec.assets, name: meshes[shape.mesh]}
            spec.add_mesh(name=name, file=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
        geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, name
    else:
        sizes = (
            [each / 2 for each in shape.sizes]
            if shape.kind == "box"
            else [shape.sizes[0], *(s / 2 for s in shape.sizes[1:])]
        )
        geom.type = _TYPES[shape.kind]
        geom.size[: len(sizes)] = sizes
