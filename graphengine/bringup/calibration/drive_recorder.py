"""Drives a robot with messages on its command topic and records its motion in each tick."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graphengine.api.robots import find_robot
from graphengine.api.session import Session
from graphengine.api.topics import Publication, Subscription
from graphengine.bringup.calibration.figures import Floats, Twist
from graphengine.bringup.calibration.robot_interface import CommandTopic
from graphengine.devices.motion import Frame
from graphengine.devices.rotation import Pose, tilt_of, yaw_of

PERIOD = 0.05
"""Time between two command messages, s."""
REST = 0.25
"""Time for which the robot stands before a trace begins, s."""
FALLEN = math.radians(45.0)
"""Tilt of the base link above which the robot counts as fallen over, rad."""
BELOW = -1.0
"""Height of the base link below which the robot counts as fallen through the floor, m."""
STILL = Twist()


class FallenError(Exception):
    """The robot fell over, or fell through the floor, during a test drive."""


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A recorded motion; each array has one row per tick.

    Attributes:
        dt: time between two rows, s.
        base: true x (m), y (m) and yaw (rad, without jumps at +-pi) of the base link.
        joints: joint positions, rad or m, in the order of the articulation.
        odometry: a dict from odometry topics to the published x (m), y (m) and yaw (rad); NaN in ticks without a message.
        frames: a dict from odometry topics to the true x (m), y (m) and yaw (rad) of their child frames.
    """

    dt: float
    base: Floats
    joints: Floats
    odometry: Mapping[str, Floats]
    frames: Mapping[str, Floats]

    def part(self, begin: int, end: int | None = None) -> Trace:
        """Return the trace of the rows from `begin` to before `end`; None stands for the end of the trace."""
        odometry = {topic: rows[begin:end] for topic, rows in self.odometry.items()}
        frames = {topic: rows[begin:end] for topic, rows in self.frames.items()}
        return Trace(self.dt, self.base[begin:end], self.joints[begin:end], odometry, frames)


class DriveRecorder:
    """Drives one robot of a session and records its motion."""

    def __init__(
        self, sim: Session, robot: str, command: CommandTopic, odometry: Sequence[str], wheel_base: float | None
    ) -> None:
        self._sim = sim
        self._command = command
        self._wheel_base = wheel_base
        runner = sim._runner
        self._runner = runner
        self._prim = find_robot(runner, robot)
        self._world = runner.session.services.world
        self.articulation = self._world.articulation(self._prim)
        self.dt = runner.session.clock.delta
        self._base = self._world.frame(runner.session.services.stage.find(self._prim.facts["base_link"]))
        self._odometry: dict[str, Subscription[Any]] = {topic: sim.subscribe(topic, keep=1) for topic in odometry}
        self._newest: dict[str, bytes | None] = dict.fromkeys(odometry)
        self.child_frames: dict[str, str] = {}
        """`child_frame_id` in the first message of each odometry topic."""
        self._frames: dict[str, Frame] = {}
        self._rows: list[tuple[Any, ...]] = []
        self._since_command = math.inf

    @property
    def rows(self) -> int:
        """Number of rows since `begin`."""
        return len(self._rows)

    def begin(self) -> None:
        """Let the robot stand for `REST` s, then start a new trace with the present state as its first row."""
        self.drive(STILL, REST)
        del self._rows[:-1]

    def drive(self, twist: Twist, seconds: float) -> None:
        """Command a velocity for a time (s), rounded to whole ticks, and record the motion.

        Raises:
            FallenError: the robot fell over, or through the floor.
        """
        self._since_command = math.inf
        for _ in range(max(1, round(seconds / self.dt))):
            if self._since_command >= PERIOD - 1e-9:
                message = self._command.message(twist, self._sim.time, self._wheel_base)
                Publication(self._runner, self._command.topic, message, None, self._command.type)
                self._since_command = 0.0
            self._sim.step()
            self._since_command += self.dt
            self._record()

    def drive_until(self, twist: Twist, done: Callable[[Trace], bool], longest: float, block: float = 0.5) -> bool:
        """Command a velocity until a condition holds; return False if the condition does not hold within `longest` s.

        Args:
            twist: velocity to command.
            done: evaluates the condition for the trace of the last `2 * block` seconds.
            longest: maximum time to wait for the condition, s.
            block: time between two evaluations of the condition, s.
        """
        rows = 2 * round(block / self.dt) + 1
        for _ in range(max(2, round(longest / block))):
            self.drive(twist, block)
            if len(self._rows) >= rows and done(self.trace(rows)):
                return True
        return False

    def trace(self, last: int = 0) -> Trace:
        """Return the recorded motion since `begin()`: all rows, or only the newest `last` rows if `last` is not 0."""
        bases, joints, odometry, frames = zip(*self._rows[-last:], strict=True)
        paths = {topic: _path([row.get(topic, _NONE) for row in odometry]) for topic in self._odometry}
        poses = list(zip(frames, bases, strict=True))
        truths = {topic: _path([row.get(topic, base) for row, base in poses]) for topic in paths}
        return Trace(self.dt, _path(bases), np.array(joints).reshape(len(bases), -1), paths, truths)

    def set_points(self) -> Floats:
        """Return the target velocity of each joint's drive, rad/s or m/s; NaN for joints without a target velocity."""
        return self.articulation.set_points()[1]

    def _record(self) -> None:
        published = {}
        for topic, subscription in self._odometry.items():
            data = subscription.latest_data
            if data is not self._newest[topic]:
                self._newest[topic] = data
                published[topic] = self._pose(topic, subscription.latest)
        frames = {topic: _planar(frame.pose()) for topic, frame in self._frames.items()}
        base = self._base.pose()
        _check_upright(base)
        self._rows.append((_planar(base), self.articulation.positions(), published, frames))

    def _pose(self, topic: str, message: Any) -> tuple[float, float, float]:
        """Return x, y (m) and yaw (rad) of an odometry message.

        From the first message of a topic on, the true pose of the frame in its `child_frame_id` is recorded.
        """
        if topic not in self._frames:
            self.child_frames[topic] = message.child_frame_id
            self._frames[topic] = self._frame(message.child_frame_id)
        position, q = message.pose.pose.position, message.pose.pose.orientation
        return position.x, position.y, yaw_of((q.x, q.y, q.z, q.w))

    def _frame(self, name: str) -> Frame:
        """Return the robot's frame with this TF name, or the base link's frame if the robot has no frame of this name."""
        plain = name.rpartition("/")[2]  # the namespace of a scene with `tf: global`
        prims = (prim for prim in self._prim.descendants() if prim.kind in ("link", "frame"))
        named = [prim for prim in prims if prim.frame_name in (name, plain)]
        return self._world.frame(named[0]) if named else self._base


_NONE = (math.nan, math.nan, math.nan)


def _path(rows: Sequence[tuple[float, float, float]]) -> Floats:
    """Return rows of x, y (m) and yaw (rad) as an array; yaw is unwrapped and does not jump at +-pi."""
    path: Floats = np.array(rows, dtype=float)
    known = np.isfinite(path[:, 2])
    path[known, 2] = np.unwrap(path[known, 2])
    return path


def _planar(pose: Pose) -> tuple[float, float, float]:
    (x, y, _), orientation = pose
    return x, y, yaw_of(orientation)


def _check_upright(base: Pose) -> None:
    if base[0][2] < BELOW:
        raise FallenError("the robot falls through the floor: none of its links has a collider that rests on the floor")
    if tilt_of(base[1]) > FALLEN:
        tilt = f"its base link tilts by more than {math.degrees(FALLEN):.0f} deg"
        look = "check its centre of mass, its supports, and the acceleration limits of its controller"
        raise FallenError(f"the robot falls over: {tilt}; {look}")
