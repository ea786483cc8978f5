from __future__ import annotations

import contextlib
import math
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_typestore

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.interfaces import TEXTS, MessageTypeError
from graphengine.messages.messages import MessageError, decode, encode, stamp

JAZZY = get_typestore(Stores.ROS2_JAZZY)
TYPES = [name for name in DEFINITIONS.names() if DEFINITIONS.definition(name).is_message]


# isaacsim.ros2.core/library/backend/Ros2Backend.cpp
@pytest.mark.parametrize(
    ("seconds", "sec", "nanosec"),
    [
        (0.1, 0, 100_000_000),
        (0.016666666666666666, 0, 16_666_666),
        (-0.5, -1, 500_000_000),
        (0.0, 0, 0),
        (-1e-10, 0, 0),
        (2147483647.0, 2147483647, 0),
    ],
)
def test_a_stamp_is_truncated_and_its_nanoseconds_are_never_negative(seconds: float, sec: int, nanosec: int) -> None:
    assert stamp(seconds) == messages.Time(sec, nanosec)
    assert messages.header(seconds, "odom") == messages.Header(messages.Time(sec, nanosec), "odom")


@pytest.mark.parametrize("seconds", [math.nan, math.inf, -math.inf, 2147483648.0, -2147483649.0])
def test_a_stamp_that_does_not_fit_is_an_error(seconds: float) -> None:
    with pytest.raises(MessageError, match="32 bits"):
        stamp(seconds)


# The layout is that of XCDR1 in DDS-XTypes 1.3, 7.4.1: little endian, primitives aligned to their own size.
def test_bytes_are_little_endian_xcdr1_padded_to_words() -> None:
    assert encode(messages.Clock(messages.Time(1, 2))) == b"\0\1\0\0" + struct.pack("<iI", 1, 2)
    assert encode(messages.String("hi")) == b"\0\1\0\0" + struct.pack("<I3sx", 3, b"hi\0")
    transform = messages.Transform(messages.Vector3(1.0, 2.0, 3.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0))
    edge = messages.TransformStamped(messages.header(0.5, "odom"), "base", transform)
    # One element; its stamp, "odom", "base" with what aligns them, then up to the next multiple of 8.
    head = struct.pack("<IiII5s3xI5s3x", 1, 0, 500_000_000, 5, b"odom\0", 5, b"base\0")
    assert len(head) == 36
    padded = head + bytes(4) + struct.pack("<7d", 1, 2, 3, 0, 0, 0, 1)
    assert encode(messages.TFMessage([edge])) == b"\0\1\0\0" + padded


def test_every_message_that_is_exported_has_its_ros_name() -> None:
    for name, exported in vars(messages).items():
        if hasattr(exported, "__msgtype__"):
            assert exported.__msgtype__.rpartition("/")[2] == name
            assert messages.message_class(exported.__msgtype__) is exported


def test_an_unknown_type_is_an_error_with_a_suggestion() -> None:
    for ask in (messages.message_class, DEFINITIONS.type_hash, lambda name: decode(b"", name)):
        with pytest.raises(MessageTypeError, match="did you mean 'Odometry'"):
            ask("nav_msgs/msg/Odometri")


def random_message(message_type: str, draw: np.random.Generator, definitions: Definitions = DEFINITIONS) -> Any:
    """A message with something in every field, from all that it can hold."""

    def value(description: Any) -> Any:
        kind, detail = description
        if kind == Nodetype.NAME:
            return random_message(detail, draw, definitions)
        if kind == Nodetype.BASE:
            if detail[0] in TEXTS:
                letters, most = ("aé/_ ", 7) if not detail[1] else ("ab/_ ", min(7, detail[1]))  # a bound is of bytes
                return "".join(draw.choice(list(letters), size=draw.integers(0, most, endpoint=True)))
            return array(detail[0], 1)[0].item()
        element, count = detail
        length = count if kind == Nodetype.ARRAY else int(draw.integers(0, min(4, count or 4), endpoint=True))
        if element[0] == Nodetype.BASE and element[1][0] not in TEXTS:
            return array(element[1][0], length)
        return [value(element) for _ in range(length)]

    def array(name: str, length: int) -> Any:
        dtype = np.dtype({"byte": "int8", "char": "uint8"}.get(name, name))
        if dtype.kind == "b":
            return draw.integers(0, 2, length).astype(bool)
        if dtype.kind == "f":
            return (draw.normal(size=length) * 10.0 ** draw.integers(-30, 30, length)).astype(dtype)
        whole = np.iinfo(dtype)
        return draw.integers(whole.min, whole.max, length, dtype, endpoint=True)

    return definitions.message_class(message_type)(*(value(field) for _, field in definitions.fields(message_type)))


def same(a: Any, b: Any) -> bool:
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    if hasattr(a, "__msgtype__"):
        return type(a) is type(b) and all(same(getattr(a, name), getattr(b, name)) for name in vars(a))
    return bool(a == b)


@pytest.mark.parametrize("message_type", TYPES)
def test_every_type_is_decoded_to_an_equal_message(message_type: str) -> None:
    draw = np.random.default_rng(7)
    for _ in range(5):
        message = random_message(message_type, draw)
        messages.check(message)
        data = encode(message)
        assert isinstance(data, bytes)
        assert len(data) % 4 == 0
        if message_type in JAZZY.types:  # rosbags' own encoder, on which this one is built, and padding
            plain = bytes(JAZZY.serialize_cdr(message, message_type, little_endian=True))
            assert data == plain + bytes(-len(plain) % 4)
        assert same(decode(data, message_type), message)


def test_messages_of_big_endian_peers_are_read() -> None:
    data = b"\0\0\0\0" + struct.pack(">iI", 1, 2)
    assert decode(data, "rosgraph_msgs/msg/Clock") == messages.Clock(messages.Time(1, 2))


FUZZED = [
    "rosgraph_msgs/msg/Clock",
    "tf2_msgs/msg/TFMessage",
    "sensor_msgs/msg/JointState",
    "rcl_interfaces/msg/ParameterEvent",
]


@given(st.sampled_from(FUZZED), st.binary(max_size=200))
def test_any_bytes_decode_or_raise_one_error(message_type: str, data: bytes) -> None:
    for candidate in (data, b"\0\1\0\0" + data):
        with contextlib.suppress(MessageError):
            decode(candidate, message_type)


@settings(max_examples=300)
@given(st.sampled_from(TYPES), st.integers(0, 2**32), st.data())
def test_damaged_messages_decode_or_raise_one_error(message_type: str, seed: int, data: st.DataObject) -> None:
    damaged = bytearray(encode(random_message(message_type, np.random.default_rng(seed))))
    for _ in range(data.draw(st.integers(1, 4))):
        position = data.draw(st.integers(0, len(damaged) - 1))
        damaged[position] = data.draw(st.sampled_from([0, 1, 0x7F, 0x80, 0xFF]))
    cut = data.draw(st.integers(0, len(damaged)))
    for candidate in (bytes(damaged), bytes(damaged[:cut])):
        with contextlib.suppress(MessageError):
            decode(candidate, message_type)


def test_bytes_after_a_message_are_ignored_as_in_ros_2() -> None:
    message = DEFINITIONS.initial("sensor_msgs/msg/JointState")
    message.name = ["a"]
    # Fast DDS encodes so, where a sequence of numbers of eight bytes is empty (rmw_serialize.cpp of rmw_fastrtps_cpp).
    assert same(decode(encode(message) + b"rubbish!", "sensor_msgs/msg/JointState"), message)


def test_bytes_that_cannot_be_decoded_raise_an_error_with_the_type() -> None:
    with pytest.raises(TransportError, match="3 bytes cannot be decoded as rosgraph_msgs/msg/Clock"):
        decode(b"\0\1\0", "rosgraph_msgs/msg/Clock")


ORIGIN = messages.Pose(messages.Point(0.0, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0))


def scan(**changed: Any) -> messages.LaserScan:
    arrays = {"ranges": np.zeros(3, np.float32), "intensities": np.zeros(3, np.float32)} | changed
    start = arrays.pop("angle_min", 0.0)
    head = arrays.pop("header", messages.header(0.0, "lidar"))
    return messages.LaserScan(head, start, 1.0, 0.5, 0.0, 0.1, 0.1, 10.0, **arrays)


@pytest.mark.parametrize(
    ("message", "fault"),
    [
        (scan(ranges=[1.0, 2.0]), "sensor_msgs/msg/LaserScan.ranges is list, not a numpy array of float32"),
        (scan(ranges=np.zeros((2, 2), np.float32)), "ranges is a 2-dimensional array of float32, not a row of float32"),
        (scan(ranges=np.zeros(6, np.float32)[::2]), "ranges is a non-contiguous 1-dimensional array"),
        (scan(angle_min="0"), "sensor_msgs/msg/LaserScan.angle_min is '0', not a float32"),
        (scan(header=None), "sensor_msgs/msg/LaserScan.header is NoneType, not std_msgs/msg/Header"),
        (messages.String(3), "std_msgs/msg/String.data is int, not str"),  # type: ignore[arg-type]
        (messages.Time(2**31, 0), "builtin_interfaces/msg/Time.sec is 2147483648, not a int32"),
        (messages.TFMessage([messages.String("x")]), "TFMessage.transforms[0] is std_msgs__msg__String, not geometry"),  # type: ignore[list-item]
        (messages.PoseWithCovariance(ORIGIN, np.zeros(35)), "PoseWithCovariance.covariance has 35 elements, not 36"),
        (3, "int is not a ROS message"),
    ],
)
def test_an_error_names_the_field_that_is_wrong(message: Any, fault: str) -> None:
    for refuse in (encode, messages.check):
        with pytest.raises(MessageError) as caught:
            refuse(message)
        assert fault in str(caught.value)


def test_check_detects_an_array_of_the_wrong_type_and_encode_does_not() -> None:
    message = scan(ranges=np.zeros(3, np.int32))
    encode(message)
    with pytest.raises(MessageError, match="array of int32, not a row of float32"):
        messages.check(message)
