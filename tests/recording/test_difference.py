"""Fields that differ are told by name and index, with both values."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.recording.difference import differences


def scan(*ranges: float, frame: str = "lidar") -> Any:
    found = DEFINITIONS.initial("sensor_msgs/msg/LaserScan")
    found.header = messages.header(1.0, frame)
    found.ranges = np.array(ranges, np.float32)
    return found


def pose(x: float, w: float = 1.0) -> Any:
    return messages.Pose(messages.Point(x, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, w))


def transforms(*children: str) -> Any:
    identity = messages.Transform(messages.Vector3(0.0, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0))
    return messages.TFMessage(
        [messages.TransformStamped(messages.header(0.0, "odom"), child, identity) for child in children]
    )


def told(recorded: Any, replayed: Any) -> list[str]:
    pair = messages.encode(recorded), messages.encode(replayed)
    return [str(found) for found in differences(*pair, messages.message_type(recorded))]


def test_a_nested_field_has_its_full_name() -> None:
    assert told(pose(1.0), pose(1.0000000000000002)) == [
        "position.x: recorded 1.0, replayed 1.0000000000000002",
    ]


def test_every_field_that_differs_is_reported() -> None:
    assert told(pose(1.0), pose(2.0, 0.5)) == [
        "position.x: recorded 1.0, replayed 2.0",
        "orientation.w: recorded 1.0, replayed 0.5",
    ]


def test_the_first_different_element_of_an_array_is_reported_with_the_number_of_others() -> None:
    assert told(scan(1, 2, 3, 4), scan(1, 5, 3, 6)) == [
        "ranges[1]: recorded 2.0, replayed 5.0 (and 1 more of 4 elements)"
    ]


def test_arrays_of_different_lengths_are_reported_with_both_lengths() -> None:
    assert told(scan(1, 2), scan(1, 2, 3)) == ["len(ranges): recorded 2, replayed 3"]


def test_text_is_reported_in_quotes() -> None:
    assert told(scan(frame="a"), scan(frame="b")) == ["header.frame_id: recorded 'a', replayed 'b'"]


def test_messages_in_a_list_have_an_index() -> None:
    assert told(transforms("a", "b"), transforms("a", "c")) == [
        "transforms[1].child_frame_id: recorded 'b', replayed 'c'"
    ]
    assert told(transforms("a"), transforms("a", "b")) == ["len(transforms): recorded 1, replayed 2"]


def test_equal_infinities_and_nans_are_no_difference() -> None:
    assert told(scan(math.inf, math.nan, 1), scan(math.inf, math.nan, 2)) == ["ranges[2]: recorded 1.0, replayed 2.0"]


def test_zero_differs_from_negative_zero() -> None:
    assert told(pose(0.0), pose(-0.0)) == ["position.x: recorded 0.0, replayed -0.0"]
    assert told(scan(0.0), scan(-0.0)) == ["ranges[0]: recorded 0.0, replayed -0.0"]


@pytest.mark.parametrize(
    ("recorded", "replayed", "expected"),
    [
        (b"\0\1\0\0\5\0\0\0abc", b"\0\1\0\0\5\0\0\0abd", "byte 10 of 11: recorded 0x63, replayed 0x64"),
        (b"\0\1\0\0", b"\0\1\0\0\0", "size: recorded 4 bytes, replayed 5 bytes"),
    ],
)
def test_undecodable_messages_are_compared_byte_by_byte(recorded: bytes, replayed: bytes, expected: str) -> None:
    assert [str(found) for found in differences(recorded, replayed, "std_msgs/msg/String")] == [expected]


def test_a_difference_in_cdr_padding_is_reported_as_a_byte() -> None:
    data = messages.encode(messages.String("a"))
    changed = data[:-1] + b"\7"
    assert len(data) % 4 == 0
    assert [str(found) for found in differences(data, changed, "std_msgs/msg/String")] == [
        f"byte {len(data) - 1} of {len(data)}: recorded 0x00, replayed 0x07"
    ]


def test_messages_of_unknown_types_are_compared_byte_by_byte() -> None:
    assert [found.field for found in differences(b"a", b"b", "my_msgs/msg/Unknown")] == ["byte 0 of 1"]
