"""An inertial measurement unit, which measures means over the time since its last sample.

So the integral of its samples gives the motion; a shock between two samples is not missed, and a contact that vibrates for one
physics step does not count as if it had lasted. Acceleration is the change of velocity per step in the world frame, rotated to
the sensor's frame: a difference of velocities in a rotating frame would lack the centripetal part.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from graphengine.devices.imu import Imu, ImuSample
from graphengine.devices.rotation import Quaternion, Vector3, unrotate
from graphengine.devices.stage import Prim
from graphengine.physics.dynamics.motion_handles import CarriedPrim
from graphengine.physics.sensors.implementations import Deviation, Offsets, Profile, Rate, implements
from graphengine.physics.sensors.inertial_errors import (
    AccelerometerErrors,
    Drift,
    GyroscopeErrors,
    InertialErrors,
    TriadErrors,
)
from graphengine.physics.sensors.sampling import Sampling

if TYPE_CHECKING:
    from graphengine.physics.core import SimulationCore


class ImuProfile(Profile):
    """An inertial measurement unit, with errors per sample and axis, and errors in the units of data sheets."""

    rate: Rate = Field(default=100.0, description="Samples a second.")
    acceleration_noise: Deviation = Field(default=0.0, description="Standard deviation of white noise, m/s2.")
    angular_velocity_noise: Deviation = Field(default=0.0, description="Standard deviation of white noise, rad/s.")
    acceleration_bias: Offsets = Field(default=(0.0, 0.0, 0.0), description="Constant bias of acceleration, m/s2.")
    angular_velocity_bias: Offsets = Field(
        default=(0.0, 0.0, 0.0), description="Constant bias of angular velocity, rad/s."
    )
    accelerometer: AccelerometerErrors | None = None
    gyroscope: GyroscopeErrors | None = None

    def facts(self) -> dict[str, Any]:
        """Return the figures, with the errors of accelerometers and gyroscopes in SI units."""
        triads = [errors.in_si() if errors else TriadErrors() for errors in (self.accelerometer, self.gyroscope)]
        errors = tuple(triads) if self.accelerometer or self.gyroscope else None
        return self.model_dump(exclude={"accelerometer", "gyroscope"}) | {"errors": errors}


@dataclass(frozen=True, slots=True)
class _Mean:
    """A sample before noise, in the sensor's frame: acceleration without gravity, the part of gravity, and angular velocity."""

    count: int
    """Ticks, or physics steps, since the start."""
    index: int
    values: tuple[float, ...]
    orientation: Quaternion
    duration: float = 0.0
    """Time over which the values are means, s."""


class _Samples:
    """The samples for graphs that run per tick, or for graphs that run per physics step.

    Args:
        sampling: schedule of the samples, in ticks or steps.
        period: seconds per tick or step, as numerator and denominator.
        steps: physics steps per tick or step.
    """

    def __init__(self, sampling: Sampling, period: tuple[int, int], steps: int) -> None:
        self.sampling, self.period = sampling, period
        self._steps = steps
        self.reset()

    def reset(self) -> None:
        """Restart sampling."""
        self.newest: _Mean | None = None
        self._sums, self._added = [0.0] * 9, 0

    def add(self, step: int, values: Sequence[float], orientation: Quaternion) -> None:
        """Add the measurements of a step."""
        self._sums = [total + value for total, value in zip(self._sums, values, strict=True)]
        self._added += 1
        count, rest = divmod(step, self._steps)
        if rest == 0 and self.sampling.due(count):
            mean = tuple(total / self._added for total in self._sums)
            seconds, counts = self.period
            duration = self._added * seconds / (counts * self._steps)
            self.newest = _Mean(count, self.sampling.newest(count), mean, orientation, duration)
            self._sums, self._added = [0.0] * 9, 0


@implements(Imu, ImuProfile)
class InertialUnit(CarriedPrim):
    """The IMU at a prim; the prim's `facts` are the values of its profile.

    Graphs that run per tick get samples of whole ticks; graphs that run per physics step may get more samples. Orientation is not
    averaged: it is the orientation at the time of the sample.
    """

    sees_steps = True
    kept = ("_by_step", "_by_tick", "_drift", "_orientation", "_sample", "_sampled", "_velocity")

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        facts = prim.facts
        self.rate: float = facts["rate"]
        seconds, ticks = simulation.tick_period
        steps = simulation.substeps
        tick, step = (seconds, ticks), (seconds, ticks * steps)
        self._by_tick = _Samples(Sampling(self.rate, tick, prim.path), tick, steps)
        self._by_step = _Samples(Sampling(self.rate, step, prim.path), step, 1)
        self._noise = np.repeat((facts["acceleration_noise"], facts["angular_velocity_noise"]), 3)
        self._bias = np.array((*facts["acceleration_bias"], *facts["angular_velocity_bias"]), float)
        self._errors = InertialErrors(facts["errors"], self.rate, prim.path) if facts.get("errors") else None
        self._drift: Drift | None = None
        self._sample: ImuSample | None = None
        self._sampled: _Mean | None = None
        super().__init__(simulation, prim)
        self.see_displacement()

    def bind(self) -> None:
        """Find the body that carries the unit, and read gravity, which may change."""
        super().bind()
        self._gravity = self._simulation.model.opt.gravity

    def reset(self) -> None:
        """Restart from the current state."""
        self._by_tick.reset()
        self._by_step.reset()
        self._sampled = None
        self.see_displacement()

    def see_displacement(self) -> None:
        """Start the next step from the pose at which the unit was placed."""
        self._velocity, self._orientation = self.velocity()[0], self.pose()[1]

    def see_motion(self) -> None:
        """Add the measurements of a step: change of velocity, gravity and rotation, in the sensor's frame halfway through it."""
        seconds, steps = self._by_step.period
        velocity, turning = self.velocity()
        orientation, rate = self.pose()[1], steps / seconds
        (x, y, z), (u, v, w) = velocity, self._velocity
        before, after = self._orientation, orientation
        acceleration = _halfway(before, after, ((x - u) * rate, (y - v) * rate, (z - w) * rate))
        gravity = _halfway(before, after, self._upwards())
        values = (*acceleration, *gravity, *unrotate(after, turning))
        self._velocity, self._orientation = velocity, orientation
        self._by_tick.add(self._simulation.steps, values, orientation)
        self._by_step.add(self._simulation.steps, values, orientation)

    @property
    def due(self) -> bool:
        """Return whether a new sample belongs to this tick; for graphs that run per physics step, to this step."""
        if self._simulation.stepping:
            return self._by_step.sampling.due(self._simulation.steps)
        return self._by_tick.sampling.due(self._simulation.tick)

    def sample(self) -> ImuSample:
        """Return the newest sample, the same for all callers in its tick or step."""
        samples = self._by_step if self._simulation.stepping else self._by_tick
        mean = samples.newest or self._at_rest()
        if self._sample is None or self._sampled is not mean:
            seconds, counts = samples.period
            self._sample, self._sampled = self._measured(mean, mean.count * seconds / counts), mean
        return self._sample

    def _upwards(self) -> Vector3:
        """Return what gravity adds to the reading of an accelerometer, m/s2, in the world frame."""
        x, y, z = self._gravity.tolist()
        return -x, -y, -z

    def _at_rest(self) -> _Mean:
        """Return the sample before the first one: the unit at rest."""
        turning, orientation = self.velocity()[1], self.pose()[1]
        gravity = unrotate(orientation, self._upwards())
        return _Mean(0, -1, (0.0, 0.0, 0.0, *gravity, *unrotate(orientation, turning)), orientation)

    def _measured(self, mean: _Mean, time: float) -> ImuSample:
        ax, ay, az, gx, gy, gz, wx, wy, wz = mean.values
        reading = np.array((ax, ay, az, wx, wy, wz)) + self._bias
        seed, noise, errors = self._simulation.seed, self._noise, self._errors
        if errors and mean.index >= 0:
            self._drift = errors.drift(seed, mean.index, self._drift)
            sensed = np.array((ax + gx, ay + gy, az + gz, wx, wy, wz))
            reading += errors.scale * sensed + self._drift.correlated + self._drift.walk
            noise = np.hypot(noise, errors.noise_density / math.sqrt(mean.duration))
        if noise.any() and mean.index >= 0:
            reading += noise * self._by_tick.sampling.random(seed, mean.index).standard_normal(6)
        ax, ay, az, wx, wy, wz = reading.tolist()
        return ImuSample(time, mean.index, (ax, ay, az), (gx, gy, gz), (wx, wy, wz), mean.orientation)


def _halfway(before: Quaternion, after: Quaternion, vector: Vector3) -> Vector3:
    """Return a vector of the world in the mean of two frames; the error is an eighth of the squared angle between them."""
    a, b, c = unrotate(before, vector)
    d, e, f = unrotate(after, vector)
    return (a + d) / 2, (b + e) / 2, (c + f) / 2
