"""Wheels with rollers: mecanum wheels and omnidirectional wheels."""

from __future__ import annotations

from dataclasses import dataclass

from graphengine.devices.rotation import Vector3


@dataclass(frozen=True, slots=True)
class HolonomicWheel:
    """A wheel with rollers, which grips the floor only along the roller axis; geometry with all joints of the robot at zero."""

    joint: str
    """Name of the joint that turns the wheel."""
    radius: float
    """Radius of the wheel, m."""
    position: Vector3
    """Origin of the joint in the frame of the robot's base link, m."""
    axle: Vector3
    """Unit vector of the joint's axis in the frame of the base link."""
    roller_angle: float
    """Angle from the axle to the axis of the roller on the floor, about the z axis of the base link: above -90 to 90 degrees."""
