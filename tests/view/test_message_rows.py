"""The rows of a message: every field has a path and a text, and large messages are cut."""

from __future__ import annotations

import math
import pickle
from pathlib import Path

import numpy as np

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.plain import from_plain
from graphengine.view.message_rows import MOST_ROWS, message_rows


def texts(message: object) -> dict[str, str]:
    """Texts of a message's rows by path."""
    kind = messages.message_type(message)
    return {row["path"]: row["text"] for row in message_rows(messages.encode(message, DEFINITIONS), kind, DEFINITIONS)}


def test_a_scan_is_shown_with_its_range_and_first_elements() -> None:
    scan = DEFINITIONS.initial("sensor_msgs/msg/LaserScan")
    scan.header.stamp.sec, scan.header.stamp.nanosec = 3, 250_000_000
    scan.ranges = np.array([math.inf, *np.linspace(1.0, 2.0, 100)], np.float32)
    found = texts(scan)
    assert found["header.stamp"] == "3.250000000 s"
    assert found["header"] == ""
    assert found["ranges"].startswith("1 to 2: inf, 1, 1.0101, ")
    assert found["ranges"].endswith(", …")
    assert found["intensities"] == "empty"


def test_elements_that_are_messages_have_rows_of_their_own_up_to_a_number() -> None:
    transform = {"child_frame_id": "wheel", "transform": {"translation": {"x": 0.5}}}
    message = from_plain({"transforms": [transform] * 12}, "tf2_msgs/msg/TFMessage")
    found = texts(message)
    assert found["transforms[7].child_frame_id"] == "wheel"
    assert found["transforms[0].transform.translation.x"] == "0.5"
    assert found["transforms[…]"] == "4 more"
    assert "transforms[8]" not in found


def test_a_message_has_a_bounded_number_of_rows() -> None:
    marker = {"points": [{"x": 1.0}] * 50, "colors": [{"r": 1.0}] * 50}
    message = from_plain({"markers": [marker] * 50}, "visualization_msgs/msg/MarkerArray")
    data = messages.encode(message, DEFINITIONS)
    rows = message_rows(data, "visualization_msgs/msg/MarkerArray", DEFINITIONS)
    assert len(rows) == MOST_ROWS + 1
    assert rows[-1]["text"] == f"more than {MOST_ROWS} fields"


def test_what_is_no_message_of_the_type_is_told() -> None:
    (row,) = message_rows(b"\x00\x01\x00\x00", "nav_msgs/msg/Odometry", DEFINITIONS)
    assert row["text"]


def test_the_shipped_definitions_stay_the_same_object_in_a_pickle() -> None:
    assert pickle.loads(pickle.dumps(DEFINITIONS)) is DEFINITIONS


def test_types_of_a_folder_are_read_again_by_another_process(tmp_path: Path) -> None:
    folder = tmp_path / "my_msgs" / "msg"
    folder.mkdir(parents=True)
    (folder / "Reading.msg").write_text("float64 value\n", encoding="utf-8")
    (folder.parent / "package.xml").write_text("<package><name>my_msgs</name></package>", encoding="utf-8")
    extended = DEFINITIONS.extended([folder.parent])
    copy = pickle.loads(pickle.dumps(extended))
    assert isinstance(copy, Definitions)
    reading = extended.initial("my_msgs/msg/Reading")
    reading.value = 2.5
    assert message_rows(messages.encode(reading, extended), "my_msgs/msg/Reading", copy)[0]["text"] == "2.5"
