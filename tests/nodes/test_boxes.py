"""ROS2PublishBbox2D and ROS2PublishBbox3D, and boxes around the numbers of a segmentation."""

from __future__ import annotations

import itertools
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

from graphengine.devices.camera import BOX_3D
from graphengine.messages import messages
from graphengine.nodes.ros2.boxes import (
    BOX,
    BoxPublisher,
    ROS2PublishBbox2D,
    ROS2PublishBbox3D,
    loose_boxes,
    tight_boxes,
)
from graphengine.testing import RecordingContext
from tests.nodes.harness import computed, matrix, quaternion, ready, vector

pictures = arrays.arrays(np.int32, st.tuples(st.integers(0, 6), st.integers(0, 6)), elements=st.integers(0, 4))


@given(pictures)
def test_a_tight_box_encloses_all_pixels_with_its_segmentation_id(picture: NDArray[np.int32]) -> None:
    expected = []
    for number in range(1, 5):
        pixels = [(u, v) for v, row in enumerate(picture.tolist()) for u, value in enumerate(row) if value == number]
        if pixels:
            across, down = zip(*pixels, strict=True)
            expected.append((number, min(across), min(down), max(across) + 1, max(down) + 1, 0.0))
    assert tight_boxes(picture).tolist() == expected


# isaacsim.ros2.core/library/backend/Ros2Message.cpp, Bbox2DData and writeBboxData
def test_a_2d_box_is_published_as_centre_and_size(context: RecordingContext) -> None:
    data = struct.pack("<Iiiiif", 7, 10, 20, 15, 40, 0.5) + struct.pack("<Iiiiif", 9, -1, 0, 1, 2, 0.0)
    computed(ROS2PublishBbox2D, context, time_stamp=1.5, data=np.frombuffer(data, np.uint8))
    (sent,) = context.transport.messages("/bbox2d")
    assert sent.header == messages.header(1.5, "sim_camera")
    boxes = [
        (d.bbox.center.position.x, d.bbox.center.position.y, d.bbox.size_x, d.bbox.size_y) for d in sent.detections
    ]
    assert boxes == [(12.5, 30.0, 5.0, 20.0), (0.0, 1.0, 2.0, 2.0)]
    hypotheses = [result.hypothesis for detection in sent.detections for result in detection.results]
    assert [(hypothesis.class_id, hypothesis.score) for hypothesis in hypotheses] == [("7", 1.0), ("9", 1.0)]
    messages.check(sent)


def test_boxes_from_tight_boxes_can_be_published_directly(context: RecordingContext) -> None:
    picture = np.zeros((4, 6), np.int32)
    picture[1:3, 2:5] = 3
    ready(ROS2PublishBbox2D, context, data=tight_boxes(picture).view(np.uint8)).compute()
    (detection,) = context.transport.messages("/bbox2d")[0].detections
    center = detection.bbox.center.position
    assert (center.x, center.y, detection.bbox.size_x, detection.bbox.size_y) == (3.5, 2.0, 3.0, 2.0)


def published_3d(*records: Any, **inputs: Any) -> Any:
    """The message of records: number, corners low and high, rows of the transform."""
    context = RecordingContext()
    data = b"".join(struct.pack("<I6f16ff", *record, 0.5) for record in records)
    ready(ROS2PublishBbox3D, context, data=np.frombuffer(data, np.uint8), **inputs).compute()
    (message,) = context.transport.messages("/bbox3d")
    messages.check(message)
    return message


# isaacsim.ros2.core/library/tests/TestRos2BoundingBox3DMessage.cpp; its matrices have the translation in the last row
BOXES = (
    (1, -1, -1, -1, 1, 1, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1),
    (2, 0, 0, 0, 2, 2, 2, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 1, 1, 1),
)


def test_a_3d_box_is_published_as_centre_and_size() -> None:
    sent = published_3d(*BOXES, time_stamp=1.5)
    assert sent.header == messages.header(1.5, "sim_camera")
    assert [vector(d.bbox.center.position) for d in sent.detections] == [(0.0, 0.0, 0.0), (2.0, 2.0, 2.0)]
    assert [quaternion(d.bbox.center.orientation) for d in sent.detections] == [(0.0, 0.0, 0.0, 1.0)] * 2
    assert [vector(d.bbox.size) for d in sent.detections] == [(2.0, 2.0, 2.0)] * 2
    hypotheses = [result.hypothesis for detection in sent.detections for result in detection.results]
    assert [(hypothesis.class_id, hypothesis.score) for hypothesis in hypotheses] == [("1", 1.0), ("2", 1.0)]


finite = st.floats(-10.0, 10.0, width=16)
corners = st.tuples(st.floats(-5.0, -0.5, width=16), st.floats(0.5, 5.0, width=16))
quaternions = st.tuples(finite, finite, finite, finite).filter(lambda q: np.linalg.norm(q) > 0.1)


@given(
    quaternions, st.tuples(finite, finite, finite), st.tuples(corners, corners, corners), st.sampled_from([1.0, -1.0])
)
def test_a_published_3d_box_has_the_corners_of_its_record(q: Any, origin: Any, extent: Any, mirror: float) -> None:
    x, y, z, w = np.array(q) / np.linalg.norm(q)
    axes = np.array([0.5, 2.0, 3.0 * mirror])[:, None] * matrix((x, y, z, w)).T
    rows = np.eye(4)
    rows[:3, :3], rows[3, :3] = axes, origin
    low, high = zip(*extent, strict=True)
    (detection,) = published_3d((7, *low, *high, *rows.ravel())).detections
    expected = [np.array(corner) @ axes + origin for corner in itertools.product(*extent)]
    box = detection.bbox
    turn, middle, half = quaternion(box.center.orientation), vector(box.center.position), np.array(vector(box.size)) / 2
    found = [matrix(turn) @ (half * signs) + middle for signs in itertools.product((-1, 1), repeat=3)]
    assert all(min(np.linalg.norm(corner - other) for other in found) < 1e-4 for corner in expected)


INTRINSICS, SIZE, NEAR = (200.0, 200.0, 159.5, 119.5), (320, 240), 0.1
inside = st.lists(st.tuples(*[st.floats(0.0, 1.0)] * 3), min_size=1, max_size=20)


@given(quaternions, st.tuples(finite, finite, finite), st.tuples(corners, corners, corners), inside)
def test_a_loose_box_contains_every_visible_point_of_its_3d_box(q: Any, origin: Any, extent: Any, points: Any) -> None:
    x, y, z, w = np.array(q) / np.linalg.norm(q)
    solid = np.zeros(1, BOX_3D)
    solid["semanticId"] = 7
    solid["low"], solid["high"] = zip(*extent, strict=True)
    solid["transform"][0, :3, :3], solid["transform"][0, 3, :3] = matrix((x, y, z, w)).T, origin
    found = loose_boxes(solid, INTRINSICS, SIZE, NEAR)
    low, high, rows = (solid[name][0].astype(float) for name in ("low", "high", "transform"))
    for point in (low + np.array(points) * (high - low)) @ rows[:3, :3] + rows[3, :3]:
        if point[2] >= NEAR:
            across, down = point[:2] / point[2] * INTRINSICS[:2] + INTRINSICS[2:] + np.array(0.5)
            if 1e-6 < across < SIZE[0] - 1e-6 and 1e-6 < down < SIZE[1] - 1e-6:
                ((number, left, upper, right, lower, _),) = found.tolist()
                assert number == 7
                assert left - 1e-6 <= across <= right + 1e-6
                assert upper - 1e-6 <= down <= lower + 1e-6


@pytest.mark.parametrize("place", [(0.0, 0.0, -5.0), (90.0, 0.0, 5.0), (0.0, -90.0, 5.0)])
def test_3d_boxes_behind_the_camera_or_outside_the_image_have_no_loose_box(place: tuple[float, float, float]) -> None:
    solid = np.zeros(1, BOX_3D)
    solid["low"], solid["high"], solid["transform"] = -1.0, 1.0, np.eye(4)
    solid["transform"][0, 3, :3] = place
    assert len(loose_boxes(solid, INTRINSICS, SIZE, NEAR)) == 0
    assert len(loose_boxes(solid[:0], INTRINSICS, SIZE, NEAR)) == 0


@pytest.mark.parametrize("scale", [0.0, np.nan, np.inf])
def test_a_3d_box_without_volume_is_refused(scale: float) -> None:
    flat = (1, -1, -1, -1, 1, 1, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, scale, 0, 0, 0, 0, 1)
    with pytest.raises(ValueError, match="data must be a finite and invertible matrix in box 1"):
        published_3d(BOXES[0], flat)


publishers = pytest.mark.parametrize(("cls", "topic"), [(ROS2PublishBbox2D, "/bbox2d"), (ROS2PublishBbox3D, "/bbox3d")])


@publishers
def test_without_boxes_an_empty_array_is_published(
    cls: type[BoxPublisher], topic: str, context: RecordingContext
) -> None:
    ready(cls, context).compute()
    assert context.transport.messages(topic)[0].detections == []


@pytest.mark.parametrize(("cls", "size"), [(ROS2PublishBbox2D, BOX.itemsize), (ROS2PublishBbox3D, BOX_3D.itemsize)])
def test_data_that_is_not_a_whole_number_of_boxes_is_refused(cls: type[BoxPublisher], size: int) -> None:
    node = ready(cls, RecordingContext(), data=np.zeros(size + 1, np.uint8))
    with pytest.raises(
        ValueError, match=f"data must be a multiple of {size} bytes, the size of a box, it is {size + 1}"
    ):
        node.compute()
