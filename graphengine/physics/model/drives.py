"""Joint drives in SI units, and the MuJoCo servos that stand for them.

PhysX's drive is one spring and damper: force = stiffness (q* - q) + damping (v* - v). In MuJoCo the joint itself is that spring
and damper, and two actuators push it by stiffness q* and damping v*. MuJoCo's own servos would be the same, but it solves what is
implicit in an actuator by iterations over all trees of bodies, after which the last bits of each robot depend on the others; what
is implicit in a joint it solves tree by tree. All this needs the `discrete` integrator, which solves damping together with the
contacts: with any other one a damping above about 10 on light wheels throws the robot about.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from graphengine.format.robot_spec import JointSpec
from graphengine.physics.engine import Indices, mujoco

DEGREES = 180 / math.pi
"""Degrees in a radian: USD stores angular drives per degree, which PhysX multiplies by this."""


Kind = Literal["position", "velocity", "effort"]
"""Kind of a command."""
KINDS: tuple[Kind, ...] = ("position", "velocity", "effort")


@dataclass(frozen=True, slots=True)
class Servo:
    """An actuator of a MuJoCo model, and how a command becomes its control signal: `offset + scale * command`.

    Attributes:
        kind: of the commands that it takes, in rad, rad/s, N m, or m, m/s, N.
        name: of the actuator in its model.
        lowest: least command within the range of the control signal.
        highest: greatest one.
    """

    kind: Kind
    name: str
    scale: float = 1.0
    offset: float = 0.0
    lowest: float = -math.inf
    highest: float = math.inf

    def control(self, command: float) -> float:
        """Return the control signal that stands for a command."""
        return command if self.scale == 1.0 and self.offset == 0.0 else self.offset + self.scale * command


@dataclass(frozen=True, slots=True)
class Drive:
    """Gains and limits of a joint's drive; rad or m, N m or N."""

    stiffness: float = 0.0
    damping: float = 0.0
    target_velocity: float = 0.0
    max_acceleration: float = math.inf
    """Limit on the slope of the velocity set point."""
    max_velocity: float = math.inf
    """Limit of the velocity set point, and on the slope of the position set point."""
    max_force: float = math.inf
    carries: float = 0.0
    """What a wheel moves of the mass of its robot, by its radius: inertia over mass, m²."""
    interpolate: bool = False
    """Whether set points reach a new target at the end of a tick, not at its beginning."""
    gravity_compensation: bool = False
    """Whether the drive carries the weight of the links beyond its joint."""
    servos: tuple[Servo, ...] | None = None
    """The model's own actuators, one for each kind of command; None: this module's actuators, made of the gains."""

    def servo(self, joint: str, kind: Kind) -> Servo | None:
        """Return the actuator of the compiled model that takes commands of a kind, or None.

        Args:
            joint: name of the joint in the compiled model, which begins with that of the robot.
            kind: of the command.
        """
        if self.servos is not None:
            found = next((servo for servo in self.servos if servo.kind == kind), None)
            return replace(found, name=f"{joint.partition('/')[0]}/{found.name}") if found is not None else None
        name = f"{joint}.{kind}"
        return Servo(kind, name) if dict(servos(joint, self)).get(name, 0.0) > 0 else None


def drive_of(joint: JointSpec, effort: float, *, prismatic: bool) -> Drive | None:
    """Return the drive of a joint in SI units, or None. Lengths and forces in USD are SI, so only angles are converted.

    Args:
        joint: what the robot file says.
        effort: the description's limit, N m or N, for a drive that has no maximum force of its own.
        prismatic: whether the joint slides.
    """
    if joint.drive is not None:
        drive = joint.drive
        limits = drive.max_acceleration or math.inf, drive.max_velocity or math.inf, drive.max_force or effort
        return Drive(
            drive.stiffness,
            drive.damping,
            drive.target_velocity,
            *limits,
            interpolate=drive.interpolate,
            gravity_compensation=drive.gravity_compensation,
        )
    if joint.usd_drive is not None:
        usd, factor = joint.usd_drive, 1.0 if prismatic else DEGREES
        velocity, most = usd.target_velocity / factor, usd.max_force or effort
        return Drive(usd.stiffness * factor, usd.damping * factor, velocity, max_force=most)
    return None


def in_si(drive: Drive) -> str:
    """Return the parameters of a rotary joint's drive in SI units, as text."""
    parts = {
        "damping": (drive.damping, "N m s/rad"),
        "stiffness": (drive.stiffness, "N m/rad"),
        "target velocity": (drive.target_velocity, "rad/s"),
    }
    return ", ".join(f"{name} {value:g} {unit}" for name, (value, unit) in parts.items() if value) or "no force"


def servos(joint: str, drive: Drive) -> tuple[tuple[str, float], tuple[str, float]]:
    """Return name and gain of the actuators that push a joint to its target position and velocity."""
    return (f"{joint}.position", drive.stiffness), (f"{joint}.velocity", drive.damping)


def servo_ids(model: mujoco.MjModel, drives: Iterable[tuple[str, Drive]]) -> Indices:
    """Return ids of the joints' actuators for positions, velocities and efforts, shape (3, joints); -1 where there is none."""
    found = [[drive.servo(joint, kind) for kind in KINDS] for joint, drive in drives]
    ids = [[model.actuator(servo.name).id if servo is not None else -1 for servo in row] for row in found]
    return np.array(ids, np.intp).reshape(-1, 3).T.copy()
