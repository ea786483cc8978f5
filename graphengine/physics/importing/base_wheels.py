"""The wheels that a description's robot stands on: where they are, what steers them, and which of them are casters."""

from __future__ import annotations

from dataclasses import dataclass

from graphengine.devices.rotation import Vector3, rotate
from graphengine.physics.description.urdf import Urdf, UrdfJoint

_ALIGNED = 0.99
"""Least cosine of the angle between two axes that count as parallel."""
_OFF_FLOOR = 0.1
"""Highest distance of a wheel from the floor, in radii, at which it touches it in use."""
_TRAIL = 0.1
"""Least distance, in radii, of a caster's wheel behind the axis of its swivel."""


@dataclass(frozen=True, slots=True)
class BaseWheel:
    """A wheel on the floor.

    Attributes:
        joint: that it turns on.
        link: that it is.
        radius: m.
        centre: in the root link, all joints at zero, m.
        axle: the joint's axis in the root link; a positive speed rolls forward if it points to the left.
        swivel: joint with an upright axis that turns the wheel about itself, empty if there is none.
        caster: whether the wheel trails behind its swivel.
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
        """Whether the axle lies along the y axis of the root link, so that the wheel rolls forward."""
        return abs(self.axle[1]) > _ALIGNED

    @property
    def sign(self) -> float:
        """1 if a positive speed of the joint rolls forward, else -1."""
        return 1.0 if self.axle[1] > 0 else -1.0


def wheels_on_floor(urdf: Urdf) -> list[BaseWheel]:
    """Return the wheels that touch the floor when the robot stands upright, in order of the description."""
    found = [_wheel(urdf, joint) for joint in urdf.moving()]
    wheels = [wheel for wheel in found if wheel is not None]
    rolling = [wheel for wheel in wheels if not wheel.caster] or wheels
    floor = min((wheel.centre[2] - wheel.radius for wheel in rolling), default=0.0)
    return [wheel for wheel in wheels if abs(wheel.centre[2] - wheel.radius - floor) <= _OFF_FLOOR * wheel.radius]


def axis_in_root(urdf: Urdf, joint: UrdfJoint) -> Vector3:
    """Return a joint's axis in the root link, all joints at zero."""
    return rotate(urdf.pose_in_root(joint.child)[1], joint.axis)


def _wheel(urdf: Urdf, joint: UrdfJoint) -> BaseWheel | None:
    found = urdf.wheels([joint])
    axle = axis_in_root(urdf, joint)
    if not found or abs(axle[2]) > 1 - _ALIGNED:
        return None
    origin = urdf.pose_in_root(joint.child)[0]
    along = found[0].along - sum(a * b for a, b in zip(origin, axle, strict=True))
    x, y, z = (a + along * b for a, b in zip(origin, axle, strict=True))
    swivel = _swivel(urdf, joint)
    caster = False
    if swivel is not None:
        pivot = urdf.pose_in_root(swivel.child)[0]
        trail = abs((x - pivot[0]) * axle[1] - (y - pivot[1]) * axle[0])  # across the axle, in the plane of the floor
        caster = trail > _TRAIL * found[0].radius
    return BaseWheel(
        joint.name, joint.child, found[0].radius, (x, y, z), axle, swivel.name if swivel is not None else "", caster
    )


def _swivel(urdf: Urdf, joint: UrdfJoint) -> UrdfJoint | None:
    """The nearest joint above a wheel that turns about an upright axis."""
    carrier = urdf.links[joint.parent].carrier
    while carrier is not None:
        if carrier.type in ("revolute", "continuous") and abs(axis_in_root(urdf, carrier)[2]) > _ALIGNED:
            return carrier
        carrier = urdf.links[carrier.parent].carrier
    return None
