"""The Protocol of lidars, their scans, and a lidar stub for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine.devices.device import Stub, TickSensor, device, when_due
from graphengine.devices.stage import Prim


@dataclass(frozen=True, slots=True)
class Scan:
    """One scan of a lidar. Arrays have one element per beam, ring after ring, and within a ring in order of azimuth.

    The arrays are shared by all readers and must not be modified.
    """

    time: float
    """Simulation time of the tick in which the beams were cast, s."""
    index: int
    """Sample index since the start of play."""
    ranges: NDArray[np.float32]
    """Distance to the surface that each beam hits, m; inf for a beam without a hit in range."""
    intensities: NDArray[np.float32]
    """Intensity of each beam's return, 0 to 255."""
    directions: NDArray[np.float64]
    """Unit vectors of the beams in the lidar's frame, shape (n, 3)."""

    @property
    def points(self) -> NDArray[np.float64]:
        """Points that the beams hit, in the lidar's frame, m: a new array of shape (n, 3), NaN for a beam without a hit."""
        hit = np.isfinite(self.ranges)
        return np.where(hit, self.ranges, np.nan)[:, None] * self.directions

    def points_of(self, beams: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return the hit points of the beams with the given indices, in the lidar's frame, m, shape (n, 3)."""
        points: NDArray[np.float64] = self.directions[beams] * self.ranges[beams, None]
        return points


class Lidar(TickSensor, Protocol):
    """A lidar that casts all beams of a scan at the same time."""

    @property
    def angles(self) -> tuple[float, float, float]:
        """Azimuths of a ring's first and last beam, and the step between two beams; rad, counter-clockwise from the x axis."""

    @property
    def elevations(self) -> NDArray[np.float64]:
        """Elevation angle of each ring, rad, shape (rings,); positive above the lidar's xy plane.

        A planar lidar has one ring at 0.
        """

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit vectors of the beams in the lidar's frame, ring after ring, shape (rings x azimuths, 3)."""

    @property
    def ranges(self) -> tuple[float, float]:
        """Minimum and maximum distance that the lidar reports, m."""

    def scan(self) -> Scan:
        """Return the newest scan. The first call in its tick casts the beams; all callers get the same object."""


def beam_directions(angles: tuple[float, float, float], elevations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit vectors of a lidar's beams, ring after ring, shape (rings x azimuths, 3).

    Args:
        angles: azimuths of a ring's first and last beam, and the step between two beams, rad.
        elevations: elevation angle of each ring, rad; positive above the lidar's xy plane.
    """
    first, last, increment = angles
    azimuth = first + increment * np.arange(round((last - first) / increment) + 1)
    level = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=1)
    if not np.any(elevations):
        return np.tile(level, (len(elevations), 1))
    upwards = np.stack([np.cos(elevations), np.cos(elevations), np.sin(elevations)], axis=1)
    level[:, 2] = 1.0
    directions: NDArray[np.float64] = (upwards[:, None, :] * level).reshape(-1, 3)
    return directions


@device("lidar", Lidar, usd="OmniLidar", title="a lidar", rank=1, child="Lidar", sample=when_due("scan"))
class LidarStub(Stub):
    """A lidar for tests. It reports the scan that a test sets with `see`; initially, no beam has a hit.

    `casts` counts the calls of `scan`.
    """

    casts = 0
    angles = (0.0, 0.0, 1.0)
    ranges = (0.05, 10.0)
    _seen: Scan | None = None

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        self.elevations: NDArray[np.float64] = np.array(prim.facts.get("elevations", (0.0,)), float)
        self.directions = beam_directions(self.angles, self.elevations)

    def see(self, ranges: ArrayLike, intensities: ArrayLike = 0.0, *, time: float = 0.0, index: int = 0) -> None:
        """Set the scan of this tick.

        Args:
            ranges: distance for each beam, m; inf for a beam without a hit.
            intensities: intensity for each beam, or one value for all beams.
            time: simulation time of the scan, s.
            index: sample index since the start of play.
        """
        distances = np.array(ranges, np.float32)
        brightness = np.full(distances.shape, intensities, np.float32)
        self.due, self.index, self._seen = True, index, Scan(time, index, distances, brightness, self.directions)

    def scan(self) -> Scan:
        """Return the scan that the test set, or a scan without hits."""
        self.casts += 1
        beams = len(self.directions)
        misses = np.full(beams, np.inf, np.float32)
        return self._seen or Scan(0.0, 0, misses, np.zeros(beams, np.float32), self.directions)
