"""The Protocol of ultrasonic and infrared range sensors, their readings, and a range sensor stub for tests."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from graphengine.devices.device import Stub, TickSensor, device, when_due
from graphengine.devices.stage import Prim


@dataclass(frozen=True, slots=True)
class RangeReading:
    """One measurement of a range sensor."""

    time: float
    """Simulation time of the tick in which the distance was measured, s."""
    index: int
    """Sample index since the start of play."""
    range: float
    """Distance to the nearest surface in the cone, m. As in REP 117, inf means no surface in range, and -inf one too close."""


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
class RangeSensorStub(Stub):
    """A range sensor for tests. It reports the distance that a test sets with `measure`; initially, no surface is in range."""

    measured = RangeReading(0.0, 0, math.inf)

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        self.radiation_type: str = prim.facts.get("radiation_type", "ultrasound")
        self.field_of_view: float = prim.facts.get("field_of_view", 0.25)
        self.ranges: tuple[float, float] = prim.facts.get("ranges", (0.02, 4.0))
        self.noise_std: float = prim.facts.get("noise_std", 0.0)

    def measure(self, distance: float, *, time: float = 0.0, index: int = 0) -> None:
        """Set the distance (m), simulation time (s) and index of this tick's sample."""
        self.due, self.index, self.measured = True, index, RangeReading(time, index, distance)

    def reading(self) -> RangeReading:
        """Return the reading that the test set."""
        return self.measured
