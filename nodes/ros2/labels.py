"""Nodes that publish the labels of segmentation IDs and object IDs, as JSON in std_msgs/String."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from graphengine.format import bounded_json
from graphengine.messages import messages
from graphengine.node import BadValueError, Buffer, In, String, Tokens, UInt, UInts
from graphengine.nodes.checked import same_length
from graphengine.nodes.ros2.publisher import PublisherNode, stamp

_CLASS = "class:"
_ENTRY = np.dtype([("id", "<u8", 2), ("length", "<u4"), ("offset", "<u4")])
"""Entry of one object in a buffer: its 128-bit object ID, and the length and the offset of its prim path in the buffer."""


def labels_message(labels: Mapping[str, Any], stamp: messages.Time) -> messages.String:
    """Return a String message with one JSON object: the labels, and `time_stamp` with the stamp."""
    return messages.String(json.dumps({**labels, "time_stamp": {"sec": stamp.sec, "nanosec": stamp.nanosec}}))


class LabelPublisher(PublisherNode):
    """Base of nodes that publish labels as a JSON object; a subclass defines `labels`."""

    message_type: ClassVar[str] = "std_msgs/msg/String"

    topic_name: String = In(default="labels", setup=True)

    def message(self) -> messages.String:
        """Return the message with the labels and the time `timeStamp`."""
        return labels_message(self.labels(), stamp(self.time_stamp))

    def labels(self) -> dict[str, Any]:
        """Return the JSON object to publish, without the time stamp."""
        raise NotImplementedError


class ROS2PublishSemanticLabels(LabelPublisher, type="isaacsim.ros2.bridge.ROS2PublishSemanticLabels"):
    """Publishes the labels of segmentation IDs, from `idToLabels` if it is set, otherwise from `ids` and `labels`.

    A label in `labels` that begins with `class:`, such as `class:box`, is published as `{"class": "box"}`.
    """

    ids: UInts = In(doc="segmentation IDs that have labels")
    labels_in: Tokens = In(name="labels", doc="label of each ID in `ids`")
    semantics: Tokens = In(doc="no effect")
    id_to_labels: String = In(doc="JSON object with the label of each segmentation ID; overrides `ids` and `labels`")

    def labels(self) -> dict[str, Any]:
        """Return the label of each segmentation ID.

        Raises:
            BadValueError: `idToLabels` is not a JSON object, or `ids` and `labels` differ in length.
        """
        if self.id_to_labels:
            try:
                given = bounded_json.parse(self.id_to_labels)
            except ValueError as error:
                raise BadValueError("idToLabels", self.id_to_labels, "JSON") from error
            if not isinstance(given, dict):
                raise BadValueError("idToLabels", self.id_to_labels, "a JSON object")
            return given
        same_length(ids=self.ids, labels=self.labels_in)
        pairs = zip(self.ids.tolist(), self.labels_in, strict=True)
        return {str(number): _label(label) for number, label in pairs}


def _label(label: str) -> Any:
    return {"class": label.removeprefix(_CLASS)} if label.startswith(_CLASS) else label


class ROS2PublishObjectIdMap(LabelPublisher, type="isaacsim.ros2.bridge.ROS2PublishObjectIdMap"):
    """Publishes the prim path of each object ID in a point cloud.

    The prim paths come from a little-endian buffer. It begins with one entry per object: the object ID (16 bytes), the length of
    the path (4 bytes) and the offset of the path in the buffer (4 bytes). The paths follow. The last 4 bytes are the number of
    entries.
    """

    data_ptr: Buffer = In(default=0, doc="buffer with the prim path of each object ID")
    buffer_size: UInt = In(default=0, doc="no effect: the size is that of the buffer in `dataPtr`")

    def labels(self) -> dict[str, Any]:
        """Return `{"id_to_labels": paths}`: `paths` maps object IDs to prim paths, and is empty if there is no buffer."""
        return {"id_to_labels": {} if isinstance(self.data_ptr, int) else _paths(bytes(self.data_ptr))}


def _paths(data: bytes) -> dict[str, str]:
    entries = int.from_bytes(data[-4:], "little")
    if len(data) < 4 or entries * _ENTRY.itemsize > len(data) - 4:
        raise BadValueError("dataPtr", data, f"a buffer long enough for {entries} entries")
    found: dict[str, str] = {}
    for entry in np.frombuffer(data, _ENTRY, entries):
        low, high = map(int, entry["id"])
        begin, end = int(entry["offset"]), int(entry["offset"]) + int(entry["length"])
        if end > len(data):
            raise BadValueError("dataPtr", data, f"a buffer long enough for a path that ends at byte {end}")
        found[str(high << 64 | low)] = data[begin:end].partition(b"\0")[0].decode("utf-8", "replace")
    return found
