"""A receiver for satellite navigation, which measures the position of its antenna on the WGS84 ellipsoid.

The noise of each fix is independent of other fixes, whereas the errors of real receivers change slowly. Satellites are not
simulated; a share of the time without a fix stands for a shadowed sky.
"""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field

from graphengine.descriptions.earth import earth_of
from graphengine.devices.navsat import NavSat, NavSatReading
from graphengine.physics.implementations import Deviation, Profile, Rate, implements
from graphengine.physics.sensors.geodesy import TangentPlane
from graphengine.physics.sensors.sampling import Sampling, TickSampled

_NO_FIX = (math.nan, math.nan, math.nan)


class NavSatProfile(Profile):
    """The parameters of a receiver for satellite navigation; the scene's `spherical_coordinates` give the place on Earth."""

    rate: Rate = 5.0
    """Position fixes per second."""
    horizontal_noise: Deviation = 0.0
    """Standard deviation of east and of north, m."""
    vertical_noise: Deviation = 0.0
    """Standard deviation of the height, m."""
    fix: Literal["fix", "sbas_fix", "gbas_fix"] = "fix"
    """Status of messages: without augmentation, with that of satellites, or with that of the ground (RTK)."""
    dropout: float = Field(default=0.0, ge=0.0, le=1.0)
    """Share of the time in which there is no fix."""
    dropout_duration: float = Field(default=1.0, ge=0.001, le=1e6)
    """Duration of a stretch of time that is with or without a fix, s."""


@implements(NavSat, NavSatProfile)
class NavSatReceiver(TickSampled[NavSatReading]):
    """The receiver at a prim; the prim's `facts` are the values of its profile."""

    def _set_up(self) -> None:
        facts = self._prim.facts
        self.fix: str = facts["fix"]
        self.horizontal_noise: float = facts["horizontal_noise"]
        self.vertical_noise: float = facts["vertical_noise"]
        self._dropout: float = facts["dropout"]
        stretches = 1.0 / facts["dropout_duration"]
        self._outages = Sampling(stretches, self._simulation.tick_period, f"{self.prim_path} dropout")
        super()._set_up()

    def bind(self) -> None:
        """Look up the body that carries the receiver, and the coordinates of the world on Earth."""
        super().bind()
        self._plane = TangentPlane(*(earth_of(self._simulation.model) or (0.0, 0.0, 0.0, 0.0)))

    def _make_sample(self, index: int) -> NavSatReading:
        time, level = self._simulation.time, self.horizontal_noise
        if self._is_out():
            return NavSatReading(time, index, *_NO_FIX)
        east, north, up = self._noise_of(index).standard_normal(3).tolist()
        place = self._plane.geodetic(self.pose()[0], (level * east, level * north, self.vertical_noise * up))
        return NavSatReading(time, index, *place)

    def _is_out(self) -> bool:
        """Return whether the present stretch of time is without a fix."""
        if not self._dropout:
            return False
        stretch = self._outages.newest(self._simulation.tick)
        return bool(self._outages.random(self._simulation.seed, stretch).random() < self._dropout)
