"""Errors of inertial measurement units, in the quantities of data sheets and of the Allan deviation (IEEE 952).

The random errors of a sample depend only on the session's seed, the prim's path and the sample's number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from graphengine.descriptions.engine import Floats
from graphengine.devices.random_streams import key_of
from graphengine.format.spec import Spec
from graphengine.physics.implementations import Offset

Amount = Annotated[float, Field(ge=0.0, le=1e9)]
Seconds = Annotated[float, Field(ge=1e-3, le=1e9)]
Percents = Annotated[tuple[Offset, Offset, Offset], Field(strict=False)]

_MICRO_G = 9.80665e-6
_DEGREE = math.pi / 180.0
_HOUR = 3600.0
_BLOCK = 512
"""Number of samples whose random numbers are drawn together."""


class AccelerometerErrors(Spec):
    """Errors of three accelerometers, in the units of data sheets; 1 µg is 9.80665e-6 m/s2. Errors that are not given are 0."""

    noise_density_ug: Amount = 0.0
    """White noise, µg/√Hz."""
    bias_instability_ug: Amount = 0.0
    """Standard deviation of a bias that varies with bias_correlation_time, µg."""
    bias_correlation_time: Seconds = 100.0
    """Time constant of the varying bias, s."""
    bias_walk_ug: Amount = 0.0
    """Random walk of the bias: its standard deviation after an hour, µg/√h."""
    scale_error_percent: Percents = (0.0, 0.0, 0.0)
    """Scale factor error of x, y and z, %."""

    def in_si(self) -> TriadErrors:
        """Return the errors in SI units."""
        noise, instability, walk = self.noise_density_ug, self.bias_instability_ug, self.bias_walk_ug / math.sqrt(_HOUR)
        scale, time = self.scale_error_percent, self.bias_correlation_time
        return TriadErrors(noise * _MICRO_G, instability * _MICRO_G, time, walk * _MICRO_G, scale)


class GyroscopeErrors(Spec):
    """Errors of three gyroscopes, in the units of data sheets. Errors that are not given are 0."""

    noise_density_dps: Amount = 0.0
    """White noise, (deg/s)/√Hz."""
    bias_instability_dph: Amount = 0.0
    """Standard deviation of a bias that varies with bias_correlation_time, deg/h."""
    bias_correlation_time: Seconds = 100.0
    """Time constant of the varying bias, s."""
    bias_walk_dph: Amount = 0.0
    """Random walk of the bias: its standard deviation after an hour, (deg/h)/√h."""
    scale_error_percent: Percents = (0.0, 0.0, 0.0)
    """Scale factor error of x, y and z, %."""

    def in_si(self) -> TriadErrors:
        """Return the errors in SI units."""
        instability, walk = self.bias_instability_dph / _HOUR, self.bias_walk_dph / _HOUR / math.sqrt(_HOUR)
        scale, time = self.scale_error_percent, self.bias_correlation_time
        return TriadErrors(self.noise_density_dps * _DEGREE, instability * _DEGREE, time, walk * _DEGREE, scale)


@dataclass(frozen=True, slots=True)
class TriadErrors:
    """Errors of three accelerometers or gyroscopes in SI units; below, u stands for m/s2 or rad/s."""

    noise_density: float = 0.0
    """White noise, u/√Hz."""
    bias_instability: float = 0.0
    """Standard deviation of a bias that is a first-order Gauss-Markov process, u."""
    bias_correlation_time: float = 1.0
    """Time constant of the Gauss-Markov process, s."""
    bias_walk: float = 0.0
    """Standard deviation of the bias's random walk after 1 s, u/√s."""
    scale_error_percent: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Drift(NamedTuple):
    """The biases of a sample, as arrays of x, y and z of accelerometers (m/s2), then of gyroscopes (rad/s)."""

    seed: int
    sample: int
    correlated: Floats
    walk: Floats


class InertialErrors:
    """The errors of one inertial unit; arrays are x, y and z of accelerometers (m/s2), then of gyroscopes (rad/s).

    Args:
        triads: errors of the accelerometers and of the gyroscopes.
        rate: samples per second.
        prim_path: path of the unit's prim.
    """

    def __init__(self, triads: tuple[TriadErrors, TriadErrors], rate: float, prim_path: str) -> None:
        self.noise_density = np.repeat([triad.noise_density for triad in triads], 3)
        self.scale = np.concatenate([triad.scale_error_percent for triad in triads]) / 100.0
        self._deviation = np.repeat([triad.bias_instability for triad in triads], 3)
        self._decay = np.exp(-1.0 / (rate * np.repeat([triad.bias_correlation_time for triad in triads], 3)))
        self._kick = self._deviation * np.sqrt(1.0 - self._decay**2)
        self._pace = np.repeat([triad.bias_walk for triad in triads], 3) / math.sqrt(rate)
        self._drifts = bool(self._deviation.any() or self._pace.any())
        self._prim_path = prim_path
        self._drawn: tuple[tuple[int, int], Floats] | None = None

    def drift(self, seed: int, sample: int, known: Drift | None) -> Drift:
        """Return the biases of a sample, computed from the biases of an earlier sample if these are known.

        Args:
            seed: the session's seed.
            sample: number of the sample, from 0.
            known: biases of any sample, or None; the biases of a sample shortly before this sample make the computation fast.
        """
        if known is None or known.seed != seed or known.sample > sample:
            known = Drift(seed, 0, self._deviation * self._random(seed, 0)[:6], np.zeros(6))
        if not self._drifts:
            return known
        _, last, correlated, walk = known
        for number in range(last + 1, sample + 1):
            random = self._random(seed, number)
            correlated = correlated * self._decay + self._kick * random[:6]
            walk = walk + self._pace * random[6:]
        return Drift(seed, sample, correlated, walk)

    def _random(self, seed: int, sample: int) -> Floats:
        """Return the 12 normally distributed numbers of a sample."""
        block, row = divmod(sample, _BLOCK)
        if self._drawn is None or self._drawn[0] != (seed, block):
            bits = np.random.Philox(key=key_of(seed, f"{self._prim_path} drift"), counter=block << 128)
            self._drawn = (seed, block), np.random.Generator(bits).standard_normal((_BLOCK, 12))
        numbers: Floats = self._drawn[1][row]
        return numbers
