"""Light beam sensors, single beams and light curtains: the Protocol and the stub."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.device import Sensor, Stub, device
from graphengine.devices.stage import Prim

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BeamReading:
    """Hits of a sensor's beams; arrays have one entry per beam and must not be changed."""

    hits: NDArray[np.bool_]
    """Whether each beam is broken."""
    depths: Floats
    """Distance from the sensor to each hit along the beam, m; the sensor's range if there is no hit."""
    hit_positions: Floats
    """End of each beam in the sensor's frame, shape (n, 3), m."""
    origins: Floats
    """Start of each beam in the world frame, shape (n, 3), m."""
    ends: Floats
    """End of each beam in the world frame, at its hit or at the sensor's range, shape (n, 3), m."""


class LightBeam(Sensor, Protocol):
    """A sensor with one beam, or several parallel beams side by side; it casts them whenever it is read."""

    def reading(self) -> BeamReading:
        """Cast the beams and return their hits."""


@device("light_beam", LightBeam, usd="IsaacLightBeamSensor", title="a light beam sensor")
class LightBeamStub(Stub):
    """A light beam sensor that returns the reading which a test writes to `measured`; initially without beams."""

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        none = np.zeros((0, 3))
        self.measured = BeamReading(np.zeros(0, bool), np.zeros(0), none, none, none)

    def reading(self) -> BeamReading:
        """Return the reading set by the test."""
        return self.measured
