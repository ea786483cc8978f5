"""ROS2PublishSemanticLabels and ROS2PublishObjectIdMap."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import pytest

from graphengine.nodes.ros2.labels import LabelPublisher, ROS2PublishObjectIdMap, ROS2PublishSemanticLabels
from graphengine.testing import RecordingContext
from tests.nodes.harness import computed


def published(cls: type[LabelPublisher], **inputs: Any) -> Any:
    """The JSON that a node publishes, without its time."""
    context = RecordingContext()
    computed(cls, context, time_stamp=1.25, **inputs)
    (message,) = context.transport.messages("/labels")
    found = json.loads(message.data)
    assert found.pop("time_stamp") == {"sec": 1, "nanosec": 250_000_000}
    return found


# isaacsim.ros2.nodes/nodes/OgnROS2PublishSemanticLabels.cpp, publishSemanticLabels
def test_labels_are_published_by_id_and_class_labels_as_classes() -> None:
    found = published(ROS2PublishSemanticLabels, ids=[0, 7], labels_in=["BACKGROUND", "class:cube"])
    assert found == {"0": "BACKGROUND", "7": {"class": "cube"}}


def test_labels_given_as_json_are_published_unchanged() -> None:
    text = '{"0": {"class": "BACKGROUND"}, "7": {"class": "cube"}}'
    assert published(ROS2PublishSemanticLabels, id_to_labels=text, ids=[3], labels_in=["no"]) == json.loads(text)


def test_without_labels_only_the_time_is_published() -> None:
    assert published(ROS2PublishSemanticLabels) == {}


@pytest.mark.parametrize(
    ("inputs", "fault"),
    [
        ({"ids": [1], "labels_in": []}, r"ids, labels must be of the same length, it is \[1, 0\]"),
        ({"id_to_labels": "{"}, "idToLabels must be JSON"),
        ({"id_to_labels": "[1]"}, "idToLabels must be a JSON object"),
    ],
)
def test_labels_that_do_not_fit_are_refused(inputs: dict[str, Any], fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        published(ROS2PublishSemanticLabels, **inputs)


def object_map(*entries: tuple[int, bytes]) -> np.ndarray[Any, Any]:
    """The layout that isaacsim.ros2.nodes/nodes/OgnROS2PublishObjectIdMap.cpp reads: entries, paths, number of entries."""
    heads, paths = b"", b""
    for number, path in entries:
        offset = len(entries) * 24 + len(paths)
        heads += number.to_bytes(16, "little") + struct.pack("<II", len(path), offset)
        paths += path
    return np.frombuffer(heads + paths + struct.pack("<I", len(entries)), np.uint8)


def test_an_object_id_map_has_the_prim_path_of_each_id() -> None:
    data = object_map((1, b"/World/cube\0"), (2**100 + 3, "/World/é".encode()))
    found = published(ROS2PublishObjectIdMap, data_ptr=data)
    assert found == {"id_to_labels": {"1": "/World/cube", str(2**100 + 3): "/World/é"}}


def test_without_a_buffer_the_object_id_map_is_empty() -> None:
    assert published(ROS2PublishObjectIdMap) == {"id_to_labels": {}}


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        (b"", "dataPtr must be a buffer long enough for 0 entries"),
        (b"\x01\0\0", "dataPtr must be a buffer long enough for 1 entries"),
        (b"\x02\0\0\0", "dataPtr must be a buffer long enough for 2 entries"),
        (
            bytes(16) + struct.pack("<III", 8, 24, 1),
            "dataPtr must be a buffer long enough for a path that ends at byte 32",
        ),
    ],
)
def test_a_truncated_object_id_map_is_refused(data: bytes, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        published(ROS2PublishObjectIdMap, data_ptr=data)
