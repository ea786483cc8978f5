"""Samples the true pose of a robot from the run that simulates the robot."""

from __future__ import annotations

import bisect
import itertools
import math
import threading
import time
from typing import Any, NamedTuple

from graphengine.api.remote_robot import RemoteRobot
from graphengine.devices.rotation import yaw_of
from graphengine.format.errors import ControlError

MAP = "map"
"""TF frame of the map, in which Nav2 takes goals and poses."""
PERIOD = 0.05
"""Wall time between two samples, s."""
PATIENCE = 30.0
"""Maximum wall time to wait for an answer of the run, s; a suspended or hanging process does not answer."""
MARGIN = 0.05
"""Maximum distance of a reported obstacle from the robot at a goal, m: the side of a cell of the map."""
MAX_SAMPLES = 500_000
"""Maximum number of samples; beyond it, the oldest half is discarded."""


class PlanarPose(NamedTuple):
    """Position in m and yaw in rad, in the world of the scene or in the map."""

    x: float
    y: float
    yaw: float

    @classmethod
    def of(cls, pose: Any) -> PlanarPose:
        """Return the planar part of a geometry_msgs/Pose."""
        q = pose.orientation
        return cls(pose.position.x, pose.position.y, yaw_of((q.x, q.y, q.z, q.w)))

    def put_into(self, pose: Any) -> None:
        """Set a geometry_msgs/Pose, in which z, roll and pitch are 0, to this pose."""
        pose.position.x, pose.position.y = self.x, self.y
        pose.orientation.z, pose.orientation.w = math.sin(self.yaw / 2.0), math.cos(self.yaw / 2.0)

    def distance(self, other: PlanarPose) -> float:
        """Return the distance between the two positions, m."""
        return math.hypot(self.x - other.x, self.y - other.y)

    def turn(self, other: PlanarPose) -> float:
        """Return the absolute difference of the two yaws, 0 to pi rad."""
        return abs(math.remainder(self.yaw - other.yaw, math.tau))


class TruePoses:
    """Samples the pose of a robot in a thread until `close`.

    Args:
        run: name or process id of the run; empty for the only run with a robot in the namespace.
        namespace: namespace of the robot.

    Raises:
        ControlError: no run has the name or process id, or the run has no robot in the namespace.
        UsageError: `run` is empty, and several runs are possible.
    """

    def __init__(self, run: str, namespace: str) -> None:
        self.ended = ""
        """Reason why sampling has ended; empty while sampling continues."""
        self.paused = False
        self._times: list[float] = []
        self._poses: list[PlanarPose] = []
        self._lock = threading.Lock()
        self._closed = threading.Event()
        self._robot = RemoteRobot(run, namespace, PATIENCE)
        self.entry = self._robot.entry
        """The entry of the run in the list of running sessions."""
        try:
            self._sample()
        except BaseException:
            self._robot.close()
            raise
        self._thread = threading.Thread(target=self._follow, name="true poses", daemon=True)
        self._thread.start()

    @property
    def time(self) -> float:
        """Simulation time of the newest sample, s."""
        with self._lock:
            return self._times[-1]

    @property
    def newest(self) -> PlanarPose:
        """The newest sampled pose."""
        with self._lock:
            return self._poses[-1]

    def at(self, moment: float) -> PlanarPose | None:
        """Return the pose at a simulation time, interpolated between two samples; None before the first and after the last."""
        with self._lock:
            times, poses = self._times, self._poses
            after = bisect.bisect_left(times, moment)
            if after == len(times):
                return None
            if times[after] == moment:
                return poses[after]
            if after == 0:
                return None
            start, end = poses[after - 1], poses[after]
            part = (moment - times[after - 1]) / (times[after] - times[after - 1])
            turn = math.remainder(end.yaw - start.yaw, math.tau)
            x, y = start.x + part * (end.x - start.x), start.y + part * (end.y - start.y)
            return PlanarPose(x, y, start.yaw + part * turn)

    def wait_until(self, moment: float) -> None:
        """Wait until there is a sample at or after a simulation time, but at most 1 s of wall time."""
        deadline = time.monotonic() + 1.0
        while self.time < moment and not self.ended and time.monotonic() < deadline:
            time.sleep(PERIOD / 2)

    def way(self, start: float, end: float) -> float:
        """Return the length of the robot's path between two simulation times, m."""
        with self._lock:
            first, last = bisect.bisect_left(self._times, start), bisect.bisect_right(self._times, end)
            poses = self._poses[first:last]
        return sum((one.distance(other) for one, other in itertools.pairwise(poses)), 0.0)

    def near(self, x: float, y: float) -> list[str]:
        """Return a sentence for each obstacle within reach of the robot at a position, in any heading of the robot."""
        try:
            found = self._robot.clearance((x, y), MARGIN)
        except ControlError:  # the run ends, or is of a version without this command
            return []
        gaps = [(name, f"{gap:.2f} m from the robot" if gap > 0.0 else "") for name, gap in found.items()]
        return [f"{name} stands {gap or 'where the robot turns'}" for name, gap in gaps]

    def close(self) -> None:
        """Stop sampling and end the thread; the samples remain readable."""
        self._closed.set()
        self._robot.interrupt()  # the run may never answer
        self._thread.join()
        self._robot.close()

    def _follow(self) -> None:
        while not self._closed.wait(PERIOD):
            try:
                self._sample()
            except ControlError as error:
                self.ended = str(error)
                return
            except Exception as error:  # without `ended`, the navigator would wait for samples
                self.ended = f"{self.entry} sent an answer that cannot be used ({type(error).__name__}: {error})"
                return

    def _sample(self) -> None:
        state = self._robot.state()
        (x, y, _), now = state.position, state.time
        pose = PlanarPose(x, y, yaw_of(state.orientation))
        self.paused = state.paused
        with self._lock:
            if self._times and now < self._times[-1]:  # a reset
                self._times.clear()
                self._poses.clear()
            if self._times and now == self._times[-1]:
                self._poses[-1] = pose
                return
            self._times.append(now)
            self._poses.append(pose)
            if len(self._times) > MAX_SAMPLES:
                del self._times[: MAX_SAMPLES // 2], self._poses[: MAX_SAMPLES // 2]
