"""Drives a robot along a square with timed commands, without feedback."""

from __future__ import annotations

import math
from collections.abc import Iterable

from graphengine.bringup.calibration.drive_recorder import STILL, DriveRecorder, Trace
from graphengine.bringup.calibration.figures import Square, Twist
from graphengine.bringup.calibration.measuring import at_offset, displacement, ideal_path, in_first_frame
from graphengine.bringup.calibration.odometry_errors import OdometryMeter

SIDE = 1.0
"""Side of the square, m."""


def drive_square(
    drives: DriveRecorder,
    meters: Iterable[OdometryMeter],
    command: Twist,
    centre: tuple[float, float],
    *,
    steered: bool,
) -> Square:
    """Drive a square with timed commands; return its commanded, true and odometry paths and the errors at its end.

    Args:
        drives: recorder that drives the robot and records its motion; the robot must be at rest.
        meters: collectors of odometry errors, to which the errors of this drive are added.
        command: forward speed along the sides, and turn rate in the corners; a negative turn rate gives a clockwise square.
        centre: point whose path is measured, x and y in the base link's frame, m.
        steered: whether the corners are arcs at the speed of the sides; otherwise they are turns on the spot.
    """
    straight, corner = _segments(command, drives.dt, steered=steered)
    for _ in range(4):
        for twist, seconds in (straight, corner):
            drives.drive(twist, seconds)
            if not steered:
                _stop(drives)
    _stop(drives)
    trace = drives.trace()
    truth = in_first_frame(at_offset(trace.base, centre))
    commanded = ideal_path([straight, corner] * 4, drives.dt)
    for meter in meters:
        meter.take_square(trace)
    return Square(
        "counterclockwise" if command.yaw > 0 else "clockwise",
        SIDE,
        math.dist(truth[-1, :2], commanded[-1, :2]),
        float(truth[-1, 2] - commanded[-1, 2]),
        commanded,
        truth,
        {topic: in_first_frame(at_offset(path, centre)) for topic, path in trace.odometry.items()},
    )


def _segments(command: Twist, dt: float, *, steered: bool) -> list[tuple[Twist, float]]:
    """Return the commands of a side and of a corner, each with its duration (s), a whole number of ticks."""
    side = math.ceil(SIDE / command.x / dt) * dt
    corner = math.ceil(math.pi / 2.0 / abs(command.yaw) / dt) * dt
    speed, rate = SIDE / side, math.copysign(math.pi / 2.0 / corner, command.yaw)
    return [(Twist(x=speed), side), (Twist(x=speed if steered else 0.0, yaw=rate), corner)]


def _stop(drives: DriveRecorder) -> None:
    """Command zero velocity until the robot stands, for at most 3 s."""
    drives.drive_until(STILL, _stands, 3.0, block=0.25)


def _stands(trace: Trace) -> bool:
    """Return whether the robot stood still in the last tenth of a second."""
    x, y, turn = displacement(trace.base[-max(2, round(0.1 / trace.dt)) :])
    return math.hypot(x, y) < 1e-5 and abs(turn) < 1e-5
