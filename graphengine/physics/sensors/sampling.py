"""When a sensor has a new sample, and the random numbers that belong to it.

Sample n belongs to the first tick at or after n / rate seconds, found in integers, so rates do not drift: 20 Hz at 60 ticks a
second is every third tick, 7 Hz is every eighth or ninth. Noise comes from a counter-based generator keyed by seed, prim and
sample, so it does not depend on who asked for which samples before.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from graphengine.devices.seeds import key_of
from graphengine.devices.stage import Prim
from graphengine.physics.dynamics.handle_table import Handle
from graphengine.physics.dynamics.handles import CarriedPrim

if TYPE_CHECKING:
    from graphengine.physics.core import SimulationCore


class Sampling:
    """The samples of one sensor.

    Args:
        rate: samples a second.
        tick_period: seconds between two ticks, as numerator and denominator.
        seed: of the session.
        prim_path: of the sensor.
    """

    def __init__(self, rate: float, tick_period: tuple[int, int], seed: int, prim_path: str) -> None:
        period = Fraction(*tick_period) * Fraction(repr(rate))
        self._samples, self._ticks = period.numerator, period.denominator
        self._key = key_of(seed, prim_path)

    def newest(self, tick: int) -> int:
        """Number of the newest sample whose time has come at a tick."""
        return tick * self._samples // self._ticks

    def due(self, tick: int) -> bool:
        """Whether a new sample falls into a tick; the first tick has one."""
        return tick == 1 or (tick > 1 and self.newest(tick) > self.newest(tick - 1))

    def random(self, sample: int) -> np.random.Generator:
        """The generator of one sample's noise."""
        return np.random.Generator(np.random.Philox(key=self._key, counter=sample << 128))


class Sampled(Handle):
    """A sensor that has a new sample in some ticks; its prim's facts have the `rate`."""

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        self.rate: float = prim.facts.get("rate", 30.0)
        self._sampling = Sampling(self.rate, simulation.tick_period, simulation.seed, prim.path)
        self._mount = CarriedPrim(simulation, prim)
        super().__init__(simulation, prim)

    def bind(self) -> None:
        """Find the body that carries it."""
        self._mount.bind()

    @property
    def due(self) -> bool:
        """Whether a new sample falls into this tick; the first tick has one."""
        return self._sampling.due(self._simulation.tick)

    @property
    def index(self) -> int:
        """Number of the newest sample since play."""
        return self._sampling.newest(self._simulation.tick)
