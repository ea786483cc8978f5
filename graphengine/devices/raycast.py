"""Raycast sensors, whose rays have origins and directions of their own: the Protocol and the stub."""

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
    """What the rays of a sensor meet, in the order of the rays; the arrays are not to be changed."""

    time: float
    """Simulation time, s."""
    depths: Floats
    """Distance of each hit from the origin of its ray, m; the sensor's range without a hit."""
    hit_positions: Floats
    """Position of each hit in the sensor's frame or in the world frame, shape (n, 3), m; zero without a hit."""
    hit_normals: Floats
    """Unit normal of the surface at each hit, in the same frame, shape (n, 3); zero without a hit."""
    hit_prims: tuple[str, ...]
    """Path of the body that each ray meets; empty without a hit, for a shape of the world itself, or if not asked for."""
    origins: Floats
    """Origin of each ray in the world frame, shape (n, 3), m."""
    ends: Floats
    """End of each ray in the world frame, at its hit or at the sensor's range, shape (n, 3), m."""


class RaycastSensor(Sensor, Protocol):
    """A sensor that casts its rays whenever it is read."""

    def reading(self) -> RaycastReading:
        """Return what the rays meet now."""


@device("raycast", RaycastSensor, usd="IsaacRaycastSensor", title="a raycast sensor")
class RaycastSensorStub(Stub):
    """A raycast sensor whose reading tests write to `measured`; without rays at first."""

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        none = np.zeros((0, 3))
        self.measured = RaycastReading(0.0, np.zeros(0), none, none, (), none, none)

    def reading(self) -> RaycastReading:
        """Return the reading set by the test."""
        return self.measured
