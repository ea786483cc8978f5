"""Raycast sensors, with an origin and a direction for each ray: the Protocol and the stub."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.device import Sensor, Stub, device
from graphengine.devices.stage import Prim

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RaycastReading:
    """Hits of a sensor's rays; arrays have one entry per ray and must not be changed."""

    time: float
    """Simulation time, s."""
    depths: Floats
    """Distance from the origin of each ray to its hit, m; the sensor's range if there is no hit."""
    hit_positions: Floats
    """Position of each hit in the sensor's frame or in the world frame, shape (n, 3), m; zero without a hit."""
    hit_normals: Floats
    """Unit normal of the surface at each hit, in the same frame, shape (n, 3); zero without a hit."""
    hit_prims: tuple[str, ...]
    """Path of the body that each ray hits; empty without a hit or for geometry of no body. No entries if not enabled."""
    origins: Floats
    """Origin of each ray in the world frame, shape (n, 3), m."""
    ends: Floats
    """End of each ray in the world frame, at its hit or at the sensor's range, shape (n, 3), m."""


class RaycastSensor(Sensor, Protocol):
    """A sensor that casts its rays whenever it is read."""

    def reading(self) -> RaycastReading:
        """Cast the rays and return their hits."""


@device("raycast", RaycastSensor, usd="IsaacRaycastSensor", title="a raycast sensor")
class RaycastSensorStub(Stub):
    """A raycast sensor that returns the reading which a test writes to `measured`; initially without rays."""

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        none = np.zeros((0, 3))
        self.measured = RaycastReading(0.0, np.zeros(0), none, none, (), none, none)

    def reading(self) -> RaycastReading:
        """Return the reading set by the test."""
        return self.measured
