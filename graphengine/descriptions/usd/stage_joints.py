"""Reads joints with their limits and drives; runs in the confined process."""

from __future__ import annotations

import math

from pxr import Gf, Usd, UsdPhysics

from graphengine.descriptions.usd.stage_bodies import body_of
from graphengine.descriptions.usd.stage_frames import StageFrames, finite, given, number, target, text
from graphengine.descriptions.usd_model import StageDrive, StageJoint
from graphengine.devices.rotation import Pose, Vector3

_KINDS = {
    "PhysicsRevoluteJoint": "revolute",
    "PhysicsPrismaticJoint": "prismatic",
    "PhysicsFixedJoint": "fixed",
    "PhysicsSphericalJoint": "spherical",
    "PhysicsDistanceJoint": "distance",
    "PhysxPhysicsGearJoint": "gear",
    "PhysxPhysicsRackAndPinionJoint": "rack and pinion",
}
_DEGREES_OF_FREEDOM = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
_AXES: dict[str, Vector3] = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_FAR = 1e6
"""Value of the missing limit of a joint that has only one limit, m or rad."""


def is_joint(prim: Usd.Prim) -> bool:
    """Return whether a prim is a joint."""
    return prim.IsA(UsdPhysics.Joint) or str(prim.GetTypeName()) in _KINDS


def read_joint(prim: Usd.Prim, frames: StageFrames) -> StageJoint:
    """Return a joint.

    Raises:
        UnusableError: a number of the prim is not finite.
    """
    sides = [_side(prim, index, frames) for index in (0, 1)]
    kind, free = _KINDS.get(str(prim.GetTypeName()), "D6"), ""
    if kind == "D6":
        kind, free = _of_degrees(prim)
    joint = StageJoint(str(prim.GetPath()), kind, (sides[0][0], sides[1][0]), (sides[0][1], sides[1][1]))
    joint.enabled = given(prim, "physics:jointEnabled") is not False
    joint.in_tree = given(prim, "physics:excludeFromArticulation") is not True
    if finite(prim, "physics:breakForce") is not None or finite(prim, "physics:breakTorque") is not None:
        joint.remarks.append("break force and torque: joints never break")
    if kind not in ("revolute", "prismatic"):
        return joint
    joint.axis = _AXES.get(free[-1:] or text(prim, "physics:axis"), _AXES["X"])
    turns = kind == "revolute"
    name = "angular" if turns else "linear"
    length = math.radians(1.0) if turns else frames.metres
    force = frames.kilograms * (frames.metres**2 if turns else frames.metres)
    prefix = f"limit:{free}:physics:low,limit:{free}:physics:high" if free else "physics:lowerLimit,physics:upperLimit"
    lower, upper = (finite(prim, each) for each in prefix.split(","))
    if lower is not None or upper is not None:
        joint.lower = lower * length if lower is not None else -_FAR
        joint.upper = upper * length if upper is not None else _FAR
    joint.drive = _drive(prim, free or name, length, force)
    _more(prim, joint, name, length, force)
    return joint


def _side(prim: Usd.Prim, index: int, frames: StageFrames) -> tuple[str, Pose]:
    """Return the path of a body of a joint, and the pose in the world of the joint's frame on it."""
    path = target(prim, f"physics:body{index}")
    holder = prim.GetStage().GetPrimAtPath(path) if path else None
    position, rotation = given(prim, f"physics:localPos{index}"), given(prim, f"physics:localRot{index}")
    position = position if position is not None else (0.0, 0.0, 0.0)
    pose = frames.anchor(holder if holder else None, position, rotation if rotation is not None else Gf.Quatd(1.0))
    return (body_of(holder) if holder else ""), pose


def _of_degrees(prim: Usd.Prim) -> tuple[str, str]:
    """Return the type of a joint by its degrees of freedom, of which limits with low > high lock some, and the only free one."""
    locked = {
        name
        for name in _DEGREES_OF_FREEDOM
        if prim.HasAPI(UsdPhysics.LimitAPI, name)
        and number(prim, f"limit:{name}:physics:low", -math.inf) > number(prim, f"limit:{name}:physics:high", math.inf)
    }
    free = [name for name in _DEGREES_OF_FREEDOM if name not in locked]
    if not free:
        return "fixed", ""
    if len(free) > 1:
        return "spherical" if all(name.startswith("rot") for name in free) and len(free) == 3 else "D6", ""
    return ("revolute" if free[0].startswith("rot") else "prismatic"), free[0]


def _drive(prim: Usd.Prim, name: str, length: float, force: float) -> StageDrive | None:
    """Return the drive of a joint in SI units; None without one.

    Args:
        prim: prim of the joint.
        name: name of the drive: angular, linear, or a degree of freedom.
        length: rad or m in a unit of the stage.
        force: N m or N in a unit of the stage.
    """
    if not prim.HasAPI(UsdPhysics.DriveAPI, name):
        return None
    of = f"drive:{name}:physics:"
    drive = StageDrive(acceleration=text(prim, f"{of}type") == "acceleration")
    gain = (1.0 if drive.acceleration else force) / length
    if drive.acceleration and name.startswith(("linear", "trans")):
        gain = 1.0
    drive.stiffness = max(finite(prim, f"{of}stiffness") or 0.0, 0.0) * gain
    drive.damping = max(finite(prim, f"{of}damping") or 0.0, 0.0) * gain
    largest = finite(prim, f"{of}maxForce")
    drive.max_force = largest * force if largest is not None and largest > 0 else None
    drive.position = (finite(prim, f"{of}targetPosition") or 0.0) * length
    drive.velocity = (finite(prim, f"{of}targetVelocity") or 0.0) * length
    return drive


def _more(prim: Usd.Prim, joint: StageJoint, name: str, length: float, force: float) -> None:
    """Add what PhysX's schemas say of a joint: armature, friction, velocity limit, mimicry, and its position."""
    turns, of = joint.kind == "revolute", f"physxJointAxis:{name}:"
    inertia = force if turns else force / length
    joint.armature = max(finite(prim, "physxJoint:armature") or finite(prim, f"{of}armature") or 0.0, 0.0) * inertia
    fastest = finite(prim, "physxJoint:maxJointVelocity") or finite(prim, f"{of}maxJointVelocity")
    joint.max_velocity = fastest * length if fastest is not None and fastest > 0 else None
    joint.friction = max(finite(prim, f"{of}dynamicFrictionEffort") or 0.0, 0.0) * force
    joint.damping = max(finite(prim, f"{of}viscousFrictionCoefficient") or 0.0, 0.0) * force / length
    if finite(prim, "physxJoint:jointFriction"):
        joint.remarks.append("jointFriction: a coefficient of the forces on the joint, which MuJoCo does not have")
    if (position := finite(prim, f"state:{name}:physics:position")) is not None:
        joint.position = position * length
    for axis in ("rotX", "rotY", "rotZ", "transX", "transY", "transZ"):
        of = f"physxMimicJoint:{axis}:"
        if leader := target(prim, f"{of}referenceJoint"):
            joint.leader = leader
            joint.multiplier = -number(prim, f"{of}gearing")
            joint.offset = -(finite(prim, f"{of}offset") or 0.0) * length
            return
