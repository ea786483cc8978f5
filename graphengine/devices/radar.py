"""Radars: the Protocol and the stub."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine.devices.device import Stub, TickSensor, device
from graphengine.devices.stage import Prim


@dataclass(frozen=True, slots=True)
class Detections:
    """One sample of a radar; arrays have one entry per detection and are never modified."""

    time: float
    """Simulation time of the tick in which the rays were cast, s."""
    index: int
    """Number of this sample since play."""
    points: NDArray[np.float32]
    """Positions in the radar's frame, m, shape (n, 3)."""
    radial_velocities: NDArray[np.float32]
    """Rates of change of the distances, m/s; positive for targets that move away from the radar."""
    intensities: NDArray[np.float32]
    """Received power relative to that of the same target at the largest distance, dB."""


class Radar(TickSensor, Protocol):
    """A sensor that measures the position and radial velocity of each point that its rays hit."""

    @property
    def ranges(self) -> tuple[float, float]:
        """Smallest and largest distance reported, m."""

    def detections(self) -> Detections:
        """Return the newest sample; it is measured at the first call in its tick and shared by all callers."""


@device("radar", Radar, usd="OmniRadar", title="a radar", rank=3, child="Radar")
class RadarStub(Stub):
    """A radar whose detections tests set with `see`; at first there are none. `casts` counts calls of `detections`."""

    casts = 0

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        self.ranges: tuple[float, float] = prim.facts.get("ranges", (0.2, 100.0))
        self._seen = _detections(0.0, 0, np.empty((0, 3)), 0.0, 0.0)

    def see(
        self,
        points: ArrayLike,
        radial_velocities: ArrayLike = 0.0,
        intensities: ArrayLike = 0.0,
        *,
        time: float = 0.0,
        index: int = 0,
    ) -> None:
        """Set the sample of this tick: points (m), with velocities (m/s) and intensities (dB) per point or one for all points."""
        self.due, self.index = True, index
        self._seen = _detections(time, index, points, radial_velocities, intensities)

    def detections(self) -> Detections:
        """Return the sample set by the test, or one without detections."""
        self.casts += 1
        return self._seen


def _detections(time: float, index: int, points: ArrayLike, *values: ArrayLike) -> Detections:
    placed = np.array(points, np.float32).reshape(-1, 3)
    velocities, intensities = (np.full(len(placed), value, np.float32) for value in values)
    return Detections(time, index, placed, velocities, intensities)
