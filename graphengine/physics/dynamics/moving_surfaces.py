"""Bodies with a surface velocity, such as conveyor belts: they stay in place and carry along the objects on them.

MuJoCo computes the velocity of a contact only from the joints of both bodies. So a body with a moving surface gets six joints
that have the velocity of the surface. The inertia of these joints is so large that no contact changes their velocity; their
coordinates are reset after each step. (Setting the solver's reference velocity of a contact instead would have no effect: the
discrete integrator overwrites it.)

A box on a belt moves, relative to the belt, like a box that slides on a floor (within 1e-5 m/s), until it has exactly the belt's
speed. Each belt adds 15 us to a step; a model without belts is not slower.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection
from typing import Self

import numpy as np

from graphengine.devices.rotation import Vector3
from graphengine.format.stateful import Stateful
from graphengine.physics.engine import Floats, mujoco

Velocity = tuple[Vector3, Vector3]
"""Linear (m/s) and angular (rad/s) velocity of a surface about the body's origin, in the body's frame."""

AT_REST: Velocity = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
_FIRM = 1e8
"""Inertia of a surface joint, kg or kg m2; it is so large that no contact changes the joint's velocity."""
_SUFFIX = ".surface"
"""Part of the name of a surface joint, between the body's name and the joint's number."""
_JOINTS = [
    (kind, [float(axis == number) for number in range(3)])
    for kind in (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE)
    for axis in range(3)
]


def add_surface_joints(spec: mujoco.MjSpec, names: Collection[str]) -> None:
    """Add the joints of a moving surface to the named bodies of a model; unknown names are skipped.

    The joints do not make the bodies collide with bodies that are fixed to the same parent, such as the floor and other belts.
    """
    belts = {name for name in names if spec.body(name) is not None}
    groups = _fixed_together(spec, belts) if belts else []
    if belts:
        # The solver's tolerance is relative to the inertias in contact: it would stop too early for light bodies.
        spec.option.tolerance /= _FIRM
    for parts in groups:
        for one, other in itertools.combinations(parts.values(), 2):
            for first, second in itertools.product(one, other):
                spec.add_exclude(bodyname1=first, bodyname2=second)
    for name in sorted(belts):
        for number, (kind, axis) in enumerate(_JOINTS):
            joint = spec.body(name).add_joint(name=f"{name}{_SUFFIX}{number}", type=kind, axis=axis, armature=_FIRM)
            joint.limited, joint.frictionloss, joint.ref = mujoco.mjtLimited.mjLIMITED_FALSE, 0.0, 0.0
            joint.stiffness[:] = joint.damping[:] = 0.0  # whatever the world's defaults are


def _fixed_together(spec: mujoco.MjSpec, belts: Collection[str]) -> list[dict[str, list[str]]]:
    """Return the bodies of a model in groups that are rigidly fixed together, and within a group by the belt that carries them.

    A group maps the name of each belt to the names of the belt and of all bodies fixed to it; the key "" has the bodies that no
    belt carries. Bodies without a name get one.
    """
    groups: list[dict[str, list[str]]] = []
    pending: list[tuple[mujoco.MjsBody, dict[str, list[str]], str]] = [(spec.worldbody, {}, "")]
    for body, group, belt in pending:  # which grows by the children of each body
        if not group or list(body.joints):
            group, belt = {}, ""
            groups.append(group)
        body.name = body.name or f"{_SUFFIX}.{len(pending)}"
        belt = body.name if body.name in belts else belt
        group.setdefault(belt, []).append(body.name)
        pending += [(child, group, belt) for child in body.bodies]
    return groups


class MovingSurfaces(Stateful):
    """The moving surfaces of a compiled model; `bound_to` looks them up.

    Attributes:
        velocities: velocity of each surface, by the name of its body.
    """

    kept = ("velocities",)

    def __init__(self) -> None:
        self.velocities: dict[str, Velocity] = {}
        self._rows: list[tuple[Floats, Floats, str]] = []

    def bound_to(self, model: mujoco.MjModel, data: mujoco.MjData) -> Self:
        """Return the moving surfaces of another model; surfaces that both models have keep their velocities."""
        made, count = type(self)(), len(_JOINTS)
        for body in np.flatnonzero(model.body_jntnum == count).tolist():
            name = model.body(body).name
            joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"{name}{_SUFFIX}0")
            if joint >= 0:
                place, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
                made._rows.append((data.qpos[place : place + count], data.qvel[dof : dof + count], name))
                made.velocities[name] = self.velocities.get(name, AT_REST)
        made.hold()
        return made

    def __bool__(self) -> bool:
        return bool(self._rows)

    def hold(self) -> None:
        """Write the surface velocities to the state, and reset the positions of the surface joints to zero."""
        for coordinates, speeds, body in self._rows:
            coordinates[:] = 0.0
            speeds[:3], speeds[3:] = self.velocities[body]

    def stop(self) -> None:
        """Set all velocities to zero."""
        self.velocities = dict.fromkeys(self.velocities, AT_REST)
