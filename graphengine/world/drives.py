"""Joint drives in SI units, the MuJoCo servos that stand for them, and the set points that they follow.

PhysX's drive is one spring and damper: force = stiffness (q* - q) + damping (v* - v). MuJoCo gets it as two actuators, whose
forces add up. Both need the `discrete` integrator, which solves servo damping together with the contacts: with any other one
a damping above about 10 on light wheels throws the robot about.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


class SetPoints:
    """What actuators and joints were told; a step takes it over, so that what was read before still belongs to the last step.

    Attributes:
        targets: of each actuator of the model, in its own unit.
        efforts: of each degree of freedom, N m or N.
        changes: most that an actuator's set point may change in a step.
        pending: whether the next step has anything to take over.
    """

    __slots__ = ("changes", "efforts", "pending", "targets")

    def __init__(self, control: NDArray[np.float64], efforts: NDArray[np.float64]) -> None:
        self.targets = control.copy()
        self.efforts = efforts.copy()
        self.changes = np.full(len(control), np.inf)
        self.pending = False

    def take_over(self, control: NDArray[np.float64], efforts: NDArray[np.float64]) -> None:
        """Move the set points towards their targets, as far as they may go in a step."""
        np.clip(self.targets, control - self.changes, control + self.changes, out=control)
        efforts[:] = self.efforts
        self.pending = not np.array_equal(control, self.targets)
