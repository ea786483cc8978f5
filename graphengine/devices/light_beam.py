"""The Protocol of light beam sensors (light barriers and light curtains), their readings, and a stub for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.device import ReadingStub, Sensor, device, when_due

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BeamReading:
    """The state of a light beam sensor's n beams. Arrays have one element or row per beam and must not be modified."""

    time: float
    """Simulation time of the measurement, s."""
    hits: NDArray[np.bool_]
    """Whether an object interrupts each beam."""
    depths: Floats
    """Distance along each beam to the object that interrupts it, m; for a free beam, the sensor's maximum range."""
    hit_positions: Floats
    """End of each beam in the sensor's frame, m, shape (n, 3): the point of interruption; for a free beam, at maximum range."""
    origins: Floats
    """Start of each beam in the world frame, m, shape (n, 3)."""
    ends: Floats
    """The points of `hit_positions` in the world frame, m, shape (n, 3)."""


class LightBeam(Sensor, Protocol):
    """A sensor with one light beam or with several parallel beams side by side. It casts the beams whenever it is read."""

    def reading(self) -> BeamReading:
        """Cast the beams and return which of them are interrupted, and where."""


@device("light_beam", LightBeam, usd="IsaacLightBeamSensor", title="a light beam sensor", sample=when_due("reading"))
class LightBeamStub(ReadingStub[BeamReading]):
    """A light beam sensor for tests. It reports the reading that a test assigns to `measured`; initially, it has no beams."""

    measured = BeamReading(0.0, np.zeros(0, bool), np.zeros(0), *[np.zeros((0, 3))] * 3)
