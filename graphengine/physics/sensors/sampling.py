"""Determines when a sensor takes samples, and the random numbers for the noise of a sample.

Sample n belongs to the first tick at or after n / rate seconds. This tick is computed with integers; so rates do not drift: 20 Hz
at 60 ticks per second is every third tick, 7 Hz is every eighth or ninth tick. Random numbers come from a counter-based
generator, which starts from seed, prim path and sample number. So they do not depend on which samples were requested before.
"""

from __future__ import annotations

from fractions import Fraction
from typing import ClassVar, Generic, TypeVar

import numpy as np

from graphengine.devices.random_streams import key_of
from graphengine.physics.handles.motion_handles import CarriedPrim

S = TypeVar("S")


class Sampling:
    """The schedule of a sensor's samples.

    Args:
        rate: samples per second.
        tick_period: seconds per tick, as numerator and denominator.
        prim_path: path of the sensor's prim.
    """

    def __init__(self, rate: float, tick_period: tuple[int, int], prim_path: str) -> None:
        period = Fraction(*tick_period) * Fraction(repr(rate))
        self._samples, self._ticks = period.numerator, period.denominator
        self._prim_path = prim_path

    def newest(self, tick: int) -> int:
        """Return the number of the newest sample at a tick, counted from 0."""
        return tick * self._samples // self._ticks

    def due(self, tick: int) -> bool:
        """Return whether a new sample belongs to a tick; one always belongs to the first tick."""
        return tick == 1 or (tick > 1 and self.newest(tick) > self.newest(tick - 1))

    def random(self, seed: int, sample: int) -> np.random.Generator:
        """Return the random generator for the noise of one sample, given the session's seed."""
        return np.random.Generator(np.random.Philox(key=key_of(seed, self._prim_path), counter=sample << 128))


class Sampled(CarriedPrim):
    """Base class of sensors that take samples at a fixed rate: the `rate` in the `facts` of the prim, Hz."""

    def _set_up(self) -> None:
        self.rate: float = self._prim.facts.get("rate", 30.0)
        self._sampling = Sampling(self.rate, self._simulation.tick_period, self.prim_path)

    @property
    def due(self) -> bool:
        """Whether the sensor takes a new sample in this tick; it always does in the first tick."""
        return self._sampling.due(self._simulation.tick)

    @property
    def index(self) -> int:
        """Number n of the newest sample since the start of play: the largest n with n / rate at or before the present time."""
        return self._sampling.newest(self._simulation.tick)

    def _noise_of(self, index: int) -> np.random.Generator:
        """Return the random generator for the noise of a sample."""
        return self._sampling.random(self._simulation.seed, index)


class TickSampled(Sampled, Generic[S]):
    """Base class of sensors that measure at most once per tick, and only on request; a subclass measures in `_make_sample`."""

    kept: ClassVar[tuple[str, ...]] = ("_newest",)

    _newest: tuple[int, S] | None = None

    def reset(self) -> None:
        """Discard the newest sample."""
        self._newest = None

    def reading(self) -> S:
        """Return the newest sample. It is measured at the first request in its tick; all callers get the same object.

        A sample that no node requested in its tick is measured now, with its own number and the current time, and is not kept.
        """
        index = self.index
        if self._newest is not None and self._newest[0] == index:
            return self._newest[1]
        sample = self._make_sample(index)
        if self.due:
            self._newest = index, sample
        return sample

    def _make_sample(self, index: int) -> S:
        """Measure sample `index` in the current state, with noise from `self._noise_of(index)`."""
        raise NotImplementedError
