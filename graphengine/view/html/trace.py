"""Samples a run for the page: poses of bodies, scans of lidars and speeds of robots."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.lidar import Lidar
from graphengine.devices.rotation import compose
from graphengine.devices.visible import Bodies
from graphengine.view.layer_data import Mount
from graphengine.view.layers import mount_of
from graphengine.view.live_robots import states_of

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

RATE = 30.0
"""Samples of poses per second of simulation."""
SCAN_PERIOD = 0.2
"""Minimum simulation time between two stored scans of a lidar, s."""
MAX_BEAMS = 4000
"""Maximum number of stored beams of all lidars per `SCAN_PERIOD`; if there are more, every nth beam is stored."""
MAX_BYTES = 64_000_000
"""Maximum size of all samples, bytes; beyond it, every second sample is dropped, and the time between samples doubles."""
MAX_ROBOTS = 4
"""Maximum number of robots whose speeds are stored."""

Poses = NDArray[np.float32]


@dataclass(eq=False)
class SampledLidar:
    """A lidar and its scans.

    Attributes:
        lidar: handle of the lidar.
        mount: frame of the lidar.
        beams: indices of the stored beams.
        ticks: tick of each scan.
        poses: pose of the lidar in the world frame at each scan: position (m) and quaternion (x, y, z, w).
        ranges: distances of each scan, cm; 0 for beams without a hit.
    """

    lidar: Lidar
    mount: Mount
    beams: slice
    ticks: list[int] = field(default_factory=list)
    poses: list[Poses] = field(default_factory=list)
    ranges: list[NDArray[np.uint16]] = field(default_factory=list)

    def sample(self, tick: int, poses: NDArray[np.float64]) -> int:
        """Store the lidar's newest scan; return its size, bytes."""
        x, y, z, *turn = poses[self.mount.body].tolist()
        position, (qx, qy, qz, qw) = compose(((x, y, z), (turn[0], turn[1], turn[2], turn[3])), self.mount.pose)
        distances = self.lidar.scan().ranges[self.beams] * 100
        self.ticks.append(tick)
        self.poses.append(np.array([*position, qx, qy, qz, qw], np.float32))
        self.ranges.append(np.where(distances < 65535, distances, 0).astype(np.uint16))
        return self.ranges[-1].nbytes


@dataclass(eq=False)
class SampledStage:
    """A part of a run in which the same bodies exist; a new part begins when a robot is added or removed.

    Attributes:
        bodies: visible bodies.
        robots: row of each robot's base link in the array of poses, by name of the robot.
        lidars: lidars with their scans.
        ticks: tick of each sample.
        poses: position (m) and quaternion (x, y, z, w) of each body in each sample, shape (bodies, 7).
    """

    bodies: Bodies
    robots: dict[str, int]
    lidars: list[SampledLidar]
    ticks: list[int] = field(default_factory=list)
    poses: list[Poses] = field(default_factory=list)

    def drop_every_second(self) -> None:
        """Keep the first, third, fifth … of all samples."""
        del self.ticks[1::2], self.poses[1::2]
        for lidar in self.lidars:
            del lidar.ticks[1::2], lidar.poses[1::2], lidar.ranges[1::2]


class SceneTrace:
    """Collects samples of a session; call `sample` after each tick.

    Args:
        session: session that runs or replays.

    Attributes:
        period: simulation time between two ticks, s.
        stages: parts of the run in chronological order.
        speeds: samples of time (s), speed (m/s) and turn rate (rad/s), by name of the robot. Each sample covers only the first
            `MAX_ROBOTS` robots; an unknown speed or turn rate is NaN.
    """

    def __init__(self, session: SessionCore) -> None:
        self.period = session.clock.delta
        self.stages: list[SampledStage] = []
        self.speeds: dict[str, list[tuple[float, float, float]]] = defaultdict(list)
        self._session = session
        self._shown: object = None
        self._stride = max(round(1 / (RATE * self.period)), 1)
        self._scan_stride = max(round(SCAN_PERIOD / self.period), 1)
        self._bytes = 0

    def sample(self, tick: int, *, last: bool = False) -> None:
        """Store the current state if a sample is due in this tick; the last tick is always stored."""
        world = self._session.services.world
        poses = world.poses()
        present = (world, self._session.version, len(poses))
        begins = present != self._shown
        if begins:
            self._shown = present
            self.stages.append(self._begin())
        stage = self.stages[-1]
        for lidar in stage.lidars:
            if lidar.lidar.due and tick - (lidar.ticks[-1] if lidar.ticks else -math.inf) >= self._scan_stride:
                self._bytes += lidar.sample(tick, poses)
        if begins or last or tick % self._stride == 0:
            self._store(stage, tick, poses.astype(np.float32))

    def _store(self, stage: SampledStage, tick: int, poses: Poses) -> None:
        stage.ticks.append(tick)
        stage.poses.append(poses)
        names = list(stage.robots)[:MAX_ROBOTS]
        for name, state in states_of(self._session, names).items():
            speed, turn = (math.nan if state[key] is None else state[key] for key in ("speed", "turn"))
            self.speeds[name].append((tick * self.period, speed, turn))
        self._bytes += poses.nbytes
        if self._bytes > MAX_BYTES:
            self._bytes //= 2
            self._stride, self._scan_stride = 2 * self._stride, 2 * self._scan_stride
            for before in self.stages:
                before.drop_every_second()
            for samples in self.speeds.values():
                del samples[1::2]

    def _begin(self) -> SampledStage:
        services = self._session.services
        bodies, stage = services.world.bodies(), services.stage
        rows = {name: row for row, name in enumerate(bodies.names)}
        prims = list(stage.prims("lidar"))
        lidars = [services.world.device(Lidar, prim) for prim in prims]
        every = slice(None, None, -(-sum(len(lidar.directions) for lidar in lidars) // MAX_BEAMS) or 1)
        return SampledStage(
            bodies,
            {name: mount_of(stage.find(prim.facts["base_link"]), rows).body for name, prim in stage.robots().items()},
            [SampledLidar(lidar, mount_of(prim, rows), every) for lidar, prim in zip(lidars, prims, strict=True)],
        )
