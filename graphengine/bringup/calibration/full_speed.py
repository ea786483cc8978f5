"""Test drives at the limits of a robot's controller: arcs, a stop from full speed, and a slope."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from graphengine.api.scene import Scene
from graphengine.bringup.calibration.drive_recorder import STILL, DriveRecorder, Trace
from graphengine.bringup.calibration.figures import Stop, Twist
from graphengine.bringup.calibration.measuring import displacement, is_steady, mean_velocity
from graphengine.bringup.calibration.robot_interface import ACKERMANN, limit_of
from graphengine.bringup.robots.skid_steering import GRAVITY, HELD
from graphengine.devices.rotation import Vector3
from graphengine.physics.model.robot import RobotInstance

SLOW = 0.3
"""Speed and turn rate of the slow arcs, as a share of the limits."""
SLOPE = math.radians(5.0)
"""Angle of the slope, rad."""
_STEEPEST = 0.15
"""Largest acceleration towards the centre of a car's arc at its full speed, as a share of gravity."""
_PARKED, _LONGEST = 2.0, 15.0
"""Time for which a parked robot is watched, and maximum time to reach or leave full speed, s."""


def rim_speed(scene: Scene) -> float:
    """Return the largest rim speed of the wheels that a robot's controllers allow, m/s; infinite without a limit."""
    radius = limit_of(scene, "wheelRadius", "backWheelRadius")
    return limit_of(scene, "maxWheelSpeed", "maxWheelVelocity") * radius


def limits_of(scene: Scene, turn: float = math.inf) -> tuple[float, float]:
    """Return the speed (m/s) and turn rate (rad/s) that a robot's controllers allow at the same time; infinite without limits.

    Speed and turn rate are scaled down, as in graphs of bases, if the wheels cannot reach both.

    Args:
        scene: scene with the robot.
        turn: additional limit of the turn rate, rad/s.
    """
    rim = rim_speed(scene)
    speed, turn = min(limit_of(scene, "maxLinearSpeed"), rim), min(turn, limit_of(scene, "maxAngularSpeed"))
    distances = [limit_of(scene, name) for name in ("wheelDistance", "wheelBase")]
    lever = sum(each for each in distances if each < math.inf) / 2
    fast = speed + turn * lever
    share = rim / fast if rim < fast < math.inf else 1.0
    return share * speed, share * turn


def slow_arc(robot: RobotInstance, speed: float, turn: float) -> tuple[float, float]:
    """Return the speed (m/s) and turn rate (rad/s) of the slow arcs: 0.3 of the limits.

    A skid-steered base drives slower if these limits need more than 0.15 of the grip across its wheels, because its track suits
    slower arcs.

    Args:
        robot: robot with the materials of its wheels.
        speed: limit of the speed, m/s.
        turn: limit of the turn rate, rad/s.
    """
    grips = [each.across for each in robot.spec.materials.values() if each.steady_sliding and each.across is not None]
    share = SLOW
    if grips and speed * turn < math.inf:
        share *= math.sqrt(min(1.0, HELD * min(grips) * GRAVITY / (speed * turn)))
    return share * speed, share * turn


def arcs(
    scene: Scene, robot: RobotInstance, command_type: str, radius: float, *, steered: bool
) -> Iterator[tuple[str, Twist]]:
    """Yield the names and commands of the arcs at 0.3 and 1.0 of the limits; nothing if speed or turn rate has no limit.

    Args:
        scene: scene with the robot.
        robot: the robot.
        command_type: message type of the command topic.
        radius: smallest radius of a car's test arcs, m.
        steered: whether the robot turns only in arcs.
    """
    speed, turn = limits_of(scene)
    if steered or command_type == ACKERMANN:
        turn = min(turn, speed / radius, _STEEPEST * GRAVITY / speed)
    if not max(speed, turn) < math.inf:
        return
    for name, (v, w) in {"slow": slow_arc(robot, speed, turn), "full": (speed, turn)}.items():
        for side, sign in (("left", 1.0), ("right", -1.0)):
            yield f"{name}_arc_{side}", Twist(x=v, yaw=sign * w)


def tilted(direction: Vector3) -> Vector3:
    """Return gravity on a slope of the angle `SLOPE` that falls in a horizontal direction, m/s2."""
    x, y, _ = direction
    return GRAVITY * math.sin(SLOPE) * x, GRAVITY * math.sin(SLOPE) * y, -GRAVITY * math.cos(SLOPE)


def stop(drives: DriveRecorder, scene: Scene, speed: float) -> Stop:
    """Drive straight at full speed, stop, and return the distance until the robot stands.

    Args:
        drives: recorder that drives the robot.
        scene: scene with the robot.
        speed: speed to drive if the robot's controllers do not limit it, m/s.
    """
    limit, _ = limits_of(scene)
    speed = limit if limit < math.inf else speed
    drives.drive_until(Twist(x=speed), lambda trace: is_steady(trace, Twist(x=speed)), _LONGEST)
    reached = mean_velocity(drives.trace(round(0.5 / drives.dt))).x
    begin = drives.rows - 1
    drives.drive_until(STILL, _stands, _LONGEST, block=0.25)
    x, y, _ = displacement(drives.trace().part(begin).base)
    slowing = limit_of(scene, "maxDeceleration")
    return Stop(reached, math.hypot(x, y), slowing if slowing < math.inf else None)


def _stands(trace: Trace) -> bool:
    """Return whether the robot moved by less than 0.1 mm in each tick."""
    return bool(np.abs(np.diff(trace.base[:, :2], axis=0)).max() < 1e-4)


def creep(drives: DriveRecorder) -> float:
    """Let the robot stand on the slope for a while and return its speed, m/s."""
    drives.drive(STILL, 1.0)
    begin = drives.rows - 1
    drives.drive(STILL, _PARKED)
    x, y, _ = displacement(drives.trace().part(begin).base)
    return math.hypot(x, y) / _PARKED
