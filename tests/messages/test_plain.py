"""Messages as plain data and back."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from graphengine.messages import messages
from graphengine.messages.message_text import to_plain
from graphengine.messages.messages import MessageError
from graphengine.messages.plain import from_plain
from tests.messages.test_messages import TYPES, random_message, same

RANGE, TREE = "sensor_msgs/msg/Range", "tf2_msgs/msg/TFMessage"


@pytest.mark.parametrize("message_type", TYPES)
def test_every_message_survives_conversion_to_plain_data_and_json(message_type: str) -> None:
    draw = np.random.default_rng(11)
    for _ in range(3):
        message = random_message(message_type, draw)
        plain = to_plain(message)
        assert same(from_plain(plain, message_type), message)
        assert same(from_plain(json.loads(json.dumps(plain)), message_type), message)


def test_plain_data_have_the_fields_in_the_order_of_the_definition() -> None:
    transform = messages.Transform(messages.Vector3(1.0, 2.0, 3.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0))
    edge = messages.TransformStamped(messages.header(1.5, "odom"), "base", transform)
    assert json.dumps(to_plain(messages.TFMessage([edge]))) == (
        '{"transforms": [{"header": {"stamp": {"sec": 1, "nanosec": 500000000}, "frame_id": "odom"}, '
        '"child_frame_id": "base", "transform": {"translation": {"x": 1.0, "y": 2.0, "z": 3.0}, '
        '"rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}}]}'
    )


def test_missing_fields_get_the_defaults_of_ros() -> None:
    pose = from_plain({"position": {"x": 1}}, "geometry_msgs/msg/Pose")
    assert pose == messages.Pose(messages.Point(1.0, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0))


def test_bytes_are_0_to_255_in_plain_data_and_signed_in_messages() -> None:
    message = from_plain({"data": 200}, "std_msgs/msg/Byte")
    assert messages.encode(message)[4:] == b"\xc8\0\0\0"
    assert to_plain(message) == {"data": 200}
    several = from_plain({"data": [0, 200]}, "std_msgs/msg/ByteMultiArray")
    assert to_plain(several)["data"] == [0, 200]


def test_nan_and_infinite_numbers_survive_conversion_to_plain_data() -> None:
    plain = to_plain(from_plain({"range": math.nan, "max_range": math.inf}, RANGE))
    assert math.isnan(plain["range"])
    assert plain["max_range"] == math.inf


@pytest.mark.parametrize(
    ("message_type", "data", "fault"),
    [
        (RANGE, 3, "sensor_msgs/msg/Range must be a mapping of fields to values; got 3"),
        (RANGE, {"rnage": 1}, "sensor_msgs/msg/Range has no field 'rnage'; did you mean 'range'?"),
        (RANGE, {1: 1}, "has no field 1; fields: header, "),
        (RANGE, {"range": "1"}, "range must be of type float32; got '1'"),
        (RANGE, {"range": True}, "range must be of type float32; got true"),
        (RANGE, {"range": 1e39}, "range is 1e+39, not a float32"),
        (RANGE, {"range": 10**400}, "range must be of type float32; got 1000"),
        (RANGE, {"radiation_type": 256}, "radiation_type is 256, not a uint8"),
        (RANGE, {"radiation_type": 1.0}, "radiation_type must be of type uint8; got 1.0"),
        (RANGE, {"header": []}, "header: std_msgs/msg/Header must be a mapping of fields to values; got a list"),
        (RANGE, {"header": {"stamp": {"sec": 1.5}}}, "header.stamp.sec must be of type int32; got 1.5"),
        (RANGE, {"header": {"frame_id": None}}, "header.frame_id must be of type string; got nothing"),
        ("std_msgs/msg/Bool", {"data": 1}, "data must be of type bool; got 1"),
        ("std_msgs/msg/Byte", {"data": -1}, "data must be of type byte; got -1"),
        ("std_msgs/msg/UInt8MultiArray", {"data": [1, 300]}, "data[1] is 300, not a uint8"),
        ("std_msgs/msg/UInt8MultiArray", {"data": 1}, "data must be a list; got 1"),
        ("geometry_msgs/msg/PoseWithCovariance", {"covariance": [0.0]}, "covariance has 1 elements, not 36"),
        (TREE, {"transforms": [{}, {"header": 1}]}, "transforms[1].header: std_msgs/msg/Header must be a mapping"),
    ],
)
def test_an_error_names_the_field_or_the_element(message_type: str, data: Any, fault: str) -> None:
    with pytest.raises(MessageError) as caught:
        from_plain(data, message_type)
    assert fault in str(caught.value)
