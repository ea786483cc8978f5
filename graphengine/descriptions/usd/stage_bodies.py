"""Reads rigid bodies and their masses; runs in the confined process."""

from __future__ import annotations

import numpy as np
from pxr import Gf, Usd, UsdPhysics

from graphengine.descriptions.usd.stage_frames import StageFrames, given, number, quaternion, vector
from graphengine.descriptions.usd_model import StageBody
from graphengine.devices.rotation import Vector3


def is_body(prim: Usd.Prim) -> bool:
    """Return whether a prim is a rigid body that is enabled."""
    return bool(prim.HasAPI(UsdPhysics.RigidBodyAPI)) and given(prim, "physics:rigidBodyEnabled") is not False


def body_of(prim: Usd.Prim) -> str:
    """Return the path of the body to which a prim belongs: its nearest ancestor, or itself; empty for the world."""
    while prim and not prim.IsPseudoRoot():
        if is_body(prim):
            return str(prim.GetPath())
        prim = prim.GetParent()
    return ""


def read_body(prim: Usd.Prim, frames: StageFrames) -> StageBody:
    """Return a rigid body without its shapes.

    Raises:
        UnusableError: a number of the prim is not finite.
    """
    kilograms, metres, turn = frames.kilograms, frames.metres, frames.turn
    body = StageBody(str(prim.GetPath()), frames.body_pose(prim))
    body.mass = max(number(prim, "physics:mass"), 0.0) * kilograms
    body.density = max(number(prim, "physics:density"), 0.0) * kilograms / metres**3
    centre = _three(prim, "physics:centerOfMass")
    if centre is not None:
        body.centre = vector(metres * (turn @ (frames.placed(prim).stretch @ np.array(centre))))
    moments = _three(prim, "physics:diagonalInertia")
    if moments is not None and any(moments):
        body.moments = vector(np.array(moments) * kilograms * metres**2)
        axes = given(prim, "physics:principalAxes")
        if axes is not None and Gf.Quatd(axes).GetLength() > 0:  # zero: along the axes of the body
            turned = np.array(Gf.Matrix3d(Gf.Quatd(axes).GetNormalized()), np.float64).T
            body.axes = quaternion(turn @ turned)
        else:
            body.axes = quaternion(turn)
    body.gravity = given(prim, "physxRigidBody:disableGravity") is not True
    body.kinematic = given(prim, "physics:kinematicEnabled") is True
    return body


def _three(prim: Usd.Prim, name: str) -> Vector3 | None:
    """Return the three finite numbers of an attribute; None if it has none, as the infinite centre of mass by default."""
    value = given(prim, name)
    if value is None or len(value) != 3 or not np.isfinite(np.array(value, np.float64)).all():
        return None
    x, y, z = map(float, value)
    return x, y, z
