"""Joint drives in SI units, and the MuJoCo servos that stand for them.

PhysX's drive is one spring and damper: force = stiffness (q* - q) + damping (v* - v). MuJoCo gets it as two actuators, whose
forces add up. Both need the `discrete` integrator, which solves servo damping together with the contacts: with any other one
a damping above about 10 on light wheels throws the robot about.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from graphengine.spec import JointSpec

DEGREES = 180 / math.pi
"""Degrees in a radian: USD stores angular drives per degree, which PhysX multiplies by this."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Gains and limits of a joint's drive; rad or m, N m or N."""

    stiffness: float = 0.0
    damping: float = 0.0
    target_velocity: float = 0.0
    max_acceleration: float = math.inf
    """Limit on the slope of the velocity set point. Not a force limit: a saturated servo loses its implicit damping."""


def drive_of(joint: JointSpec, *, prismatic: bool) -> Drive | None:
    """The drive of a joint, None if it has none; lengths in USD are metres, so only angles change."""
    if joint.drive is not None:
        drive = joint.drive
        return Drive(drive.stiffness, drive.damping, drive.target_velocity, drive.max_acceleration or math.inf)
    if joint.usd_drive is not None:
        usd, factor = joint.usd_drive, 1.0 if prismatic else DEGREES
        return Drive(usd.stiffness * factor, usd.damping * factor, usd.target_velocity / factor)
    return None


def position_servo(joint: str) -> str:
    """Name of the actuator that pulls a joint to its target position."""
    return f"{joint}.position"


def velocity_servo(joint: str) -> str:
    """Name of the actuator that pulls a joint to its target velocity."""
    return f"{joint}.velocity"
