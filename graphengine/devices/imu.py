"""Inertial measurement units: the Protocol and the stub."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from graphengine.devices.device import SampledSensor, Stub, device
from graphengine.devices.rotation import IDENTITY, Quaternion, Vector3


@dataclass(frozen=True, slots=True)
class ImuSample:
    """One measurement of an inertial measurement unit, in the sensor's frame."""

    time: float
    """Simulation time, s."""
    index: int
    """Number of this sample since play; -1 before the first."""
    linear_acceleration: Vector3
    """Acceleration of the sensor, without the contribution of gravity, m/s2."""
    gravity: Vector3
    """Contribution of gravity to the reading of an accelerometer, m/s2: (0, 0, 9.81) at rest and upright."""
    angular_velocity: Vector3
    """Angular velocity of the sensor, rad/s."""
    orientation: Quaternion
    """Orientation of the sensor in the world frame."""


class Imu(SampledSensor, Protocol):
    """An inertial measurement unit."""

    def sample(self) -> ImuSample:
        """Return the newest sample, shared by all callers in its tick."""


@device("imu", Imu, usd="IsaacImuSensor", title="an imu", rank=3, in_rigs=True)
class ImuStub(Stub):
    """An IMU whose sample tests write to `measured`; at first it is upright and at rest."""

    measured = ImuSample(0.0, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 9.81), (0.0, 0.0, 0.0), IDENTITY)

    def sample(self) -> ImuSample:
        """Return the sample set by the test."""
        return self.measured
