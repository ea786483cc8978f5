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
from dataclasses import dataclass

import numpy as np

from graphengine.format.robot_spec import JointSpec
from graphengine.physics.engine import Indices, mujoco

DEGREES = 180 / math.pi
"""Degrees in a radian: USD stores angular drives per degree, which PhysX multiplies by this."""


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
        habits = {"interpolate": drive.interpolate, "gravity_compensation": drive.gravity_compensation}
        return Drive(drive.stiffness, drive.damping, drive.target_velocity, *limits, **habits)
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
    """Return ids of the joints' position and velocity servos, shape (2, joints); -1 for a gain of zero, which has no servo."""
    found = [[model.actuator(servo).id if gain > 0 else -1 for servo, gain in servos(*drive)] for drive in drives]
    return np.array(found, np.intp).reshape(-1, 2).T.copy()
