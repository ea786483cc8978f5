"""ROS2PublishBbox2D, and boxes around the numbers of a segmentation."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

from graphengine.ros import messages
from graphengine.testing import RecordingContext
from nodes.ros2.boxes import BOX, ROS2PublishBbox2D, tight_boxes
from tests.nodes.harness import ready

pictures = arrays.arrays(np.int32, st.tuples(st.integers(0, 6), st.integers(0, 6)), elements=st.integers(0, 4))


@given(pictures)
def test_a_box_reaches_from_the_first_to_behind_the_last_pixel_of_its_number(picture: NDArray[np.int32]) -> None:
    expected = []
    for number in range(1, 5):
        pixels = [(u, v) for v, row in enumerate(picture.tolist()) for u, value in enumerate(row) if value == number]
        if pixels:
            across, down = zip(*pixels, strict=True)
            expected.append((number, min(across), min(down), max(across) + 1, max(down) + 1, 0.0))
    assert tight_boxes(picture).tolist() == expected


# isaacsim.ros2.core/library/backend/Ros2Message.cpp, Bbox2DData and writeBboxData
def test_a_box_is_published_by_its_middle_and_size() -> None:
    context = RecordingContext()
    data = struct.pack("<Iiiiif", 7, 10, 20, 15, 40, 0.5) + struct.pack("<Iiiiif", 9, -1, 0, 1, 2, 0.0)
    node = ready(ROS2PublishBbox2D, context, time_stamp=1.5, data=np.frombuffer(data, np.uint8))
    node.compute()
    (sent,) = context.transport.messages("/bbox2d")
    assert sent.header == messages.header(1.5, "sim_camera")
    boxes = [
        (d.bbox.center.position.x, d.bbox.center.position.y, d.bbox.size_x, d.bbox.size_y) for d in sent.detections
    ]
    assert boxes == [(12.5, 30.0, 5.0, 20.0), (0.0, 1.0, 2.0, 2.0)]
    hypotheses = [result.hypothesis for detection in sent.detections for result in detection.results]
    assert [(hypothesis.class_id, hypothesis.score) for hypothesis in hypotheses] == [("7", 1.0), ("9", 1.0)]
    messages.check(sent)


def test_boxes_of_a_segmentation_can_be_published_as_they_are() -> None:
    picture = np.zeros((4, 6), np.int32)
    picture[1:3, 2:5] = 3
    context = RecordingContext()
    ready(ROS2PublishBbox2D, context, data=tight_boxes(picture).view(np.uint8)).compute()
    (detection,) = context.transport.messages("/bbox2d")[0].detections
    center = detection.bbox.center.position
    assert (center.x, center.y, detection.bbox.size_x, detection.bbox.size_y) == (3.5, 2.0, 3.0, 2.0)


def test_without_boxes_an_empty_array_goes_out() -> None:
    context = RecordingContext()
    ready(ROS2PublishBbox2D, context).compute()
    assert context.transport.messages("/bbox2d")[0].detections == []


def test_bytes_that_are_no_whole_boxes_are_refused() -> None:
    node = ready(ROS2PublishBbox2D, RecordingContext(), data=np.zeros(BOX.itemsize + 1, np.uint8))
    with pytest.raises(ValueError, match="data has 25 bytes, a box has 24"):
        node.compute()
