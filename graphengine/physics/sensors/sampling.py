"""When a sensor has a new sample, and the random numbers that belong to it.

Sample n belongs to the first tick at or after n / rate seconds, found in integers, so rates do not drift: 20 Hz at 60 ticks a
second is every third tick, 7 Hz is every eighth or ninth. Noise comes from a counter-based generator keyed by seed, prim and
sample, so it does not depend on who asked for which samples before.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from graphengine.devices.random_streams import key_of
from graphengine.devices.stage import Prim
from graphengine.physics.dynamics.motion_handles import CarriedPrim

if TYPE_CHECKING:
    from graphengine.physics.core import SimulationCore

S = TypeVar("S")


class Sampling:
    """The samples of one sensor.

    Args:
        rate: samples a second.
        tick_period: seconds between two ticks, as numerator and denominator.
        prim_path: of the sensor.
    """

    def __init__(self, rate: float, tick_period: tuple[int, int], prim_path: str) -> None:
        period = Fraction(*tick_period) * Fraction(repr(rate))
        self._samples, self._ticks = period.numerator, period.denominator
        self._prim_path = prim_path

    def newest(self, tick: int) -> int:
        """Number of the newest sample whose time has come at a tick."""
        return tick * self._samples // self._ticks

    def due(self, tick: int) -> bool:
        """Whether a new sample falls into a tick; the first tick has one."""
        return tick == 1 or (tick > 1 and self.newest(tick) > self.newest(tick - 1))

    def random(self, seed: int, sample: int) -> np.random.Generator:
        """Return the random generator for the noise of one sample, from the session's seed."""
        return np.random.Generator(np.random.Philox(key=key_of(seed, self._prim_path), counter=sample << 128))


class Sampled(CarriedPrim):
    """A sensor that has a new sample in some ticks; its prim's facts have the `rate`."""

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        self.rate: float = prim.facts.get("rate", 30.0)
        self._sampling = Sampling(self.rate, simulation.tick_period, prim.path)
        super().__init__(simulation, prim)

    @property
    def due(self) -> bool:
        """Whether a new sample falls into this tick; the first tick has one."""
        return self._sampling.due(self._simulation.tick)

    @property
    def index(self) -> int:
        """Number of the newest sample since play."""
        return self._sampling.newest(self._simulation.tick)

    def _noise_of(self, index: int) -> np.random.Generator:
        """Return the random generator for the noise of a sample."""
        return self._sampling.random(self._simulation.seed, index)


class TickSampled(Sampled, Generic[S]):
    """A sensor that measures at most once a tick, and only if a node asks; a subclass makes a sample in `_make_sample`."""

    kept = ("_newest",)

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        self._newest: tuple[int, S] | None = None
        super().__init__(simulation, prim)

    def reset(self) -> None:
        """Forget the newest sample."""
        self._newest = None

    def _sample(self) -> S:
        """The newest sample, measured when first asked for in its tick and shared by all who ask.

        If no node asked in that tick, the sample that is measured now has its number and this tick's time, and is not kept.
        """
        index = self.index
        if self._newest is not None and self._newest[0] == index:
            return self._newest[1]
        sample = self._make_sample(index)
        if self.due:
            self._newest = index, sample
        return sample

    def _make_sample(self, index: int) -> S:
        """Make sample `index` from the current state, with noise from `self._noise_of(index)`."""
        raise NotImplementedError
