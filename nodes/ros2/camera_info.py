"""Nodes that publish the calibration of cameras as sensor_msgs/CameraInfo."""

from __future__ import annotations

import functools
from collections import deque
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.camera import Camera
from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher
from graphengine.node import BadValueError, Bound, Context, ContextError, In, State
from graphengine.node.types import Doubles, Floats, String, Token, UInt, read_only
from graphengine.nodes.ros2.helper import SkippingHelper
from graphengine.nodes.ros2.publisher import SensorPublisher

_NO_DISTORTION = read_only(np.zeros(5))
_PARALLEL = 1e-3
"""Largest angle between the optical axes of a stereo pair, rad; it shifts an image by one pixel if fx is 1000 pixels."""

Matrices = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


class ROS2PublishCameraInfo(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishCameraInfo"):
    """Publishes camera matrices and distortion as sensor_msgs/CameraInfo; a matrix that is not given is published as zeros."""

    message_type: ClassVar[str] = "sensor_msgs/msg/CameraInfo"

    frame_id: String = In(default="sim_camera", setup=True)
    topic_name: String = In(default="camera_info", setup=True)
    width: UInt = In(default=0, unit="pixel")
    height: UInt = In(default=0, unit="pixel")
    projection_type: Token = In(
        default="", doc="distortion model if `physicalDistortionModel` is empty; it is published without coefficients"
    )
    k: Doubles = In(doc="camera matrix, 9 numbers row by row: focal lengths and principal point, pixels")
    r: Doubles = In(doc="rectification matrix of a stereo camera, 9 numbers row by row")
    p: Doubles = In(doc="projection matrix for points in the rectified frame, 12 numbers row by row")
    physical_distortion_model: Token = In(default="", doc="distortion model, such as plumb_bob or rational_polynomial")
    physical_distortion_coefficients: Floats = In()

    def message(self) -> messages.CameraInfo:
        """Return the CameraInfo message with the values of the inputs."""
        model, coefficients = self.physical_distortion_model, self.physical_distortion_coefficients
        matrices = _matrix("k", self.k, 9), _matrix("r", self.r, 9), _matrix("p", self.p, 12)
        if not model:
            model, coefficients = self.projection_type, coefficients[:0]
        size = (self.width, self.height)
        return camera_info(self.header(), size, model, coefficients.astype(np.float64), matrices)


def _matrix(name: str, given: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    if len(given) not in (0, count):
        raise BadValueError(name, given, f"{count} numbers, or none")
    return given if len(given) else np.zeros(count)


def camera_info(
    header: messages.Header, size: tuple[int, int], model: str, distortion: NDArray[np.float64], matrices: Matrices
) -> messages.CameraInfo:
    """Return a CameraInfo message for images of the full sensor without binning.

    Args:
        header: time and optical frame.
        size: width and height, pixels.
        model: distortion model, such as `plumb_bob`.
        distortion: coefficients of the distortion model.
        matrices: K, R and P, row by row.
    """
    k, r, p = matrices
    whole = messages.RegionOfInterest(0, 0, 0, 0, False)  # zeros stand for all of the sensor
    return messages.CameraInfo(header, size[1], size[0], model, distortion, k, r, p, 0, 0, whole)


@functools.lru_cache(maxsize=64)
def pinhole_matrices(intrinsics: tuple[float, float, float, float], baseline: float = 0.0) -> Matrices:
    """Return K, R and P of a pinhole camera with rectified images, as read-only arrays that messages share.

    Args:
        intrinsics: fx, fy, cx, cy in pixels.
        baseline: distance from the left camera if this is the right camera of a stereo pair, m; otherwise 0.
    """
    fx, fy, cx, cy = intrinsics
    k = np.array([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0])
    p = np.array([fx, 0.0, cx, 0.0 - fx * baseline, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0])
    return read_only(k), read_only(np.eye(3).ravel()), read_only(p)


@dataclass(frozen=True, slots=True)
class Eye:
    """A camera with its stereo baseline (m) and the publisher of its calibration."""

    camera: Camera
    baseline: float
    publisher: Publisher


class ROS2CameraInfoHelper(SkippingHelper, type="isaacsim.ros2.bridge.ROS2CameraInfoHelper"):
    """Publishes the calibration of a camera or a stereo pair as CameraInfo, once for each image.

    A message has the stamp of its image and is published in the same tick as the image, even if the image itself is not rendered.
    Cameras are pinholes with square pixels and without distortion. Pixel coordinates begin at the centre of the first pixel: cx
    is (width - 1) / 2. The cameras of a stereo pair have parallel axes and stand side by side, so their images are already
    rectified: R is the identity, and Tx in P of the right camera is -fx times the baseline.
    """

    frame_id: String = In(default="sim_camera", setup=True, doc="name of the optical frame of the (left) camera")
    topic_name: String = In(default="camera_info", setup=True)
    frame_id_right: String = In(default="sim_camera_right", setup=True)
    topic_name_right: String = In(default="camera_info_right", setup=True)
    render_product_path_right: Token = In(
        default="", setup=True, doc="render product of the right camera of a stereo pair; empty for a single camera"
    )

    eyes: tuple[Eye, ...] = Bound()
    captured: deque[tuple[int, float]] = State(factory=deque)

    def setup(self, context: Context) -> None:
        """Look up the cameras at the render products and create a publisher for each."""
        super().setup(context)
        left = context.device(Camera, self.render_product_path)
        self.eyes = (self.eye(context, left, 0.0, self.topic_name, self.frame_id),)
        if self.render_product_path_right:
            right = context.device(Camera, self.render_product_path_right)
            baseline = self.baseline(context, left, right)
            self.eyes += (self.eye(context, right, baseline, self.topic_name_right, self.frame_id_right),)

    def eye(self, context: Context, camera: Camera, baseline: float, topic: str, frame_id: str) -> Eye:
        """Create the publisher of a camera's calibration, and return it with the camera and its baseline (m) as an `Eye`."""
        publisher = self.open_for(context, camera, "sensor_msgs/msg/CameraInfo", topic, frame_id=frame_id)
        return Eye(camera, baseline, publisher)

    def baseline(self, context: Context, left: Camera, right: Camera) -> float:
        """Return the distance from the left camera to the right one, m.

        Raises:
            ContextError: the cameras are not a rectified stereo pair.
        """
        pair, path = f"{left.prim_path} and {right.prim_path}", self.render_product_path_right
        if (left.size, left.intrinsics, left.rate) != (right.size, right.intrinsics, right.rate):
            legal = "both cameras of a stereo pair need the same size, lens and rate"
            raise ContextError(f"{pair} differ in size, lens or rate", path, legal)
        (link,) = context.transform_tree([right.prim_path], left.prim_path)
        if link.fixed is None:
            raise ContextError(f"{pair} move relative to each other", path, "mount both cameras on the same body")
        (x, y, z), (qx, qy, qz, _) = link.fixed
        if max(abs(qx), abs(qy), abs(qz)) > _PARALLEL / 2 or max(abs(y), abs(z)) > _PARALLEL * abs(x):
            legal = "the optical axes must be parallel, and the cameras side by side"
            raise ContextError(f"{pair} are not a rectified stereo pair", path, legal)
        if x <= 0.0:
            wrong = f"{right.prim_path} is not to the right of {left.prim_path}"
            raise ContextError(wrong, path, "exchange the two render products")
        return x

    def compute(self) -> None:
        """Start publishing if `enabled` is true, otherwise stop."""
        super().compute()
        if not self.enabled:
            self.captured.clear()

    def update(self) -> None:
        """Publish the calibration for the image that is delivered in this tick, if there are subscribers."""
        camera, clock = self.eyes[0].camera, self.clock
        if camera.due and not self.left_out(camera.index):
            self.captured.append((clock.frame + camera.latency, clock.time))
        if not self.captured or self.captured[0][0] > clock.frame:
            return
        _, time = self.captured.popleft()
        for eye in self.eyes:
            if eye.publisher.wanted:
                eye.publisher.publish(self.message(eye, time))

    def message(self, eye: Eye, time: float) -> messages.CameraInfo:
        """Return the CameraInfo message of one camera for an image captured at `time`, in s after play."""
        header = messages.header(self.stamp(time), eye.publisher.claim.frame_id)
        matrices = pinhole_matrices(eye.camera.intrinsics, eye.baseline)
        return camera_info(header, eye.camera.size, "plumb_bob", _NO_DISTORTION, matrices)
