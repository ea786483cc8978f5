"""An inertial measurement unit (IMU). It measures mean values over the time since its last sample.

So the integral of the samples gives the motion, and a shock between two samples is not missed. A contact that vibrates for one
physics step does not count as if it had lasted for the whole sample. Acceleration is the change of velocity per step in the world
frame, rotated to the sensor's frame; a difference of velocities in the rotating frame would lack the centripetal part.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graphengine.devices.imu import Imu, ImuSample
from graphengine.devices.rotation import Quaternion, Vector3, unrotate
from graphengine.physics.handles.motion_handles import CarriedPrim
from graphengine.physics.implementations import Deviation, Offsets, Profile, Rate, implements
from graphengine.physics.sensors.inertial_errors import (
    AccelerometerErrors,
    Drift,
    GyroscopeErrors,
    InertialErrors,
    TriadErrors,
)
from graphengine.physics.sensors.sampling import Sampling


class ImuProfile(Profile):
    """The parameters of an IMU: its rate, and its errors in SI units or in the units of data sheets."""

    rate: Rate = 100.0
    """Samples per second."""
    acceleration_noise: Deviation = 0.0
    """Standard deviation of the white noise of acceleration, m/s2."""
    angular_velocity_noise: Deviation = 0.0
    """Standard deviation of the white noise of angular velocity, rad/s."""
    acceleration_bias: Offsets = (0.0, 0.0, 0.0)
    """Constant bias of acceleration, m/s2."""
    angular_velocity_bias: Offsets = (0.0, 0.0, 0.0)
    """Constant bias of angular velocity, rad/s."""
    accelerometer: AccelerometerErrors | None = None
    """Errors of the accelerometer in the units of data sheets."""
    gyroscope: GyroscopeErrors | None = None
    """Errors of the gyroscope in the units of data sheets."""

    def facts(self) -> dict[str, Any]:
        """Return the parameters, with the errors of accelerometers and gyroscopes in SI units."""
        triads = [errors.in_si() if errors else TriadErrors() for errors in (self.accelerometer, self.gyroscope)]
        errors = tuple(triads) if self.accelerometer or self.gyroscope else None
        return self.model_dump(exclude={"accelerometer", "gyroscope"}) | {"errors": errors}


@dataclass(frozen=True, slots=True)
class _Mean:
    """A sample before noise; `values` are x, y and z of acceleration, gravity and angular velocity in the sensor's frame."""

    count: int
    """Number of ticks (or physics steps) from the start to the sample."""
    index: int
    values: tuple[float, ...]
    orientation: Quaternion
    duration: float = 0.0
    """Time over which the values are averaged, s."""


class _Samples:
    """Averages the measurements of physics steps to samples.

    An IMU has two objects of this class: one for graphs that run per tick, and one for graphs that run per physics step.

    Args:
        sampling: schedule of the samples, in ticks or steps.
        period: seconds per tick or step, as numerator and denominator.
        steps: number of physics steps per tick; 1 for a schedule in steps.
    """

    def __init__(self, sampling: Sampling, period: tuple[int, int], steps: int) -> None:
        self.sampling, self.period = sampling, period
        self._steps = steps
        self.reset()

    def reset(self) -> None:
        """Discard the newest sample and all measurements."""
        self.newest: _Mean | None = None
        self._sums, self._added = [0.0] * 9, 0

    def add(self, step: int, values: Sequence[float], orientation: Quaternion) -> None:
        """Add the measurements of a physics step, and complete a sample if one is due after this step."""
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

    Graphs that run per tick get at most one sample per tick; graphs that run per physics step may get more samples. The
    orientation is not averaged: it is the orientation at the time of the sample.
    """

    sees_steps = True
    kept = ("_by_step", "_by_tick", "_drift", "_orientation", "_sample", "_sampled", "_velocity")

    def _set_up(self) -> None:
        facts = self._prim.facts
        self.rate: float = facts["rate"]
        (seconds, ticks), steps = self._simulation.tick_period, self._simulation.substeps
        tick, step = (seconds, ticks), (seconds, ticks * steps)
        self._by_tick = _Samples(Sampling(self.rate, tick, self.prim_path), tick, steps)
        self._by_step = _Samples(Sampling(self.rate, step, self.prim_path), step, 1)
        self._noise = np.repeat((facts["acceleration_noise"], facts["angular_velocity_noise"]), 3)
        self._bias = np.array((*facts["acceleration_bias"], *facts["angular_velocity_bias"]), float)
        self._errors = InertialErrors(facts["errors"], self.rate, self.prim_path) if facts.get("errors") else None
        self._drift: Drift | None = None
        self._sample: ImuSample | None = None
        self._sampled: _Mean | None = None
        self.bind()  # the first motion measured is that from the present state
        self.see_displacement()

    def bind(self) -> None:
        """Look up the body that carries the unit, and the model's gravity, which graphs may change."""
        super().bind()
        self._gravity = self._simulation.model.opt.gravity

    def reset(self) -> None:
        """Discard all measurements, and continue from the current state."""
        self._by_tick.reset()
        self._by_step.reset()
        self._sampled = None
        self.see_displacement()

    def see_displacement(self) -> None:
        """Remember the current velocity and orientation as the values before the next step."""
        self._velocity, self._orientation = self.velocity()[0], self.pose()[1]

    def see_motion(self) -> None:
        """Add the measurements of a physics step.

        Acceleration and gravity are in the mean of the sensor's frames before and after the step, the angular velocity is in the
        frame after it.
        """
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
        """Whether a new sample is due in this tick or, for graphs that run per physics step, in this step."""
        if self._simulation.stepping:
            return self._by_step.sampling.due(self._simulation.steps)
        return self._by_tick.sampling.due(self._simulation.tick)

    def sample(self) -> ImuSample:
        """Return the newest sample; all callers in one tick or step get the same object."""
        samples = self._by_step if self._simulation.stepping else self._by_tick
        mean = samples.newest or self._at_rest()
        if self._sample is None or self._sampled is not mean:
            seconds, counts = samples.period
            self._sample, self._sampled = self._measured(mean, mean.count * seconds / counts), mean
        return self._sample

    def _upwards(self) -> Vector3:
        """Return gravity's contribution to the reading of an accelerometer, m/s2, in the world frame: gravity reversed."""
        x, y, z = self._gravity.tolist()
        return -x, -y, -z

    def _at_rest(self) -> _Mean:
        """Return the values that are reported before the first sample: the values of a unit without acceleration."""
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
    """Return a vector of the world frame in the mean of two rotated frames.

    The relative error is an eighth of the squared angle (rad) between the frames.
    """
    a, b, c = unrotate(before, vector)
    d, e, f = unrotate(after, vector)
    return (a + d) / 2, (b + e) / 2, (c + f) / 2
