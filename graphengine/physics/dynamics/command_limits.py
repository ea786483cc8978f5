"""Limits for joint commands. They prevent a message from the network from making a simulation diverge.

- Efforts: the limit in the robot's description. If it gives none, the smaller of two efforts: the effort that lifts the robot
  with a lever arm of 1 m, and the effort that accelerates the joint's own inertia by 1e5 rad/s2 (prismatic joints: 1e5 m/s2).
- Velocities: 17453 rad/s (1e6 deg/s, as in Isaac Sim; prismatic joints: 17453 m/s). Wheels: 100 rad/s, the default of PhysX,
  because faster wheels make a robot diverge. If a drive's maximum velocity is lower, it applies instead.
- Positions: the joint's range, extended on both sides by the drive's `overtravel`, with which a gripper presses against a limit.
- Actuators of MuJoCo models: the range of the control signal, if the actuator has one, instead of the limits above.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from graphengine.descriptions.actuators.drives import KINDS, Drive
from graphengine.descriptions.engine import mujoco
from graphengine.devices.motion import CommandKind
from graphengine.devices.stage import Prim

GRAVITY, ARM = 9.81, 1.0
ACCELERATION = 1e5
FASTEST = math.radians(1e6)
FASTEST_WHEEL = 100.0
"""Highest velocity command of a wheel, rad/s; if `max_velocity` of the drive is lower, it is the limit instead."""


Limits = dict[CommandKind, list[tuple[float, float]]]
"""A dict from the command kind to a list with the lowest and highest legal command of each joint."""
_NO_LIMITS: Mapping[CommandKind, tuple[float, float]] = dict.fromkeys(KINDS, (-math.inf, math.inf))


def command_limits(model: mujoco.MjModel, robot: Prim, joints: Sequence[int]) -> Limits:
    """Return the lowest and highest legal command of each joint of a robot.

    Args:
        model: compiled model.
        robot: prim of the robot.
        joints: ids of the robot's moving joints in the model, in the articulation's order.
    """
    joints_by_name = {prim.facts["joint"]: prim.facts for prim in robot.descendants() if prim.kind == "joint"}
    wheels = robot.facts.get("wheel_radii", {})
    found: Limits = {kind: [] for kind in KINDS}
    for name, joint in zip(robot.facts["joints"], joints, strict=True):
        effort, drive = joints_by_name[name].get("effort"), joints_by_name[name].get("drive") or Drive()
        fastest = min(FASTEST_WHEEL if name in wheels else FASTEST, drive.max_velocity)
        mass = float(model.body_subtreemass[model.body_rootid[model.jnt_bodyid[joint]]])
        inertia = float(model.dof_M0[model.jnt_dofadr[joint]])
        strongest = effort or min(mass * GRAVITY * ARM, ACCELERATION * inertia)
        lowest, highest = model.jnt_range[joint].tolist() if model.jnt_limited[joint] else (-math.inf, math.inf)
        ranges = (lowest - drive.overtravel, highest + drive.overtravel), (-fastest, fastest), (-strongest, strongest)
        add_limits(found, drive, dict(zip(KINDS, ranges, strict=True)))
    return found


def add_limits(limits: Limits, drive: Drive, usual: Mapping[CommandKind, tuple[float, float]] = _NO_LIMITS) -> None:
    """Append the limits of a drive for each command kind: the limits of the drive's actuator, or the usual limits without one."""
    for kind, (lowest, highest) in usual.items():
        servo = next((servo for servo in drive.servos or () if servo.kind == kind), None)
        if servo is not None:
            lowest = servo.lowest if servo.lowest > -math.inf else lowest
            highest = servo.highest if servo.highest < math.inf else highest
        limits[kind].append((lowest, highest))
