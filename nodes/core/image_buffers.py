"""Nodes that convert images in buffers (`isaacsim.core.nodes`).

In Isaac Sim, these nodes get their buffers from the renderer. Here they convert the pictures of the camera that
`renderProductPath` selects, or a buffer that another node outputs, if it is wired to `dataPtr`.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.camera import Camera, Picture
from graphengine.node import BadValueError, Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out
from graphengine.node.types import Buffer, Float, Int, Token, UInt, UInt64
from graphengine.nodes.checked import one_of

_R32_SFLOAT = 33
"""Carbonite's number of the format with one float32 per pixel."""
_HOST = "no effect: buffers are in host memory"


class ImageBufferNode(Node):
    """Base of nodes that convert the image in a buffer, or else the newest picture of a camera.

    A subclass converts in `from_buffer` and `from_picture`, and defines `exec_out`.
    """

    exec_out: ClassVar[ExecOut]

    exec_in = ExecIn()
    render_product_path: Token = In(
        default="",
        setup=True,
        extension=True,
        doc="camera whose pictures to convert if `dataPtr` is empty: path from IsaacCreateRenderProduct, or prim path",
    )
    cuda_device_index: Int = In(default=-1, doc=_HOST)
    width: UInt = In(default=0, unit="pixel", doc="width of the image in `dataPtr`")
    height: UInt = In(default=0, unit="pixel", doc="height of the image in `dataPtr`")
    buffer_size: UInt = In(default=0, doc="no effect: the size is that of the buffer in `dataPtr`")
    cuda_device_index_out: Int = Out(default=-1, name="cudaDeviceIndex", doc="always -1: host memory")

    camera: Camera | None = Bound()

    def setup(self, context: Context) -> None:
        """Bind the camera, if one is given."""
        self.camera = context.device(Camera, self.render_product_path) if self.render_product_path else None

    def converted(self, buffer: Buffer) -> bool:
        """Convert the buffer if it is given, otherwise this tick's picture of the camera; return False if there is no picture.

        Raises:
            BadValueError: neither a buffer nor a camera is given, or the buffer does not have the size of the image.
        """
        if not isinstance(buffer, int):
            self.from_buffer(memoryview(buffer))
            return True
        if self.camera is None:
            raise BadValueError("dataPtr, renderProductPath", buffer, "a buffer, or the path of a camera")
        if self.camera.due:
            self.camera.request()
        picture = self.camera.delivered()
        if picture is not None:
            self.from_picture(self.camera, picture)
        return picture is not None

    def pixels(self, buffer: memoryview, dtype: str, channels: int) -> NDArray[np.generic]:
        """Return a buffer as an image of shape (height, width, channels).

        Raises:
            BadValueError: the buffer has another size, or the image is empty.
        """
        if not (self.width and self.height):
            raise BadValueError("width, height", [self.width, self.height], "above 0")
        size = self.width * self.height * channels * np.dtype(dtype).itemsize
        if buffer.nbytes != size:
            legal = f"of {size} bytes for {self.width} x {self.height} pixels"
            raise BadValueError("dataPtr, width, height", buffer.nbytes, legal)
        data = buffer if buffer.c_contiguous else buffer.tobytes()
        return np.frombuffer(data, dtype).reshape(self.height, self.width, channels)

    def from_buffer(self, buffer: memoryview) -> None:
        """Set the outputs from the image in a buffer."""
        raise NotImplementedError

    def from_picture(self, camera: Camera, picture: Picture) -> None:
        """Set the outputs from a picture of the camera."""
        raise NotImplementedError


class IsaacConvertRGBAToRGB(ImageBufferNode, type="isaacsim.core.nodes.IsaacConvertRGBAToRGB", gated=True):
    """Converts an rgba8 image to rgb8 and fires.

    The image is the buffer in `dataPtr`. If `dataPtr` is empty, the node outputs the pictures of the camera that
    `renderProductPath` selects; execute it in every tick then: it fires once per picture. Isaac Sim converts only buffers on
    the GPU, and outputs buffers in host memory with their alpha.
    """

    data_ptr: Buffer = In(default=0, doc="rgba8 image: buffer with four bytes per pixel, top row first")
    encoding: Token = In(default="rgba8", doc="encoding of the image in `dataPtr`: rgba8")
    format: UInt64 = In(default=0, doc="no effect: `encoding` sets the pixel format")
    exec_out = ExecOut()
    data_ptr_out: Buffer = Out(
        default=0, name="dataPtr", doc="rgb8 image for ROS2PublishImage: buffer with three bytes per pixel"
    )
    encoding_out: Token = Out(name="encoding", doc="always rgb8")
    width_out: UInt = Out(name="width", unit="pixel", doc="width of the image")
    height_out: UInt = Out(name="height", unit="pixel", doc="height of the image")
    buffer_size_out: UInt = Out(name="bufferSize", doc="size of the rgb8 image in bytes")

    def compute(self) -> Fire:
        """Convert an image.

        Raises:
            BadValueError: the encoding is not rgba8, there is no image, or its buffer has another size.
        """
        return self.exec_out if self.converted(self.data_ptr) else None

    def from_buffer(self, buffer: memoryview) -> None:
        """Drop the alpha of each pixel."""
        one_of("encoding", self.encoding, ("rgba8",))
        self.put_out(np.ascontiguousarray(self.pixels(buffer, "u1", 4)[:, :, :3]))

    def from_picture(self, camera: Camera, picture: Picture) -> None:
        """Output the colours of a picture."""
        self.put_out(np.ascontiguousarray(picture.rgb))

    def put_out(self, image: NDArray[np.generic]) -> None:
        """Set the outputs to an rgb8 image."""
        self.height_out, self.width_out, _ = image.shape
        self.data_ptr_out, self.buffer_size_out, self.encoding_out = image, image.nbytes, "rgb8"


class IsaacConvertDepthToPointCloud(
    ImageBufferNode, type="isaacsim.core.nodes.IsaacConvertDepthToPointCloud", gated=True
):
    """Converts a depth image to points in the camera's optical frame (x right, y down, z forward), and fires.

    The pixel in column u and row v with depth z is the point z ((u - width / 2) / f, (v - height / 2) / f, 1) with the focal
    length f = `width` * `focalLength` / `horizontalAperture` in pixels. This is Isaac Sim's formula: it uses the upper left
    corner of each pixel, while ROS2CameraHelper with `type: depth_pcl` uses the centre. Each pixel has a point, which is NaN
    where there is no surface.

    The image is the buffer in `dataPtr`. If `dataPtr` is empty, the node converts the pictures of the camera that
    `renderProductPath` selects, with the camera's size and focal length; execute it in every tick then: it fires once per
    picture.
    """

    data_ptr: Buffer = In(
        default=0, doc="depth image, m: buffer with one float32 per pixel, top row first; inf where there is no surface"
    )
    focal_length: Float = In(
        default=0.0, unit="mm", doc="focal length of the camera, in the same unit as `horizontalAperture`"
    )
    horizontal_aperture: Float = In(default=0.0, unit="mm", doc="width of the camera's aperture")
    vertical_aperture: Float = In(default=0.0, unit="mm", doc="no effect: pixels are square")
    format: UInt64 = In(default=_R32_SFLOAT, doc="format of the image in `dataPtr`: 33 (R32_SFLOAT)")
    exec_out = ExecOut()
    data_ptr_out: Buffer = Out(
        default=0,
        name="dataPtr",
        doc="points for ROS2PublishPointCloud, m: buffer with x, y, z as three float32 per pixel",
    )
    buffer_size_out: UInt = Out(name="bufferSize", doc="size of the points in bytes")
    height_out: UInt = Out(default=1, name="height", doc="always 1")
    width_out: UInt = Out(default=0, name="width", doc="number of points")

    def compute(self) -> Fire:
        """Convert an image.

        Raises:
            BadValueError: the format is not 33, there is no image, its buffer has another size, or the focal length is not
                above 0.
        """
        return self.exec_out if self.converted(self.data_ptr) else None

    def from_buffer(self, buffer: memoryview) -> None:
        """Convert the depths of a buffer."""
        if self.format != _R32_SFLOAT:
            raise BadValueError("format", self.format, f"{_R32_SFLOAT}, one float32 per pixel")
        if not (self.focal_length > 0.0 and self.horizontal_aperture > 0.0):
            given = [self.focal_length, self.horizontal_aperture]
            raise BadValueError("focalLength, horizontalAperture", given, "above 0")
        focal = self.width * self.focal_length / self.horizontal_aperture
        self.put_out(self.pixels(buffer, "<f4", 1)[:, :, 0].astype(np.float32), focal)

    def from_picture(self, camera: Camera, picture: Picture) -> None:
        """Convert the depths of a picture."""
        self.put_out(picture.depth, camera.intrinsics[0])

    def put_out(self, depth: NDArray[np.float32], focal: float) -> None:
        """Set the outputs to the points of a depth image, m; `focal` is the focal length in pixels."""
        height, width = depth.shape
        right, down = (np.arange(width) - width / 2) / focal, (np.arange(height) - height / 2) / focal
        points = np.full((height, width, 3), np.nan, np.float32)
        seen = depth != np.inf
        with np.errstate(all="ignore"):  # inf times 0 at pixels without a surface, and depths that float32 cannot hold
            for axis, along in enumerate((right[None, :], down[:, None], 1.0)):
                np.copyto(points[:, :, axis], depth * along, where=seen, casting="same_kind")
        self.data_ptr_out, self.buffer_size_out = points.reshape(-1, 3), points.nbytes
        self.height_out, self.width_out = 1, width * height
