"""Boxes around what a camera sees."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.node import In
from graphengine.ros import messages
from graphengine.types import String, UChars
from nodes.ros2.publisher import SensorPublisher

DETECTIONS = "vision_msgs/msg/Detection2DArray"
BOX = np.dtype(
    [
        ("semanticId", "<u4"),
        ("x_min", "<i4"),
        ("y_min", "<i4"),
        ("x_max", "<i4"),
        ("y_max", "<i4"),
        ("occlusionRatio", "<f4"),
    ]
)
"""One box: its edges in pixels from the upper left corner of the picture, and the number of what is in it."""


def tight_boxes(segmentation: NDArray[np.int32]) -> NDArray[Any]:
    """The boxes around the pixels of each number but 0, in order of the numbers; what is hidden counts for nothing.

    Edges lie between pixels: a box around the pixel (u, v) alone reaches from u to u + 1 and from v to v + 1.

    Args:
        segmentation: a number for each pixel, shape (height, width), none below 0.
    """
    edges = np.zeros(int(segmentation.max(initial=0)) + 1, BOX)
    edges["semanticId"] = np.arange(len(edges))
    for pixels, low, high in ((segmentation.T, "x_min", "x_max"), (segmentation, "y_min", "y_max")):
        numbers, place = pixels.ravel(), np.repeat(np.arange(len(pixels)), pixels.shape[1])
        # Of several values for one number, the last stays.
        edges[low][numbers[::-1]] = place[::-1]
        edges[high][numbers] = place + 1
    return edges[1:][edges["x_max"][1:] > 0]


def detections(header: messages.Header, boxes: NDArray[Any]) -> Any:
    """A vision_msgs/Detection2DArray of boxes, each of which is what it is with certainty."""
    array, detection, box_2d, pose_2d, point_2d, result, hypothesis = map(_class, _PARTS)
    nowhere = messages.DEFINITIONS.initial("geometry_msgs/msg/PoseWithCovariance")
    found = []
    for number, left, top, right, bottom, _ in boxes.tolist():
        center = pose_2d(point_2d((left + right) / 2, (top + bottom) / 2), 0.0)
        box = box_2d(center, float(right - left), float(bottom - top))
        found.append(detection(header, [result(hypothesis(str(number), 1.0), nowhere)], box, ""))
    return array(header, found)


_PARTS = (
    "Detection2DArray",
    "Detection2D",
    "BoundingBox2D",
    "Pose2D",
    "Point2D",
    "ObjectHypothesisWithPose",
    "ObjectHypothesis",
)


def _class(name: str) -> type[Any]:
    return messages.message_class(f"vision_msgs/msg/{name}")


class ROS2PublishBbox2D(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishBbox2D"):
    """Publishes boxes in a picture as vision_msgs/Detection2DArray; the class of each is the number of what is in it.

    A box is a record of 24 bytes in little endian: its number (uint32), the edges left, top, right and bottom in pixels
    (int32), and a float32 that does not count.
    """

    message_type: ClassVar[str] = DETECTIONS

    frame_id: String = In(default="sim_camera", setup=True)
    topic_name: String = In(default="bbox2d", setup=True)
    data: UChars = In(doc="records, one after the other")

    def message(self) -> Any:
        """The boxes."""
        if len(self.data) % BOX.itemsize:
            raise ValueError(f"data has {len(self.data)} bytes, a box has {BOX.itemsize}")
        return detections(self.header(), np.ascontiguousarray(self.data).view(BOX))
