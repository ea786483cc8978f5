"""The Protocol of receivers for satellite navigation (GPS and its like), their readings, and a receiver stub for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from graphengine.devices.device import ReadingStub, TickSensor, device, when_due


@dataclass(frozen=True, slots=True)
class NavSatReading:
    """One position fix on the WGS84 ellipsoid; NaN for all three coordinates if the receiver has no fix."""

    time: float
    """Simulation time of the tick in which the position was measured, s."""
    index: int
    """Sample index since the start of play."""
    latitude: float
    """Geodetic latitude, degrees, positive north of the equator."""
    longitude: float
    """Longitude, degrees, positive east of Greenwich."""
    altitude: float
    """Height above the ellipsoid, m."""


class NavSat(TickSensor, Protocol):
    """A receiver that measures the position of its prim on Earth."""

    @property
    def fix(self) -> str:
        """Kind of the receiver's fixes: `fix`, `sbas_fix` or `gbas_fix`."""

    @property
    def horizontal_noise(self) -> float:
        """Standard deviation of the noise, to the east and to the north, m."""

    @property
    def vertical_noise(self) -> float:
        """Standard deviation of the noise of the height, m."""

    def reading(self) -> NavSatReading:
        """Return the newest sample; all callers get the same object."""


@device("navsat", NavSat, usd="NavSatSensor", title="a navsat receiver", sample=when_due("reading"))
class NavSatStub(ReadingStub[NavSatReading]):
    """A receiver for tests. It reports the position that a test sets with `measure`; initially, latitude and longitude are 0."""

    measured = NavSatReading(0.0, 0, 0.0, 0.0, 0.0)
    fix = "fix"
    horizontal_noise = 0.0
    vertical_noise = 0.0

    def measure(self, latitude: float, longitude: float, altitude: float, *, time: float = 0.0, index: int = 0) -> None:
        """Set the position (degrees, m), simulation time (s) and index of this tick's sample."""
        self.due, self.index = True, index
        self.measured = NavSatReading(time, index, latitude, longitude, altitude)
