"""Readers of single numbers, compared with the decoder."""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter
from typing import Any

import numpy as np
import pytest

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.field_reader import number_reader
from tests.messages.test_messages import random_message

TYPES = (
    "nav_msgs/msg/Odometry",
    "sensor_msgs/msg/BatteryState",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/NavSatFix",
    "sensor_msgs/msg/Range",
    "std_msgs/msg/Bool",
    "std_msgs/msg/Float64MultiArray",
    "std_msgs/msg/UInt8MultiArray",
)
ODOMETRY = "nav_msgs/msg/Odometry"


def numbers(message: Any) -> Iterator[str]:
    """The paths of all numbers of a message."""
    for name, _ in DEFINITIONS.fields(message.__msgtype__):
        value = getattr(message, name)
        if hasattr(value, "__msgtype__"):
            yield from (f"{name}.{rest}" for rest in numbers(value))
        elif isinstance(value, bool | int | float):
            yield name


@pytest.mark.parametrize("message_type", TYPES)
def test_each_number_has_the_value_that_the_decoder_gives(message_type: str) -> None:
    draw, read = np.random.default_rng(35), 0
    for _ in range(20):
        message = random_message(message_type, draw)
        data = messages.encode(message)
        decoded = messages.decode(data, message_type)
        for path in numbers(message):
            reader = number_reader(message_type, path)
            assert reader is not None
            np.testing.assert_equal(reader(data), attrgetter(path)(decoded))
            read += 1
    assert read


@pytest.mark.parametrize("path", ["header.frame_id", "pose.covariance", "pose", "twist.twist.linear.w", "header"])
def test_a_field_that_is_not_a_number_has_no_reader(path: str) -> None:
    assert number_reader(ODOMETRY, path) is None


def test_a_message_in_big_endian_is_decoded() -> None:
    reader = number_reader("geometry_msgs/msg/Point", "y")
    assert reader is not None
    assert reader(b"\0\0\0\0" + np.array([1.0, 2.0, 3.0], ">f8").tobytes()) == 2.0


def test_a_message_that_ends_too_early_or_has_a_wrong_length_is_refused() -> None:
    """The field itself is present in each shortened message."""
    reader = number_reader(ODOMETRY, "header.stamp.sec")
    assert reader is not None
    data = messages.encode(DEFINITIONS.initial(ODOMETRY))
    assert reader(data) == 0
    for damaged in (data[:-4], data[:100], data[:12] + b"\xff" * 4 + data[16:]):
        with pytest.raises(messages.MessageError):
            reader(damaged)
