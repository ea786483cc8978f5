"""Adds the joints with which a body has a surface velocity or follows a route; `moving_surfaces` explains how they work."""

from __future__ import annotations

import itertools
from collections.abc import Collection

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.routes import route_from, routes_of

_FIRM = 1e8
"""Inertia of a surface joint, kg or kg m2; it is so large that no contact changes the joint's velocity."""
_MOVER = 1e6
"""Inertia of a mover's joint, kg or kg m2; with it, MuJoCo's tolerance is small enough for bodies from 10 g."""
SUFFIX = ".surface"
"""Part of the name of a surface joint, between the body's name and the joint's number."""
JOINTS = [
    (kind, [float(axis == number) for number in range(3)])
    for kind in (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE)
    for axis in range(3)
]
_FLAT = [JOINTS[0], JOINTS[1], JOINTS[5]]
"""The joints of a mover that stays at one height: its position in the world, and its heading."""
_RISING = [*_FLAT, JOINTS[2]]
"""The joints of any other mover; the last one is its height."""


def add_surface_joints(spec: mujoco.MjSpec, names: Collection[str]) -> None:
    """Add joints to the movers of a model, and surface joints to the named bodies; unknown names are skipped.

    The joints do not make the bodies collide with bodies that are fixed to the same parent, such as the floor and other belts.
    """
    routes = {name: route_from(text) for name, text in routes_of(spec).items()}
    joints = {name: (JOINTS, _FIRM) for name in names if spec.body(name) is not None}
    if joints:
        # The solver's tolerance is relative to the inertias in contact: it would stop too early for light bodies.
        spec.option.tolerance /= _FIRM
    joints |= {name: (_RISING if route.rises else _FLAT, _MOVER) for name, route in routes.items()}
    for parts in _fixed_together(spec, joints.keys()) if joints else ():
        for one, other in itertools.combinations(parts.values(), 2):
            for first, second in itertools.product(one, other):
                spec.add_exclude(bodyname1=first, bodyname2=second)
    for name, (kinds, inertia) in sorted(joints.items()):
        for number, (kind, axis) in enumerate(kinds):
            joint = spec.body(name).add_joint(name=f"{name}{SUFFIX}{number}", type=kind, axis=axis, armature=inertia)
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
        body.name = body.name or f"{SUFFIX}.{len(pending)}"
        belt = body.name if body.name in belts else belt
        group.setdefault(belt, []).append(body.name)
        pending += [(child, group, belt) for child in body.bodies]
    return groups
