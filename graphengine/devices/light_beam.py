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
    """What the beams of a sensor meet, in the order of the beams; the arrays are not to be changed."""

    hits: NDArray[np.bool_]
    """Whether each beam is broken."""
    depths: Floats
    """Distance of each hit from the sensor along the beam, m; the sensor's range without a hit."""
    hit_positions: Floats
    """End of each beam in the sensor's frame, shape (n, 3), m."""
    origins: Floats
    """Beginning of each beam in the world frame, shape (n, 3), m."""
    ends: Floats
    """End of each beam in the world frame, at its hit or at the sensor's range, shape (n, 3), m."""


class LightBeam(Sensor, Protocol):
    """A sensor with one beam, or with several parallel beams side by side, that casts them whenever it is read."""

    def reading(self) -> BeamReading:
        """Return what the beams meet now."""


@device("light_beam", LightBeam, usd="IsaacLightBeamSensor", title="a light beam sensor")
class LightBeamStub(Stub):
    """A light beam sensor whose reading tests write to `measured`; without beams at first."""

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        none = np.zeros((0, 3))
        self.measured = BeamReading(np.zeros(0, bool), np.zeros(0), none, none, none)

    def reading(self) -> BeamReading:
        """Return the reading set by the test."""
        return self.measured
