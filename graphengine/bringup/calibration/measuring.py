"""Computes velocities, drifts, paths and the turning centre from recorded motions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from graphengine.bringup.calibration.drive_recorder import Trace
from graphengine.bringup.calibration.figures import Floats, Motion, Twist

SETTLED = 0.05
"""Largest relative deviation from the final velocity at which a velocity counts as settled."""
LEAST = 0.05
"""Smallest ratio of measured to commanded velocity at which a robot counts as moving."""
SMOOTHING = 0.1
"""Time over which velocities are averaged to find the settle time, s."""


def increments(path: Floats) -> Floats:
    """Return the motion between successive rows in the frame of the moving body: forward and left (m), and turn (rad)."""
    steps = np.diff(path, axis=0)
    return _turned(steps, -(path[:-1, 2] + steps[:, 2] / 2.0))


def _turned(poses: Floats, yaw: Floats | float) -> Floats:
    """Rotate the positions of poses about the origin by a yaw, rad; the yaws of the poses do not change.

    Poses have x, y (m) and yaw (rad) along the last axis.
    """
    x, y, turn = poses.T
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return np.stack((cosine * x - sine * y, sine * x + cosine * y, turn), axis=-1)


def displacement(path: Floats) -> Floats:
    """Return the last pose of a path in the frame of the first pose: x, y (m) and yaw (rad)."""
    return _turned(path[-1] - path[0], -path[0, 2])


def mean_velocity(trace: Trace) -> Twist:
    """Return the mean velocity of the base link in the base link's frame."""
    x, y, yaw = (increments(trace.base).sum(axis=0) / ((len(trace.base) - 1) * trace.dt)).tolist()
    return Twist(x, y, yaw)


def is_steady(trace: Trace, command: Twist) -> bool:
    """Return whether the mean velocities of both halves of a motion differ by at most 0.2 % of each commanded component."""
    first, second = (half.mean(0) for half in np.array_split(increments(trace.base) / trace.dt, 2))
    wanted = np.abs([command.x, command.y, command.yaw])
    return bool((np.abs(second - first) <= 0.002 * wanted)[wanted > 0.0].all())


def settle_time(trace: Trace, component: int, reached: float) -> float | None:
    """Return the time from which on the relative deviation from `reached` is at most `SETTLED`, s; None without this time."""
    count = max(1, round(SMOOTHING / trace.dt))
    velocity = np.convolve(increments(trace.base)[:, component], np.full(count, 1.0 / count), "full") / trace.dt
    velocity = velocity[: len(trace.base) - 1]
    outside = np.flatnonzero(np.abs(velocity - reached) > SETTLED * abs(reached))
    last = int(outside[-1]) + 1 if len(outside) else 0
    return last * trace.dt if last < len(velocity) - count else None


def one_turn(path: Floats) -> Floats | None:
    """Return the displacement (x, y, in m) over the first full turn of a path; None if the path has no full turn."""
    turned = np.abs(path[:, 2] - path[0, 2])
    if turned[-1] < math.tau:
        return None
    after = int(np.argmax(turned >= math.tau))
    share = (math.tau - turned[after - 1]) / (turned[after] - turned[after - 1])
    position = path[after - 1, :2] + share * (path[after, :2] - path[after - 1, :2])
    return np.asarray(position - path[0, :2])


def pieces(truth: Floats, odometry: Floats, distance: float, angle: float) -> Iterator[tuple[Floats, Floats]]:
    """Split a path into steps, and yield the true motion and the odometry error of each step, as x, y (m) and yaw (rad).

    A step ends when the robot has moved by `distance` (m) or turned by `angle` (rad).
    """
    begin = 0
    for row in range(1, len(truth)):
        moved = math.dist(truth[row, :2], truth[begin, :2])
        if moved >= distance or abs(truth[row, 2] - truth[begin, 2]) >= angle:
            true = displacement(truth[begin : row + 1])
            yield true, displacement(odometry[begin : row + 1]) - true
            begin = row


def mean_square(values: Sequence[float]) -> float | None:
    """Return the mean of the squares of the values; None without values."""
    return float(np.mean(np.square(values))) if values else None


def mean(values: Sequence[float]) -> float | None:
    """Return the mean of the values; None without values."""
    return float(np.mean(values)) if values else None


def largest(values: Sequence[float]) -> float | None:
    """Return the largest absolute value; None without values."""
    return float(np.max(np.abs(values))) if values else None


def ideal_path(segments: Sequence[tuple[Twist, float]], dt: float) -> Floats:
    """Return the path (rows of x, y, yaw) of an ideal robot along segments, each with a velocity and a duration (s)."""
    rows = [(0.0, 0.0, 0.0)]
    for twist, seconds in segments:
        count = max(1, round(seconds / dt))
        step = seconds / count
        for _ in range(count):
            x, y, yaw = rows[-1]
            middle = yaw + twist.yaw * step / 2.0
            ahead, aside, turn = _turned(np.array([twist.x, twist.y, twist.yaw]), middle)
            rows.append((x + step * ahead, y + step * aside, yaw + step * turn))
    return np.array(rows)


def at_offset(path: Floats, offset: tuple[float, float]) -> Floats:
    """Return the path of a point fixed to the moving body; `offset` is its position (x, y) in the body frame, m."""
    return path + _turned(np.broadcast_to([*offset, 0.0], path.shape), path[:, 2])


def in_first_frame(path: Floats) -> Floats:
    """Return a path in the frame of its first known pose; rows with NaN are left out."""
    known = path[np.isfinite(path).all(axis=1)]
    if not len(known):
        return np.zeros((0, 3))
    return _turned(known - known[0], -known[0, 2])


def share(twist: Twist, reached: Twist) -> float:
    """Return the ratio of the measured to the commanded velocity.

    Return the ratio of the turn rates if a turn rate is commanded; else the ratio of the forward or of the sideways velocities.
    """
    if twist.yaw:
        return reached.yaw / twist.yaw
    return reached.x / twist.x if twist.x else reached.y / twist.y


def with_drift(motion: Motion, window: Trace) -> Motion:
    """Return a copy of the motion with its drifts in the trace `window`; they are None if the robot hardly moved."""
    if motion.kind == "turn":
        moved = one_turn(window.base) if not motion.commanded.x else None
        return replace(motion, position_drift=math.hypot(*moved) if moved is not None else None)
    forward, left, turn = increments(window.base).sum(axis=0).tolist()
    along, across = (forward, left) if motion.kind == "straight" else (left, -forward)
    if abs(along) < 0.01:
        return motion
    return replace(motion, lateral_drift=across / abs(along), heading_drift=turn / abs(along))


def turning_centre(motions: Sequence[Motion]) -> tuple[float, float] | None:
    """Return the point (x, y) about which the robot turns on the spot, in the base link's frame, m; None without turns."""
    turns = [one for one in motions if one.kind == "turn" and not one.commanded.x and abs(one.share) >= LEAST]
    if not turns:
        return None
    x = sum(-one.reached.y / one.reached.yaw for one in turns) / len(turns)
    return x, sum(one.reached.x / one.reached.yaw for one in turns) / len(turns)
