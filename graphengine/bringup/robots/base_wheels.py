"""Finds the wheels on which a robot stands, with their positions and steering joints, and detects casters."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from graphengine.descriptions.robot_description import TURNING, Joint, RobotDescription
from graphengine.descriptions.robot_files.draft import Draft, WheelShape
from graphengine.descriptions.rollers import NO_ROLLERS, Rollers
from graphengine.devices.rotation import Vector3

ALIGNED = 0.99
"""Minimum cosine of the angle between two axes that count as parallel."""
_TRAIL = 0.1
"""Minimum distance of a caster's axle from the axis of its swivel, as a fraction of the wheel's radius."""
_MIRRORED = 0.1
"""Maximum deviation of a pair of wheels from mirrored positions, as a fraction of the wheel's radius."""


@dataclass(frozen=True, slots=True)
class BaseWheel:
    """A wheel of a mobile base, with all joints at position zero.

    Attributes:
        joint: name of the joint that turns the wheel.
        link: name of the wheel's link.
        radius: radius of the wheel, m.
        centre: centre of the wheel in the root link's frame, m.
        axle: axis of the joint in the root link's frame; if it points to the left, the wheel rolls forward at positive speed.
        swivel: name of the joint with a vertical axis that steers the wheel; empty without such a joint.
        caster: whether the swivel turns freely: its wheel trails, or it is limitless and has no counterpart on the other side.
        rollers: rollers of an omni or mecanum wheel, if the description models them.
    """

    joint: str
    link: str
    radius: float
    centre: Vector3
    axle: Vector3
    swivel: str
    caster: bool
    rollers: Rollers = NO_ROLLERS

    @property
    def sideways(self) -> bool:
        """Whether the axle is parallel to the y axis of the root link, so that the wheel rolls forward and backward."""
        return abs(self.axle[1]) > ALIGNED

    @property
    def sign(self) -> float:
        """1 if the wheel rolls forward at positive joint speed, else -1."""
        return 1.0 if self.axle[1] > 0 else -1.0


def wheels_on_floor(draft: Draft, commanded: Collection[str]) -> list[BaseWheel]:
    """Return the wheels on which a robot stands, in order of the joints.

    Args:
        draft: draft with the wheels found in the description.
        commanded: names of joints that take commands; such a joint cannot be the swivel of a caster.
    """
    description, axes = draft.description, draft.description.axes_in_root()
    shapes = [shape for shape in draft.wheels.values() if shape.on_floor]
    swivels = [_swivel(description, description.joints[shape.joint], axes) for shape in shapes]
    swivelling = [shape for shape, swivel in zip(shapes, swivels, strict=True) if swivel is not None]
    return [
        _wheel(description, shape, swivel, commanded, swivelling) for shape, swivel in zip(shapes, swivels, strict=True)
    ]


def _wheel(
    description: RobotDescription,
    shape: WheelShape,
    swivel: Joint | None,
    commanded: Collection[str],
    others: Iterable[WheelShape],
) -> BaseWheel:
    caster = False
    if swivel is not None and swivel.name not in commanded:
        (x, y, _), (pivot_x, pivot_y, _) = shape.centre, description.pose_in_root(swivel.child)[0]
        trail = abs((x - pivot_x) * shape.axis[1] - (y - pivot_y) * shape.axis[0])  # across the axle
        caster = trail > _TRAIL * shape.radius or (shape.swivels and not any(_mirrors(shape, each) for each in others))
    pivot = swivel.name if swivel is not None else ""
    return BaseWheel(shape.joint, shape.link, shape.radius, shape.centre, shape.axis, pivot, caster, shape.rollers)


def _mirrors(one: WheelShape, other: WheelShape) -> bool:
    """Return whether two wheels stand at mirrored positions left and right of the root link's x axis."""
    (x, y, _), (other_x, other_y, _) = one.centre, other.centre
    near = _MIRRORED * one.radius
    return abs(x - other_x) < near and abs(y + other_y) < near and abs(y) > near


def _swivel(description: RobotDescription, joint: Joint, axes: Mapping[str, Vector3]) -> Joint | None:
    """Return the nearest rotating joint with a vertical axis above a wheel's joint; None if there is none."""
    turning = (carrier for carrier in description.carriers(joint.parent) if carrier.type in TURNING)
    return next((carrier for carrier in turning if abs(axes[carrier.name][2]) > ALIGNED), None)
