"""Lidars: the Protocol and the stub."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine.devices.device import Stub, TickSensor, device
from graphengine.devices.stage import Prim


@dataclass(frozen=True, slots=True)
class Scan:
    """One sweep of a lidar; arrays have one entry per beam, ring after ring in order of azimuth, and are never modified."""

    time: float
    """Simulation time of the tick in which the beams were cast, s."""
    index: int
    """Number of this sample since play."""
    ranges: NDArray[np.float32]
    """Distance of each beam's hit, m; inf without a hit in range."""
    intensities: NDArray[np.float32]
    """Intensity of each beam, 0 to 255."""


class Lidar(TickSensor, Protocol):
    """A ray-casting range sensor."""

    @property
    def angles(self) -> tuple[float, float, float]:
        """Azimuth of the first beam, azimuth of the last one, and step between two, rad, counter-clockwise from the x axis."""

    @property
    def elevations(self) -> NDArray[np.float64]:
        """Angle of each ring above the lidar's xy plane, rad; one ring at 0 for a planar lidar."""

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit vectors of the beams in the lidar's frame, ring after ring, shape (rings x azimuths, 3)."""

    @property
    def ranges(self) -> tuple[float, float]:
        """Smallest and largest distance reported, m."""

    def scan(self) -> Scan:
        """Return the newest sample, which is cast at the first call in its tick and shared by all callers."""


def beam_directions(angles: tuple[float, float, float], elevations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unit vectors of a lidar's beams, ring after ring, shape (rings x azimuths, 3).

    Args:
        angles: azimuth of a ring's first beam, azimuth of its last one, and step between two, rad.
        elevations: angle of each ring above the lidar's xy plane, rad.
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


@device("lidar", Lidar, usd="OmniLidar", title="a lidar", rank=1, child="Lidar")
class LidarStub(Stub):
    """A lidar whose sample tests set with `see`; at first all beams miss. `casts` counts calls of `scan`."""

    casts = 0
    _seen: Scan | None = None

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        self.angles: tuple[float, float, float] = prim.facts.get("angles", (0.0, 0.0, 1.0))
        self.ranges: tuple[float, float] = prim.facts.get("ranges", (0.05, 10.0))
        self.elevations: NDArray[np.float64] = np.array(prim.facts.get("elevations", (0.0,)), float)
        self.directions = beam_directions(self.angles, self.elevations)

    def see(self, ranges: ArrayLike, intensities: ArrayLike = 0.0, *, time: float = 0.0, index: int = 0) -> None:
        """Set the sample of this tick: `ranges` (m) per beam, inf for a miss, and `intensities` per beam or one for all beams."""
        distances = np.array(ranges, np.float32)
        brightness = np.full(distances.shape, intensities, np.float32)
        self.due, self.index, self._seen = True, index, Scan(time, index, distances, brightness)

    def scan(self) -> Scan:
        """Return the sample set by the test, or one in which all beams miss."""
        self.casts += 1
        beams = len(self.directions)
        return self._seen or Scan(0.0, 0, np.full(beams, np.inf, np.float32), np.zeros(beams, np.float32))
