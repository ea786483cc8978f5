"""Measures the noise and bias of IMUs while a robot stands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from graphengine.api.session import Session
from graphengine.api.topics import Subscription
from graphengine.bringup.calibration.drive_recorder import REST, STILL, DriveRecorder
from graphengine.bringup.calibration.figures import Floats, ImuNoise
from graphengine.messages import messages

LARGEST_RATE = 10_000
"""Highest message rate of an IMU at which all messages are evaluated, Hz; at higher rates, the oldest messages are left out."""


def measure(sim: Session, topics: Sequence[str], drives: DriveRecorder, seconds: float) -> tuple[ImuNoise, ...]:
    """Let the robot stand for a time (s) and return the noise of each IMU with at least two messages."""
    subscriptions = [sim.subscribe(topic, keep=round(seconds * LARGEST_RATE)) for topic in topics]
    drives.begin()
    drives.drive(STILL, seconds)
    found = [_noise(subscription, seconds + REST) for subscription in subscriptions]
    for subscription in subscriptions:
        subscription.close()
    return tuple(imu for imu in found if imu is not None)


def _noise(subscription: Subscription[Any], duration: float) -> ImuNoise | None:
    received = subscription.messages
    if len(received) < 2:
        return None
    stamped = messages.seconds(received[-1].header.stamp) - messages.seconds(received[0].header.stamp)
    gyro, acceleration = (
        np.array([[getattr(getattr(one, name), axis) for axis in "xyz"] for one in received], dtype=float)
        for name in ("angular_velocity", "linear_acceleration")
    )
    return ImuNoise(
        subscription.topic,
        (len(received) - 1) / (stamped if stamped > 0.0 else duration),  # a graph may leave stamps at 0
        _largest_deviation(gyro),
        float(np.linalg.norm(gyro.mean(axis=0))),
        _largest_deviation(acceleration),
        float(np.linalg.norm(acceleration.mean(axis=0))),
    )


def _largest_deviation(samples: Floats) -> float:
    return float(samples.std(axis=0, ddof=1).max())
