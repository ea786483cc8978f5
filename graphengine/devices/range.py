"""The Protocol of ultrasonic and infrared range sensors, their readings, and a range sensor stub for tests."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from graphengine.devices.device import ReadingStub, TickSensor, device, when_due


@dataclass(frozen=True, slots=True)
class RangeReading:
    """One measurement of a range sensor."""

    time: float
    """Simulation time of the tick in which the distance was measured, s."""
    index: int
    """Sample index since the start of play."""
    range: float
    """Distance to the nearest surface in the cone, m. As in REP 117, inf means no surface in range, -inf a surface too close."""


class RangeSensor(TickSensor, Protocol):
    """A sensor that measures the distance to the nearest surface in a cone about its x axis."""

    @property
    def radiation_type(self) -> str:
        """`ultrasound` or `infrared`."""

    @property
    def field_of_view(self) -> float:
        """Full opening angle of the cone, rad."""

    @property
    def ranges(self) -> tuple[float, float]:
        """Minimum and maximum distance that the sensor reports, m."""

    @property
    def noise_std(self) -> float:
        """Standard deviation of the noise of the measured distance, m."""

    def reading(self) -> RangeReading:
        """Return the newest sample. The first call in its tick measures the distance; all callers get the same object."""


@device("range", RangeSensor, usd="RangeSensor", title="a range sensor", sample=when_due("reading"))
class RangeSensorStub(ReadingStub[RangeReading]):
    """A range sensor for tests. It reports the distance that a test sets with `measure`; initially, no surface is in range."""

    measured = RangeReading(0.0, 0, math.inf)
    radiation_type = "ultrasound"
    field_of_view = 0.25
    ranges = (0.02, 4.0)
    noise_std = 0.0

    def measure(self, distance: float, *, time: float = 0.0, index: int = 0) -> None:
        """Set the distance (m), simulation time (s) and index of this tick's sample."""
        self.due, self.index, self.measured = True, index, RangeReading(time, index, distance)
