"""Finds the wheels on which a robot stands: their positions, their steering joints, and which are casters."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from graphengine.devices.rotation import Vector3
from graphengine.physics.description.urdf import Urdf, UrdfJoint
from graphengine.physics.importing.draft import Draft, WheelShape

_ALIGNED = 0.99
"""Least cosine of the angle between two axes that count as parallel."""
_TRAIL = 0.1
"""Least distance, in radii, of a caster's wheel behind the axis of its swivel."""
_MIRRORED = 0.1
"""Greatest difference, in radii, of the places of two wheels from those of a left and a right one."""


@dataclass(frozen=True, slots=True)
class BaseWheel:
    """A wheel on the floor.

    Attributes:
        joint: joint that turns the wheel.
        link: link of the wheel.
        radius: radius, m.
        centre: centre in the root link, with all joints at zero, m.
        axle: the joint's axis in the root link; a positive speed rolls forward if it points to the left.
        swivel: joint with a vertical axis that steers the wheel; empty without one.
        caster: whether the swivel turns freely, because it trails or is the only one.
    """

    joint: str
    link: str
    radius: float
    centre: Vector3
    axle: Vector3
    swivel: str
    caster: bool

    @property
    def sideways(self) -> bool:
        """Whether the axle is parallel to the y axis of the root link, so that the wheel rolls forward."""
        return abs(self.axle[1]) > _ALIGNED

    @property
    def sign(self) -> float:
        """1 if a positive speed of the joint rolls forward, else -1."""
        return 1.0 if self.axle[1] > 0 else -1.0


def wheels_on_floor(draft: Draft, commanded: Collection[str]) -> list[BaseWheel]:
    """Return the wheels on which a robot stands, in order of its joints.

    Args:
        draft: contains the wheels.
        commanded: joints that take commands, which cannot be the swivel of a caster.
    """
    urdf, axes = draft.urdf, draft.urdf.axes_in_root()
    shapes = [shape for shape in draft.wheels.values() if shape.on_floor]
    swivels = [_swivel(urdf, urdf.joints[shape.joint], axes) for shape in shapes]
    swivelling = [shape for shape, swivel in zip(shapes, swivels, strict=True) if swivel is not None]
    return [_wheel(urdf, shape, swivel, commanded, swivelling) for shape, swivel in zip(shapes, swivels, strict=True)]


def _wheel(
    urdf: Urdf, shape: WheelShape, swivel: UrdfJoint | None, commanded: Collection[str], others: Iterable[WheelShape]
) -> BaseWheel:
    caster = False
    if swivel is not None and swivel.name not in commanded:
        (x, y, _), (pivot_x, pivot_y, _) = shape.centre, urdf.pose_in_root(swivel.child)[0]
        trail = abs((x - pivot_x) * shape.axis[1] - (y - pivot_y) * shape.axis[0])  # across the axle
        caster = trail > _TRAIL * shape.radius or (shape.swivels and not any(_mirrors(shape, each) for each in others))
    pivot = swivel.name if swivel is not None else ""
    return BaseWheel(shape.joint, shape.link, shape.radius, shape.centre, shape.axis, pivot, caster)


def _mirrors(one: WheelShape, other: WheelShape) -> bool:
    """Return whether two wheels stand opposite each other."""
    (x, y, _), (other_x, other_y, _) = one.centre, other.centre
    near = _MIRRORED * one.radius
    return abs(x - other_x) < near and abs(y + other_y) < near and abs(y) > near


def _swivel(urdf: Urdf, joint: UrdfJoint, axes: Mapping[str, Vector3]) -> UrdfJoint | None:
    """Return the nearest joint above a wheel that has a vertical axis."""
    carrier = urdf.links[joint.parent].carrier
    while carrier is not None:
        if carrier.type in ("revolute", "continuous") and abs(axes[carrier.name][2]) > _ALIGNED:
            return carrier
        carrier = urdf.links[carrier.parent].carrier
    return None
