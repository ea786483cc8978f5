"""Measures the noise and bias of IMUs while a robot stands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from graphengine.api.session import Session
from graphengine.api.topics import Subscription
from graphengine.bringup.calibration.drive_recorder import REST, STILL, DriveRecorder
from graphengine.bringup.calibration.figures import Floats, ImuNoise

LARGEST_RATE = 10_000
"""Highest message rate of an IMU, Hz, at which all messages are evaluated; at higher rates, the oldest messages are left out."""


def measure(sim: Session, topics: Sequence[str], drives: DriveRecorder, seconds: float) -> tuple[ImuNoise, ...]:
    """Let the robot stand for a time (s) and return the noise of each IMU; IMUs with fewer than two messages are left out."""
    subscriptions = [sim.subscribe(topic, keep=round(seconds * LARGEST_RATE)) for topic in topics]
    drives.begin()
    drives.drive(STILL, seconds)
    found = [_noise(subscription, seconds + REST) for subscription in subscriptions]
    for subscription in subscriptions:
        subscription.close()
    return tuple(imu for imu in found if imu is not None)


def _noise(subscription: Subscription[Any], seconds: float) -> ImuNoise | None:
    messages = subscription.messages
    if len(messages) < 2:
        return None
    stamped = _stamp(messages[-1]) - _stamp(messages[0])
    gyro, acceleration = (
        np.array([_components(getattr(message, name)) for message in messages])
        for name in ("angular_velocity", "linear_acceleration")
    )
    return ImuNoise(
        subscription.topic,
        (len(messages) - 1) / (stamped if stamped > 0.0 else seconds),  # a graph may leave stamps at 0
        _largest_deviation(gyro),
        float(np.linalg.norm(gyro.mean(axis=0))),
        _largest_deviation(acceleration),
        float(np.linalg.norm(acceleration.mean(axis=0))),
    )


def _stamp(message: Any) -> float:
    stamp = message.header.stamp
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def _components(vector: object) -> tuple[float, ...]:
    return tuple(float(getattr(vector, axis)) for axis in "xyz")


def _largest_deviation(samples: Floats) -> float:
    return float(samples.std(axis=0, ddof=1).max())
