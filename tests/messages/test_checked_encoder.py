"""What users publish: the same bytes and the same errors as building, checking and encoding each message anew."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest

from graphengine.messages import messages
from graphengine.messages.checked_encoder import CheckedEncoder
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.messages import Header, MessageError, Point, Time, Twist, Vector3
from graphengine.messages.plain import from_plain

TWIST, STAMPED, ODOM = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped", "nav_msgs/msg/Odometry"
SCAN, FLAG, BYTE, LONG = "sensor_msgs/msg/LaserScan", "std_msgs/msg/Bool", "std_msgs/msg/Byte", "std_msgs/msg/Int64"
SMALL, FLOAT = "std_msgs/msg/UInt8", "std_msgs/msg/Float32"


def anew(message: Any, message_type: str) -> bytes:
    """Encode a message without anything kept from earlier ones."""
    if isinstance(message, dict):
        message = from_plain(message, message_type)
    elif messages.message_type(message) != message_type:
        raise MessageError(f"expected {message_type}, got {messages.message_type(message)}")
    messages.check(message)
    return messages.encode(message)


def twist(x: Any = 0.5, linear: Any = None) -> Any:
    return Twist(linear or Vector3(x, 0.0, 0.0), Vector3(0.0, 0.0, 0.0))


def scan(ranges: Any) -> Any:
    made = DEFINITIONS.initial(SCAN)
    made.header, made.ranges = Header(Time(1, 2), "laser"), ranges
    return made


ROW = np.arange(8, dtype=np.float32)
GOOD: list[tuple[str, Any]] = [
    (TWIST, {}),
    (TWIST, {"linear": {"x": 0.5}, "angular": {"z": -1}}),
    (TWIST, {"angular": {"z": math.inf, "x": np.float64(0.1)}, "linear": {}}),
    (TWIST, twist()),
    (TWIST, twist(3)),
    (STAMPED, {"header": {"frame_id": "base"}, "twist": {"linear": {"x": 1.0}}}),
    (STAMPED, {"header": {"frame_id": "longer_name"}}),
    (ODOM, {"pose": {"covariance": [0.25] * 36}}),
    (SCAN, scan(ROW)),
    (SCAN, scan(2.0 * ROW)),
    (SCAN, scan(ROW[:3])),
    (FLAG, {"data": True}),
    (BYTE, {"data": 200}),
    (LONG, {"data": -(2**63)}),
    (SMALL, {"data": 255}),
    (FLOAT, {"data": 0.1}),
]
BAD: list[tuple[str, Any]] = [
    (TWIST, {"linear": {"x": "fast"}}),
    (TWIST, {"linear": {"x": True}}),
    (TWIST, {"linear": 0.5}),
    (TWIST, {"liner": {"x": 0.5}}),
    (TWIST, {"linear": {"x": None}}),
    (TWIST, {"linear": {"x": 10**400}}),
    (TWIST, {1: 2}),
    (TWIST, Vector3(0.0, 0.0, 0.0)),
    (TWIST, twist(linear=Point(0.0, 0.0, 0.0))),
    (TWIST, twist("fast")),
    (STAMPED, {"header": {"frame_id": 3}}),
    (SCAN, scan(np.arange(16, dtype=np.float32)[::2])),
    (SCAN, scan(ROW.astype(float))),
    (SCAN, scan([0.0])),
    (FLAG, {"data": 1}),
    (SMALL, {"data": 256}),
    (LONG, {"data": 2**63}),
    (FLOAT, {"data": 1e300}),
]


@pytest.fixture(scope="module")
def encoders() -> dict[str, CheckedEncoder]:
    """Encoders that have seen all good messages."""
    made = {kind: CheckedEncoder(kind, DEFINITIONS) for kind, _ in GOOD}
    for kind, message in GOOD:
        made[kind].encode(message)
    return made


@pytest.mark.parametrize(("kind", "message"), GOOD)
def test_the_checked_encoder_returns_the_bytes_of_the_general_encoder(
    encoders: dict[str, CheckedEncoder], kind: str, message: Any
) -> None:
    assert CheckedEncoder(kind, DEFINITIONS).encode(message) == anew(message, kind)
    assert encoders[kind].encode(message) == anew(message, kind)


@pytest.mark.parametrize(("kind", "message"), BAD)
def test_the_checked_encoder_raises_the_errors_of_the_general_encoder(
    encoders: dict[str, CheckedEncoder], kind: str, message: Any
) -> None:
    with pytest.raises(MessageError) as expected:
        anew(message, kind)
    with pytest.raises(MessageError) as caught:
        encoders[kind].encode(message)
    assert str(caught.value) == str(expected.value)


@pytest.mark.parametrize(("message", "most"), [({"linear": {"x": 0.5}, "angular": {"z": 0.1}}, 4), (twist(), 4)])
def test_encoding_a_twist_takes_few_function_calls(
    encoders: dict[str, CheckedEncoder], message: Any, most: int
) -> None:
    """A mapping: `encode`, and `_write` for it and its two parts. An object: its type, and the template."""
    calls: list[str] = []

    def count(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and Path(frame.f_code.co_filename).suffix != ".so":
            calls.append(frame.f_code.co_name)

    sys.setprofile(count)
    encoders[TWIST].encode(message)
    sys.setprofile(None)
    assert len(calls) <= most, calls
