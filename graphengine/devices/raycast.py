"""The Protocol of raycast sensors, whose rays have individual origins and directions, their readings, and a stub for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.device import ReadingStub, Sensor, device, when_due

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RaycastReading:
    """The hits of a raycast sensor's n rays. Arrays have one element or row per ray and must not be modified."""

    time: float
    """Simulation time of the measurement, s."""
    depths: Floats
    """Distance from the origin of each ray to its hit, m; for a ray without a hit, the sensor's maximum range."""
    hit_positions: Floats
    """Position of each hit, m, shape (n, 3); zero without a hit. The profile selects the sensor's frame or the world frame."""
    hit_normals: Floats
    """Unit normal of the surface at each hit, in the frame of `hit_positions`, shape (n, 3); zero without a hit."""
    hit_prims: tuple[str, ...]
    """Prim path of the body that each ray hits; empty without a hit, or if the geometry belongs to no body.

    The tuple has no elements if the sensor's profile does not enable prim paths.
    """
    origins: Floats
    """Origin of each ray in the world frame, m, shape (n, 3)."""
    ends: Floats
    """End of each ray in the world frame, m, shape (n, 3): at its hit, or at the sensor's maximum range."""


class RaycastSensor(Sensor, Protocol):
    """A sensor with any number of rays. It casts the rays whenever it is read."""

    def reading(self) -> RaycastReading:
        """Cast the rays and return their hits."""


@device("raycast", RaycastSensor, usd="IsaacRaycastSensor", title="a raycast sensor", sample=when_due("reading"))
class RaycastSensorStub(ReadingStub[RaycastReading]):
    """A raycast sensor for tests. It reports the reading that a test assigns to `measured`; initially, it has no rays."""

    _none = np.zeros((0, 3))
    measured = RaycastReading(0.0, np.zeros(0), _none, _none, (), _none, _none)
