"""The Protocol of radars, their detections, and a radar stub for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graphengine.devices.device import Stub, TickSensor, device, when_due


@dataclass(frozen=True, slots=True)
class Detections:
    """One sample of a radar. Arrays have one element or row per detection and must not be modified."""

    time: float
    """Simulation time of the tick in which the rays were cast, s."""
    index: int
    """Sample index since the start of play."""
    points: NDArray[np.float32]
    """Positions of the detected points in the radar's frame, m, shape (n, 3)."""
    radial_velocities: NDArray[np.float32]
    """Rate of change of each distance, m/s; positive for targets that move away from the radar."""
    intensities: NDArray[np.float32]
    """Received power, dB, relative to the power that the same target would return at the maximum range."""


class Radar(TickSensor, Protocol):
    """A sensor that measures the position and radial velocity of each point that its rays hit."""

    @property
    def ranges(self) -> tuple[float, float]:
        """Minimum and maximum distance that the radar reports, m."""

    def detections(self) -> Detections:
        """Return the newest sample. The first call in its tick casts the rays; all callers get the same object."""


def _detections(time: float, index: int, points: ArrayLike, *values: ArrayLike) -> Detections:
    placed = np.array(points, np.float32).reshape(-1, 3)
    velocities, intensities = (np.full(len(placed), value, np.float32) for value in values)
    return Detections(time, index, placed, velocities, intensities)


@device("radar", Radar, usd="OmniRadar", title="a radar", rank=3, child="Radar", sample=when_due("detections"))
class RadarStub(Stub):
    """A radar for tests. It reports the detections that a test sets with `see`; initially, there are none.

    `casts` counts the calls of `detections`.
    """

    casts = 0
    ranges = (0.2, 100.0)
    _seen = _detections(0.0, 0, (), 0.0, 0.0)

    def see(
        self,
        points: ArrayLike,
        radial_velocities: ArrayLike = 0.0,
        intensities: ArrayLike = 0.0,
        *,
        time: float = 0.0,
        index: int = 0,
    ) -> None:
        """Set the detections of this tick.

        Args:
            points: positions in the radar's frame, m, shape (n, 3).
            radial_velocities: velocity for each point, m/s, or one value for all points.
            intensities: intensity for each point, dB, or one value for all points.
            time: simulation time of the measurement, s.
            index: sample index since the start of play.
        """
        self.due, self.index = True, index
        self._seen = _detections(time, index, points, radial_velocities, intensities)

    def detections(self) -> Detections:
        """Return the detections that the test set."""
        self.casts += 1
        return self._seen
