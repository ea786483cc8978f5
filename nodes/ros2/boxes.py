"""Nodes and functions that publish bounding boxes of the objects in a camera image, in 2D and 3D."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.camera import BOX_3D
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import BadValueError, In, String, UChars
from graphengine.nodes.ros2.publisher import SensorPublisher

DETECTIONS = "vision_msgs/msg/Detection2DArray"
DETECTIONS_3D = "vision_msgs/msg/Detection3DArray"
_EDGES_OF_A_BOX = [(edge, "<i4") for edge in ("x_min", "y_min", "x_max", "y_max")]
BOX = np.dtype([("semanticId", "<u4"), *_EDGES_OF_A_BOX, ("occlusionRatio", "<f4")])
"""Record of one 2D box: the segmentation ID of its object, its edges in pixels from the upper left corner of the image, and an
occlusion ratio, which is not used."""


def tight_boxes(segmentation: NDArray[np.int32]) -> NDArray[Any]:
    """Return a 2D box around the visible pixels of each object, as BOX records in ascending order of the segmentation IDs.

    Edges lie between pixels: a box around the single pixel (u, v) reaches from u to u + 1 and from v to v + 1.

    Args:
        segmentation: segmentation ID of the object in each pixel, 0 for no object, shape (height, width).
    """
    edges = np.zeros(int(segmentation.max(initial=0)) + 1, BOX)
    edges["semanticId"] = np.arange(len(edges))
    for pixels, low, high in ((segmentation.T, "x_min", "x_max"), (segmentation, "y_min", "y_max")):
        numbers, place = pixels.ravel(), np.repeat(np.arange(len(pixels)), pixels.shape[1])
        # If an ID occurs several times, its last value stays.
        edges[low][numbers[::-1]] = place[::-1]
        edges[high][numbers] = place + 1
    return edges[1:][edges["x_max"][1:] > 0]


_CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))
_EDGES = np.array([(a, b) for a, b in itertools.combinations(range(8), 2) if abs(_CORNERS[a] - _CORNERS[b]).sum() == 1])
"""The twelve edges of a box, as pairs of indices into _CORNERS, whose rows select the low (0) or high (1) x, y and z."""


def loose_boxes(
    solids: NDArray[Any], intrinsics: tuple[float, float, float, float], size: tuple[int, int], near: float
) -> NDArray[Any]:
    """Return a 2D box, as a BOX record, around the projection of each 3D box into the image; occlusion is ignored.

    3D boxes whose projection lies outside the image are left out.

    Args:
        solids: 3D boxes as BOX_3D records, in the camera's optical frame.
        intrinsics: fx, fy, cx, cy in pixels.
        size: width and height of the image, pixels.
        near: smallest visible distance along the optical axis, m.
    """
    low, high, transforms = (solids[name].astype(float)[:, None] for name in ("low", "high", "transform"))
    corners = (low + (high - low) * _CORNERS) @ transforms[:, 0, :3, :3] + transforms[:, :, 3, :3]
    begins, ends = corners[:, _EDGES[:, 0]], corners[:, _EDGES[:, 1]]
    before, behind = begins[..., 2:] - near, ends[..., 2:] - near
    crosses = before * behind < 0.0
    cuts = begins + np.divide(before, before - behind, out=np.zeros_like(before), where=crosses) * (ends - begins)
    points = np.concatenate([corners, cuts], axis=1)
    seen = np.concatenate([corners[..., 2:] >= near, crosses], axis=1)
    # Pixel u reaches from u - 1/2 to u + 1/2, and in a box from u to u + 1.
    places = points[..., :2] / np.where(seen, points[..., 2:], 1.0) * intrinsics[:2] + intrinsics[2:] + np.array(0.5)
    first = np.where(seen, np.floor(places), np.inf).min(axis=1).clip(0, size)
    last = np.where(seen, np.ceil(places), -np.inf).max(axis=1).clip(0, size)
    found = np.zeros(len(solids), BOX)
    found["semanticId"] = solids["semanticId"]
    (found["x_min"], found["y_min"]), (found["x_max"], found["y_max"]) = first.T, last.T
    within: NDArray[Any] = found[(first < last).all(axis=1)]
    return within


def detections(header: messages.Header, boxes: NDArray[Any]) -> Any:
    """Return a vision_msgs/Detection2DArray with a detection of score 1 for each BOX record."""
    array, detection, box_2d, pose_2d, point_2d = map(
        _class, ("Detection2DArray", "Detection2D", "BoundingBox2D", "Pose2D", "Point2D")
    )
    found = []
    for number, left, top, right, bottom, _ in boxes.tolist():
        center = pose_2d(point_2d((left + right) / 2, (top + bottom) / 2), 0.0)
        box = box_2d(center, float(right - left), float(bottom - top))
        found.append(detection(header, _results(number), box, ""))
    return array(header, found)


def detections_3d(header: messages.Header, boxes: NDArray[Any]) -> Any:
    """Return a vision_msgs/Detection3DArray with a detection of score 1 for each BOX_3D record.

    Raises:
        BadValueError: the matrix of a box is singular or not finite.
    """
    array, detection, box_3d = map(_class, ("Detection3DArray", "Detection3D", "BoundingBox3D"))
    low, high, transforms = (boxes[name].astype(float) for name in ("low", "high", "transform"))
    axes, origins = transforms[:, :3, :3], transforms[:, 3, :3]
    volumes = np.linalg.det(np.where(np.isfinite(transforms).all(axis=(1, 2), keepdims=True), axes, 0.0))
    unfit = np.flatnonzero(volumes == 0.0)
    if len(unfit):
        raise BadValueError("data", transforms[unfit[0]].tolist(), f"a finite and invertible matrix in box {unfit[0]}")
    scales = np.linalg.norm(axes, axis=2)
    centers = origins + np.einsum("ni,nij->nj", (low + high) / 2, axes)
    # A box is the same when it is mirrored, but no quaternion is a mirror.
    turns = _quaternions(axes / scales[:, :, None] * np.sign(volumes)[:, None, None])
    found = []
    for number, center, turn, size in zip(
        boxes["semanticId"].tolist(), centers.tolist(), turns.tolist(), ((high - low) * scales).tolist(), strict=True
    ):
        pose = messages.Pose(messages.Point(*center), messages.Quaternion(*turn))
        found.append(detection(header, _results(number), box_3d(pose, messages.Vector3(*size)), ""))
    return array(header, found)


def _quaternions(axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation of each matrix: the rotation that brings the axes x, y and z closest to the rows of the matrix.

    Rotations are unit quaternions (x, y, z, w) with w >= 0. Each quaternion is the eigenvector for the largest eigenvalue of a
    symmetric matrix (Bar-Itzhack, J. Guidance 23, 2000).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = axes.transpose(1, 2, 0)
    symmetric = [
        [xx - yy - zz, yx + xy, zx + xz, yz - zy],
        [yx + xy, yy - xx - zz, zy + yz, zx - xz],
        [zx + xz, zy + yz, zz - xx - yy, xy - yx],
        [yz - zy, zx - xz, xy - yx, xx + yy + zz],
    ]
    found: NDArray[np.float64] = np.linalg.eigh(np.array(symmetric).transpose(2, 0, 1))[1][:, :, 3]
    return np.where(found[:, 3:] < 0.0, -found, found)


def _results(number: int) -> list[Any]:
    hypothesis = _class("ObjectHypothesis")(str(number), 1.0)
    nowhere = DEFINITIONS.initial("geometry_msgs/msg/PoseWithCovariance")
    return [_class("ObjectHypothesisWithPose")(hypothesis, nowhere)]


def _class(name: str) -> type[Any]:
    return messages.message_class(f"vision_msgs/msg/{name}")


class BoxPublisher(SensorPublisher):
    """Base of nodes that publish bounding boxes from packed records.

    A subclass defines `record`, the dtype of a box, and `make`, which builds the message from a header and the boxes.
    """

    record: ClassVar[np.dtype[Any]]
    make: ClassVar[Callable[[messages.Header, NDArray[Any]], Any]]

    frame_id: String = In(default="sim_camera", setup=True)
    data: UChars = In(doc="bounding boxes as packed little-endian records, one per object")

    def message(self) -> Any:
        """Return the message with the boxes in `data`."""
        size = self.record.itemsize
        if len(self.data) % size:
            raise BadValueError("data", len(self.data), f"a multiple of {size} bytes, the size of a box")
        return type(self).make(self.header(), np.ascontiguousarray(self.data).view(self.record))


class ROS2PublishBbox2D(BoxPublisher, type="isaacsim.ros2.bridge.ROS2PublishBbox2D"):
    """Publishes 2D boxes in an image as vision_msgs/Detection2DArray; the class ID of a detection is its segmentation ID.

    In `data`, a box is a little-endian record of 24 bytes: the segmentation ID (uint32), the left, top, right and bottom edge in
    pixels (int32 each), and a float32 that is ignored.
    """

    message_type: ClassVar[str] = DETECTIONS
    record: ClassVar[np.dtype[Any]] = BOX
    make = detections

    topic_name: String = In(default="bbox2d", setup=True)


class ROS2PublishBbox3D(BoxPublisher, type="isaacsim.ros2.bridge.ROS2PublishBbox3D"):
    """Publishes 3D boxes as vision_msgs/Detection3DArray; the class ID of a detection is its segmentation ID.

    In `data`, a box is a little-endian record of 96 bytes: the segmentation ID (uint32), two opposite corners of the box in its
    own frame (3 float32 each), a 4x4 matrix (16 float32) whose rows are the axes and the origin of this frame in the frame
    `frameId`, and a float32 that is ignored. The published centre is the midpoint of the corners; Isaac Sim publishes the origin
    of the box's own frame instead.
    """

    message_type: ClassVar[str] = DETECTIONS_3D
    record: ClassVar[np.dtype[Any]] = BOX_3D
    make = detections_3d

    topic_name: String = In(default="bbox3d", setup=True)
