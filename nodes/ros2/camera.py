"""The helper node that publishes a camera's images while the simulation plays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.camera import Camera, Picture
from graphengine.format.wording import listing
from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Context, ContextError, Float2, In, String, Token, UInt
from graphengine.nodes.ros2.boxes import DETECTIONS, DETECTIONS_3D, detections, detections_3d, loose_boxes, tight_boxes
from graphengine.nodes.ros2.helper import SkippingHelper
from graphengine.nodes.ros2.image import image
from graphengine.nodes.ros2.image_compression import COMPRESSED_IMAGE, ENCODINGS, JPEG_QUALITY, compressed
from graphengine.nodes.ros2.labels import labels_message
from graphengine.nodes.ros2.point_cloud import point_cloud

_SEGMENTED = ("instance_segmentation", "semantic_segmentation", "bbox_2d_tight", "bbox_2d_loose", "bbox_3d")
"""Values of the input `type` for which a segmentation image is rendered."""
_TYPES = ("rgb", "rgb_h264", "depth", "depth_pcl", *_SEGMENTED)
_IMAGE = "sensor_msgs/msg/Image"
_MESSAGES = {"rgb": _IMAGE, "depth": _IMAGE, "depth_pcl": "sensor_msgs/msg/PointCloud2"}
_MESSAGES |= {"instance_segmentation": _IMAGE, "semantic_segmentation": _IMAGE}
_MESSAGES |= {"bbox_2d_tight": DETECTIONS, "bbox_2d_loose": DETECTIONS, "bbox_3d": DETECTIONS_3D}
"""Message type for each available value of the input `type`."""


class ROS2CameraHelper(SkippingHelper, type="isaacsim.ros2.bridge.ROS2CameraHelper"):
    """Publishes a camera's images as Image, PointCloud2 or vision_msgs boxes, from the node's first execution until stop.

    The input `type` selects the message:

    - `rgb`: rgb8 image; if `compression` is set, a CompressedImage like those that compressed_image_transport publishes on
      IMAGE/compressed.
    - `depth`: 32FC1 image of distances along the optical axis, m; inf where no surface is hit.
    - `depth_pcl`: PointCloud2 of the depth image's points in the optical frame. By default, it is one row with the pixels that
      see a surface. If `organized` is true, it has the width and height of the image, and NaN where no surface is hit. If
      `colored` is true, each point has the field `rgb`.
    - `instance_segmentation`, `semantic_segmentation`: 32SC1 image, the same for both; each pixel holds the segmentation ID of
      the visible prim, 0 for the background.
    - `bbox_2d_tight`: a 2D box around the visible pixels of each prim; the world itself has no box.
    - `bbox_3d`: a 3D box around each prim that has a visible pixel. The box encloses the whole prim, is parallel to the prim's
      axes and is given in the optical frame.
    - `bbox_2d_loose`: for each box of `bbox_3d`, a 2D box around its projection.

    An image is published some ticks after its capture, with the time of the capture as stamp. Images are rendered only while the
    topic has subscribers.
    """

    frame_id: String = In(default="sim_camera", setup=True, doc="name of the camera's optical frame")
    topic_name: String = In(default="rgb", setup=True)
    type_in: Token = In(
        default="rgb", name="type", setup=True, tokens=_TYPES, doc=f"message to publish: {', '.join(_MESSAGES)}"
    )
    enable_semantic_labels: bool = In(
        default=False, setup=True, doc="publish the prim path of each segmentation ID on `semanticLabelsTopicName`"
    )
    semantic_labels_topic_name: String = In(default="semantic_labels", setup=True)
    stereo_offset: Float2 = In(
        default=(0.0, 0.0), doc="no effect: ROS2CameraInfoHelper computes the baseline from the poses of the cameras"
    )
    srtx_compression_type: String = In(default="hevc", doc="no effect: `compression` selects the format")
    compression: Token = In(
        default="", setup=True, extension=True, tokens=("", *ENCODINGS), doc="compression of rgb images; empty: none"
    )
    organized: bool = In(
        default=False,
        extension=True,
        doc="true: a point cloud has one point per pixel, in rows; false: it has only the pixels that see a surface",
    )
    colored: bool = In(default=False, extension=True, doc="true: each point of a point cloud has the field `rgb`")
    jpeg_quality: UInt = In(default=JPEG_QUALITY, ge=1, le=100, extension=True, doc="JPEG quality, 1 to 100")

    camera: Camera = Bound()
    publisher: Publisher = Bound()
    labels: Publisher | None = Bound()

    def setup(self, context: Context) -> None:
        """Look up the camera at `renderProductPath` and create the publishers of images and labels."""
        if self.type_in not in _MESSAGES:
            available = listing(_MESSAGES, "available types")
            raise ContextError(f"images of type {self.type_in!r} are not available", self.type_in, available)
        if self.compression and self.type_in != "rgb":
            what = f"images of type {self.type_in!r} cannot be compressed"
            raise ContextError(what, self.compression, "leave `compression` empty, or set `type` to rgb")
        super().setup(context)
        self.camera = context.device(Camera, self.render_product_path)
        kind = COMPRESSED_IMAGE if self.compression else _MESSAGES[self.type_in]
        self.publisher = self.open_for(context, self.camera, kind, self.topic_name, frame_id=self.frame_id)
        self.labels = None
        if self.enable_semantic_labels and self.type_in in _SEGMENTED:
            topic = self.semantic_labels_topic_name
            self.labels = self.open_for(context, self.camera, "std_msgs/msg/String", topic)
        elif self.enable_semantic_labels:
            context.log("warning", f"enableSemanticLabels has no effect: {self.type_in} has no labels")

    def update(self) -> None:
        """If there are subscribers, request the image that is due in this tick, and publish the image delivered in this tick."""
        labels = self.labels if self.labels is not None and self.labels.wanted else None
        if not self.publisher.wanted and labels is None:
            return
        if self.camera.due and not self.left_out(self.camera.index):
            self.camera.request(segmentation=self.type_in in _SEGMENTED)
        picture = self.camera.delivered()
        if picture is None or self.left_out(picture.index):
            return
        header = messages.header(self.stamp(picture.time), self.publisher.claim.frame_id)
        if self.publisher.wanted:
            message = self.message(header, picture)
            if message is not None:
                self.publisher.publish(message)
        if labels is not None:
            labels.publish(labels_message(self.classes(), header.stamp))

    def message(self, header: messages.Header, picture: Picture) -> Any:
        """Return the message that the input `type` selects; None if the message needs a segmentation that the image lacks."""
        size = picture.depth.shape[1], picture.depth.shape[0]
        if self.compression:
            pixels = np.ascontiguousarray(picture.rgb)
            return compressed(header, "rgb8", size, pixels, self.compression, self.jpeg_quality)
        if self.type_in == "rgb":
            return image(header, "rgb8", size, np.ascontiguousarray(picture.rgb))
        if self.type_in == "depth":
            return image(header, "32FC1", size, np.ascontiguousarray(picture.depth, "<f4"))
        if self.type_in == "depth_pcl":
            points = organized_points(picture.depth, self.camera.intrinsics)
            colours = {"Rgb": packed_colours(picture.rgb)} if self.colored else {}
            if not self.organized:
                seen = np.isfinite(picture.depth)
                points, colours = points[seen], {name: values[seen] for name, values in colours.items()}
            return point_cloud(header, points, colours)
        if picture.segmentation is None:
            return None
        if self.type_in == "bbox_2d_tight":
            return detections(header, tight_boxes(picture.segmentation))
        if self.type_in in ("bbox_2d_loose", "bbox_3d"):
            assert picture.boxes is not None  # they come with a segmentation
            seen = picture.boxes[np.isin(picture.boxes["semanticId"], picture.segmentation)]
            if self.type_in == "bbox_3d":
                return detections_3d(header, seen)
            return detections(header, loose_boxes(seen, self.camera.intrinsics, size, self.camera.clip[0]))
        return image(header, "32SC1", size, np.ascontiguousarray(picture.segmentation, "<i4"))

    def classes(self) -> dict[str, Any]:
        """Return a dict from each segmentation ID, as text, to `{"class": prim path}`; ID 0 has the class BACKGROUND."""
        paths = {0: "BACKGROUND", **self.camera.labels}
        return {str(number): {"class": path} for number, path in paths.items()}


def organized_points(depth: NDArray[np.float32], intrinsics: tuple[float, float, float, float]) -> NDArray[np.float32]:
    """Return the points of a depth image in the camera's optical frame, m, shape (height, width, 3); NaN without a surface.

    The optical frame has x right, y down and z forward. The point of a pixel (u, v) with depth z is
    z ((u - cx) / fx, (v - cy) / fy, 1).

    Args:
        depth: distance along the optical axis, m, shape (height, width); not finite where no surface is hit.
        intrinsics: fx, fy, cx, cy in pixels.
    """
    fx, fy, cx, cy = intrinsics
    height, width = depth.shape
    right = ((np.arange(width) - cx) / fx).astype(np.float32)
    down = ((np.arange(height) - cy) / fy).astype(np.float32)
    seen = np.where(np.isfinite(depth), depth, np.float32(np.nan))
    return np.stack([seen * right, seen * down[:, None], seen], axis=-1)


def packed_colours(rgb: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Return the colours of an image, shape (height, width, 3), as integers 0x00rrggbb, shape (height, width)."""
    red, green, blue = np.moveaxis(rgb.astype("<u4"), -1, 0)
    packed: NDArray[np.uint32] = (red << 16) | (green << 8) | blue
    return packed
