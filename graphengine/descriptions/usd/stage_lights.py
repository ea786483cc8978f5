"""Reads lights and gravity; runs in the confined process."""

from __future__ import annotations

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics

from graphengine.descriptions.usd.stage_frames import StageFrames, given, number, vector
from graphengine.descriptions.usd_model import StageLight
from graphengine.devices.rotation import Vector3

_KINDS = {
    "DistantLight": "directional",
    "DomeLight": "ambient",
    "DomeLight_1": "ambient",
    "SphereLight": "point",
    "CylinderLight": "point",
    "RectLight": "spot",
    "DiskLight": "spot",
}
_GRAVITY = 9.81
"""Magnitude of gravity in a scene that does not give it, m/s2; so Isaac Sim takes the specification's "earth gravity"."""


def read_light(prim: Usd.Prim, frames: StageFrames) -> StageLight | None:
    """Return a visible light; None for another prim.

    Raises:
        UnusableError: the transform or the colour is not finite.
    """
    kind = _KINDS.get(str(prim.GetTypeName()))
    if kind is None or UsdGeom.Imageable(prim).ComputeVisibility() == "invisible":
        return None
    colour = given(prim, "inputs:color")
    red, green, blue = vector(np.array(colour if colour is not None else (1.0, 1.0, 1.0), np.float64))
    return StageLight(str(prim.GetPath()), kind, frames.placed(prim).pose, (red, green, blue))


def read_gravity(prim: Usd.Prim, frames: StageFrames) -> Vector3 | None:
    """Return the gravity of a physics scene, m/s2; None for another prim.

    Raises:
        UnusableError: a number is not finite.
    """
    if not prim.IsA(UsdPhysics.Scene):
        return None
    direction = np.array(given(prim, "physics:gravityDirection"), np.float64)
    length = float(np.linalg.norm(direction))
    down = frames.turn @ direction / length if length else np.array([0.0, 0.0, -1.0])
    magnitude = number(prim, "physics:gravityMagnitude", -1.0)
    return vector(down * (magnitude * frames.metres if magnitude >= 0 else _GRAVITY))
