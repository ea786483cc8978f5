"""Limits for joint commands, so that a message from the network cannot make a simulation diverge.

- Efforts: the limit in the robot's description. If it gives none, the smaller of two efforts: the effort that lifts the robot
  with a lever arm of 1 m, and the effort that accelerates the joint's own inertia by 1e5 rad/s2 (prismatic joints: 1e5 m/s2).
- Velocities: 17453 rad/s (1e6 deg/s, as in Isaac Sim; prismatic joints: 17453 m/s). Wheels: 100 rad/s, the default of PhysX,
  because faster wheels make a robot diverge. If a drive's maximum velocity is lower, it applies instead.
- Positions: the joint's range, extended on both sides by the drive's `overtravel`, with which a gripper presses against a limit.
- Actuators of MuJoCo models: the range of the control signal, if the actuator has one, instead of the limits above.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from graphengine.devices.stage import Prim
from graphengine.physics.engine import mujoco
from graphengine.physics.model.drives import KINDS, Drive, Kind, Servo

GRAVITY, ARM = 9.81, 1.0
ACCELERATION = 1e5
FASTEST = math.radians(1e6)
FASTEST_WHEEL = 100.0
"""Highest velocity command of a wheel, rad/s; if `max_velocity` of the drive is lower, it is the limit instead."""


def command_limits(model: mujoco.MjModel, robot: Prim, joints: Sequence[int]) -> dict[Kind, list[tuple[float, float]]]:
    """Return the lowest and highest legal command of each joint of a robot, in lists by the kind of command.

    Args:
        model: compiled model.
        robot: prim of the robot.
        joints: ids of the robot's moving joints in the model, in the articulation's order.
    """
    joints_by_name = {prim.facts["joint"]: prim.facts for prim in robot.descendants() if prim.kind == "joint"}
    wheels = robot.facts.get("wheel_radii", {})
    found: dict[Kind, list[tuple[float, float]]] = {"position": [], "velocity": [], "effort": []}
    for name, joint in zip(robot.facts["joints"], joints, strict=True):
        effort, drive = joints_by_name[name].get("effort"), joints_by_name[name].get("drive")
        fastest = FASTEST_WHEEL if name in wheels else FASTEST
        if drive is not None:
            fastest = min(fastest, drive.max_velocity)
        mass = float(model.body_subtreemass[model.body_rootid[model.jnt_bodyid[joint]]])
        inertia = float(model.dof_M0[model.jnt_dofadr[joint]])
        strongest = effort or min(mass * GRAVITY * ARM, ACCELERATION * inertia)
        lowest, highest = model.jnt_range[joint].tolist() if model.jnt_limited[joint] else (-math.inf, math.inf)
        overtravel = drive.overtravel if drive is not None else 0.0
        found["position"].append((lowest - overtravel, highest + overtravel))
        found["velocity"].append((-fastest, fastest))
        found["effort"].append((-strongest, strongest))
        for servo in (drive.servos or ()) if drive is not None else ():
            found[servo.kind][-1] = _within(servo, *found[servo.kind][-1])
    return found


def add_limits(limits: dict[Kind, list[tuple[float, float]]], drive: Drive) -> None:
    """Append the limits of an actuator that does not move exactly one joint to the list of each kind of command."""
    for kind in KINDS:
        servo = next((servo for servo in drive.servos or () if servo.kind == kind), None)
        limits[kind].append(_within(servo, -math.inf, math.inf) if servo is not None else (-math.inf, math.inf))


def _within(servo: Servo, lowest: float, highest: float) -> tuple[float, float]:
    """Return the lowest and highest command of an actuator: its own limits, or the given ones if it has none."""
    return servo.lowest if servo.lowest > -math.inf else lowest, servo.highest if servo.highest < math.inf else highest
