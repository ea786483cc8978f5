"""The geometry of mecanum wheels and omnidirectional wheels, which have rollers on their rim."""

from __future__ import annotations

from dataclasses import dataclass

from graphengine.devices.rotation import Vector3


@dataclass(frozen=True, slots=True)
class HolonomicWheel:
    """A wheel with rollers: it grips the floor only along the roller axis.

    The attributes are the values with all joints of the robot at position zero.
    """

    joint: str
    """Name of the joint that turns the wheel."""
    radius: float
    """Radius of the wheel, m."""
    position: Vector3
    """Origin of the joint in the frame of the robot's base link, m."""
    axle: Vector3
    """Unit vector of the joint's axis in the frame of the base link."""
    roller_angle: float
    """Angle from the axle to the axis of the roller on the floor, about the base link's z axis; degrees, -90 < angle ≤ 90."""
