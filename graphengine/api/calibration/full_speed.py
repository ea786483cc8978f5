"""Test drives at the limits of a robot's controller: arcs, a stop from full speed, and a slope."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from graphengine.api.calibration.drive_recorder import STILL, DriveRecorder, Trace
from graphengine.api.calibration.figures import Stop, Twist
from graphengine.api.calibration.measuring import displacement, is_steady, mean_velocity
from graphengine.api.calibration.robot_interface import ACKERMANN, limit_of
from graphengine.devices.rotation import Vector3
from graphengine.scene.loaded_scene import LoadedScene

SHARES = {"slow": 0.3, "full": 1.0}
"""Shares of the limits at which the arcs are driven, by the first part of a motion's name."""
SLOPE = math.radians(5.0)
"""Angle of the slope, rad."""
_GRAVITY = 9.81
_STEEPEST = 0.15
"""Largest acceleration towards the centre of a car's arc at its full speed, as a share of gravity."""
_PARKED, _LONGEST = 2.0, 15.0
"""Time for which a parked robot is watched, and maximum time to reach or leave full speed, s."""


def limits_of(scene: LoadedScene) -> tuple[float, float]:
    """Return the speed (m/s) and turn rate (rad/s) that a robot's controllers allow at the same time; infinite without limits.

    Where the wheels cannot reach both, both are scaled down, as graphs of bases do.
    """
    radius = limit_of(scene, "wheelRadius", "backWheelRadius")
    rim = limit_of(scene, "maxWheelSpeed", "maxWheelVelocity") * radius
    speed, turn = min(limit_of(scene, "maxLinearSpeed"), rim), limit_of(scene, "maxAngularSpeed")
    lever = (
        sum(each for each in (limit_of(scene, name) for name in ("wheelDistance", "wheelBase")) if each < math.inf) / 2
    )
    fast = speed + turn * lever
    share = rim / fast if rim < fast < math.inf else 1.0
    return share * speed, share * turn


def arcs(scene: LoadedScene, command_type: str, radius: float, *, steered: bool) -> Iterator[tuple[str, Twist]]:
    """Yield the names and commands of the arcs at the shares `SHARES` of the limits; none if the speed has no limit.

    Args:
        scene: scene with the robot.
        command_type: message type of the command topic.
        radius: smallest radius of a car's test arcs, m.
        steered: whether the robot turns only in arcs.
    """
    speed, turn = limits_of(scene)
    if steered or command_type == ACKERMANN:
        turn = min(turn, speed / radius, _STEEPEST * _GRAVITY / speed)
    if not max(speed, turn) < math.inf:
        return
    for name, share in SHARES.items():
        for side, sign in (("left", 1.0), ("right", -1.0)):
            yield f"{name}_arc_{side}", Twist(x=share * speed, yaw=sign * share * turn)


def tilted(direction: Vector3) -> Vector3:
    """Return gravity on a slope of `SLOPE` that falls in a horizontal direction, m/s2."""
    x, y, _ = direction
    return _GRAVITY * math.sin(SLOPE) * x, _GRAVITY * math.sin(SLOPE) * y, -_GRAVITY * math.cos(SLOPE)


def stop(drives: DriveRecorder, scene: LoadedScene, speed: float) -> Stop:
    """Drive straight at full speed, stop, and return the distance until the robot stands.

    Args:
        drives: recorder that drives the robot.
        scene: scene with the robot.
        speed: speed to drive if the robot's controllers do not limit it, m/s.
    """
    limit, _ = limits_of(scene)
    speed = limit if limit < math.inf else speed
    drives.drive_until(Twist(x=speed), lambda trace: is_steady(trace, 0, speed), _LONGEST)
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
