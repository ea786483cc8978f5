"""Converts the transforms of prims to poses in metres with z up; runs in the confined process."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdGeom, UsdPhysics

from graphengine.devices.rotation import Pose, Quaternion, Vector3

Matrix = NDArray[np.float64]
_ENDLESS = 3.4e38
"""Numbers from here on mean infinity, because some programs write the largest number of single precision for it."""
_UP = {"Z": np.eye(3), "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])}
"""Rotation from the axes of a stage to axes with z up, by the stage's up axis."""


class UnusableError(Exception):
    """A prim cannot be used; the message gives the reason."""


@dataclass(frozen=True, slots=True)
class Placed:
    """The transform of a prim: a rotation, a position in metres, and the stretch that is applied before the rotation."""

    rotation: Matrix
    position: Matrix
    stretch: Matrix
    """Symmetric factor of the polar decomposition, without the unit of length; negative for a mirrored prim."""

    @property
    def pose(self) -> Pose:
        """The pose of a geometry whose own axes are those of the prim."""
        return vector(self.position), quaternion(self.rotation)


class StageFrames:
    """Transforms of the prims of a stage, and its units.

    Attributes:
        metres: length of the stage's unit, m.
        kilograms: mass of the stage's unit, kg.
        turn: rotation from the axes of the stage to axes with z up.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        self.assumed: list[str] = []
        """What the stage does not state, and what is assumed as in Isaac Sim; USD's own defaults are centimetres with y up."""
        metres, up = UsdGeom.GetStageMetersPerUnit(stage), str(UsdGeom.GetStageUpAxis(stage))
        if not stage.HasAuthoredMetadata("metersPerUnit"):
            metres = 1.0
            self.assumed.append("metersPerUnit: 1")
        if not stage.HasAuthoredMetadata("upAxis"):
            up = "Z"
            self.assumed.append("upAxis: Z")
        self.metres = _unit(metres, "metersPerUnit")
        self.kilograms = _unit(UsdPhysics.GetStageKilogramsPerUnit(stage), "kilogramsPerUnit")
        self.turn = _UP.get(up, _UP["Z"])
        self._cache = UsdGeom.XformCache(Usd.TimeCode.Default())

    def placed(self, prim: Usd.Prim) -> Placed:
        """Return the transform of a prim to the world.

        Raises:
            UnusableError: the transform is not finite.
        """
        matrix = np.array(self._cache.GetLocalToWorldTransform(prim), np.float64).T
        if not np.isfinite(matrix).all():
            raise UnusableError("its transform is not finite")
        linear = self.turn @ matrix[:3, :3]
        left, scales, right = np.linalg.svd(linear)
        rotation, stretch = left @ right, right.T @ np.diag(scales) @ right
        if (
            np.linalg.det(rotation) < 0
        ):  # as GfMatrix4d.Factor: a mirrored prim is turned, and all its scales are negative
            rotation, stretch = -rotation, -stretch
        return Placed(rotation, self.metres * (self.turn @ matrix[:3, 3]), stretch)

    def body_pose(self, prim: Usd.Prim) -> Pose:
        """Return the pose of a body, whose own axes are turned with the stage, so that its z axis points up if its y axis did."""
        placed = self.placed(prim)
        return vector(placed.position), quaternion(placed.rotation @ self.turn.T)

    def anchor(self, prim: Usd.Prim | None, position: Any, rotation: Any) -> Pose:
        """Return the pose in the world of a frame that is given in the frame of a prim, whose scale applies to its position.

        Args:
            prim: prim whose frame it is; None for the world.
            position: position in the units of the stage.
            rotation: USD quaternion.
        """
        local = np.array(position, np.float64)
        spin = Gf.Quatd(rotation).GetNormalized() if Gf.Quatd(rotation).GetLength() > 0 else Gf.Quatd(1.0)
        turned = np.array(Gf.Matrix3d(spin), np.float64).T
        if prim is None:
            return vector(self.metres * (self.turn @ local)), quaternion(self.turn @ turned)
        placed = self.placed(prim)
        place = placed.position + self.metres * (placed.rotation @ placed.stretch @ local)
        return vector(place), quaternion(placed.rotation @ turned)


def vector(values: Matrix) -> Vector3:
    """Return three numbers as a tuple.

    Raises:
        UnusableError: a number is not finite.
    """
    x, y, z = values.tolist()
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        raise UnusableError("a coordinate is not finite")
    return x, y, z


def quaternion(rotation: Matrix) -> Quaternion:
    """Return the unit quaternion (x, y, z, w) of a rotation matrix."""
    found = Gf.Matrix3d(*rotation.T.reshape(9).tolist()).ExtractRotation().GetQuat().GetNormalized()
    x, y, z = found.GetImaginary()
    return float(x), float(y), float(z), float(found.GetReal())


def number(prim: Usd.Prim, name: str, default: float = 0.0) -> float:
    """Return the number that an attribute has at the default time; `default` if it has none or is not a number."""
    value = given(prim, name)
    return float(value) if isinstance(value, int | float) and not math.isnan(value) else default


def finite(prim: Usd.Prim, name: str) -> float | None:
    """Return the finite number that is written for an attribute; None without one."""
    attribute = prim.GetAttribute(name)
    value = number(prim, name, math.inf) if attribute and attribute.HasAuthoredValue() else math.inf
    return value if abs(value) < _ENDLESS else None


def given(prim: Usd.Prim, name: str) -> Any:
    """Return the value of an attribute at the default time; None without one."""
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute else None


def text(prim: Usd.Prim, name: str) -> str:
    """Return the value of an attribute if it is text, else an empty string."""
    value = given(prim, name)
    return value if isinstance(value, str) else ""


def target(prim: Usd.Prim, name: str) -> str:
    """Return the path of the first target of a relationship; empty without one."""
    found = prim.GetRelationship(name).GetTargets() if prim.GetRelationship(name) else []
    return str(found[0].GetPrimPath()) if found else ""


def _unit(value: float, name: str) -> float:
    if not (math.isfinite(value) and 1e-9 <= value <= 1e9):
        raise UnusableError(f"its {name} is {value:g}; legal are 1e-9 to 1e9")
    return float(value)
