"""The Protocol of inertial measurement units (IMUs), their samples, and an IMU stub for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from graphengine.devices.device import SampledSensor, Stub, device, when_due
from graphengine.devices.rotation import IDENTITY, Quaternion, Vector3


@dataclass(frozen=True, slots=True)
class ImuSample:
    """One sample of an IMU. Vectors are in the sensor's frame."""

    time: float
    """Simulation time of the measurement, s."""
    index: int
    """Sample index since the start of play; -1 before the first sample."""
    linear_acceleration: Vector3
    """Acceleration of the sensor without the contribution of gravity, m/s2; zero at rest."""
    gravity: Vector3
    """Contribution of gravity to the reading of an accelerometer, m/s2; (0, 0, 9.81) if the sensor is upright."""
    angular_velocity: Vector3
    """Angular velocity of the sensor, rad/s."""
    orientation: Quaternion
    """Orientation of the sensor in the world frame, as a quaternion (x, y, z, w)."""


class Imu(SampledSensor, Protocol):
    """An inertial measurement unit."""

    def sample(self) -> ImuSample:
        """Return the newest sample; all callers in a tick get the same object."""


@device("imu", Imu, usd="IsaacImuSensor", title="an imu", rank=3, in_rigs=True, sample=when_due("sample"))
class ImuStub(Stub):
    """An IMU for tests. It reports the sample that a test assigns to `measured`; initially, it is upright and at rest."""

    measured = ImuSample(0.0, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 9.81), (0.0, 0.0, 0.0), IDENTITY)

    def sample(self) -> ImuSample:
        """Return the value of `measured`."""
        return self.measured
