"""Joint drives in SI units and their MuJoCo actuators.

A PhysX drive is a spring and damper: force = stiffness (q* - q) + damping (v* - v). Here the MuJoCo joint has this spring and
damper, and two actuators add stiffness q* and damping v*. MuJoCo's position and velocity servos would have the same force, but
MuJoCo solves implicit actuator forces by iterations over all kinematic trees, so the last bits of one robot would depend on the
others; implicit joint forces are solved tree by tree. The `discrete` integrator is required, because it solves damping together
with contacts: with other integrators, robots with light wheels and a damping above about 10 become unstable.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from graphengine.descriptions.engine import Indices, mujoco
from graphengine.devices.motion import CommandKind
from graphengine.format.robot_spec import JointSpec

DEGREES = 180 / math.pi
"""Degrees per radian, the factor that converts angular gains in USD (per degree) to gains per radian."""


KINDS: tuple[CommandKind, ...] = ("position", "velocity", "effort")


@dataclass(frozen=True, slots=True)
class Servo:
    """An actuator of a MuJoCo model; its control signal is `offset + scale * command`.

    Attributes:
        kind: kind of command: a position (rad or m), a velocity (rad/s or m/s) or an effort (N m or N).
        name: name of the actuator in its model.
        scale: factor of a command in the control signal.
        offset: control signal for the command 0.
        lowest: lowest command within the range of the control signal.
        highest: highest command within the range of the control signal.
    """

    kind: CommandKind
    name: str
    scale: float = 1.0
    offset: float = 0.0
    lowest: float = -math.inf
    highest: float = math.inf

    def control(self, command: float) -> float:
        """Return the control signal for a command."""
        return command if self.scale == 1.0 and self.offset == 0.0 else self.offset + self.scale * command


@dataclass(frozen=True, slots=True)
class Drive:
    """Gains and limits of a joint's drive in SI units: rad and N m, or m and N."""

    stiffness: float = 0.0
    damping: float = 0.0
    target_velocity: float = 0.0
    max_acceleration: float = math.inf
    """Maximum rate of change of the velocity set point, rad/s2 or m/s2."""
    max_velocity: float = math.inf
    """Maximum velocity set point, and maximum rate of change of the position set point, rad/s or m/s."""
    max_force: float = math.inf
    overtravel: float = 0.0
    """Distance by which position targets may exceed the joint's range at both ends, rad or m."""
    carries: float = 0.0
    """Inertia that the robot's mass adds about the axis of a driven wheel, divided by the robot's mass, m2; 0 for other
    joints."""
    interpolate: bool = False
    """Whether set points move to a new target during a tick and reach it at the end, instead of jumping at the beginning."""
    gravity_compensation: bool = False
    """Whether the drive carries the weight of the links beyond its joint."""
    servos: tuple[Servo, ...] | None = None
    """Actuators of the MuJoCo model, one per kind of command; None if actuators are created from the gains."""

    def servo(self, joint: str, kind: CommandKind) -> Servo | None:
        """Return the actuator of the compiled model that takes commands of the given kind; None without such an actuator.

        Args:
            joint: name of the joint in the compiled model, which begins with the robot's name.
            kind: kind of the command.
        """
        if self.servos is not None:
            found = next((servo for servo in self.servos if servo.kind == kind), None)
            return replace(found, name=f"{joint.partition('/')[0]}/{found.name}") if found is not None else None
        name = f"{joint}.{kind}"
        return Servo(kind, name) if dict(servos(joint, self)).get(name, 0.0) > 0 else None


def drive_of(joint: JointSpec, effort: float, *, prismatic: bool) -> Drive | None:
    """Return the drive of a joint in SI units; None if the joint has no drive in the robot file.

    USD has lengths and forces in SI units, so only angles are converted.

    Args:
        joint: the joint's entry in the robot file.
        effort: effort limit in the description, N m or N, infinite without one; used if the drive has no maximum force.
        prismatic: whether the joint is prismatic.
    """
    if joint.drive is not None:
        return Drive(**{"max_force": effort} | joint.drive.model_dump(exclude_none=True))
    if joint.usd_drive is not None:
        usd, factor = joint.usd_drive, 1.0 if prismatic else DEGREES
        velocity, most = usd.target_velocity / factor, usd.max_force or effort
        gains = usd.stiffness * factor, usd.damping * factor
        return Drive(*gains, velocity, max_force=most, overtravel=usd.overtravel / factor)
    return None


def in_si(drive: Drive) -> str:
    """Return the gains and target velocity of a rotary joint's drive in SI units, as text for a message."""
    parts = {
        "damping": (drive.damping, "N m s/rad"),
        "stiffness": (drive.stiffness, "N m/rad"),
        "target velocity": (drive.target_velocity, "rad/s"),
    }
    return ", ".join(f"{name} {value:g} {unit}" for name, (value, unit) in parts.items() if value) or "no force"


def servos(joint: str, drive: Drive) -> tuple[tuple[str, float], tuple[str, float]]:
    """Return (name, gain) of a joint's position actuator, then of its velocity actuator; actuators with gain 0 do not exist."""
    return (f"{joint}.position", drive.stiffness), (f"{joint}.velocity", drive.damping)


def servo_ids(model: mujoco.MjModel, drives: Iterable[tuple[str, Drive]]) -> Indices:
    """Return the actuator ids of joints, shape (3, number of joints); -1 where a joint has no such actuator.

    The rows are the position, velocity and effort actuators.
    """
    found = [[drive.servo(joint, kind) for kind in KINDS] for joint, drive in drives]
    ids = [[model.actuator(servo.name).id if servo is not None else -1 for servo in row] for row in found]
    return np.array(ids, np.intp).reshape(-1, 3).T.copy()
