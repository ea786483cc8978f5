"""Nodes that convert images in buffers (`isaacsim.core.nodes`).

In Isaac Sim, the renderer passes its buffers to these nodes. Here `renderProductPath` gives them the pictures of a camera; a
buffer of another node may be wired to `dataPtr` in its place.
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
"""Number of the format with one float32 per pixel in Carbonite's enumeration."""
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
        doc="path of a camera from IsaacCreateRenderProduct, or its prim path; its pictures are used if `dataPtr` is empty",
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
        """Convert the buffer, or else the picture that the camera delivers in this tick; return whether there was one.

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
        """Return the image of a buffer with shape (height, width, channels).

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
    """Converts an rgba8 image to rgb8: copies red, green and blue of each pixel, and fires.

    The image is in `dataPtr`, or else it is a picture of the camera in `renderProductPath`, which has no alpha; then the node
    must be executed in every tick, and fires once per picture. In Isaac Sim, a buffer in host memory is passed on with its
    alpha; here it is converted, as Isaac Sim does on the GPU.
    """

    data_ptr: Buffer = In(default=0, doc="buffer with four bytes per pixel, top row first")
    encoding: Token = In(default="rgba8", doc="encoding of the image in `dataPtr`: rgba8")
    format: UInt64 = In(default=0, doc="no effect: `encoding` sets the pixel format")
    exec_out = ExecOut()
    data_ptr_out: Buffer = Out(default=0, name="dataPtr", doc="buffer with three bytes per pixel, for ROS2PublishImage")
    encoding_out: Token = Out(name="encoding", doc="rgb8")
    width_out: UInt = Out(name="width", unit="pixel")
    height_out: UInt = Out(name="height", unit="pixel")
    buffer_size_out: UInt = Out(name="bufferSize", doc="bytes in the buffer")

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
    length f = `width` * `focalLength` / `horizontalAperture` in pixels. This is Isaac Sim's formula: it takes the upper left
    corner of each pixel, where ROS2CameraHelper with `type: depth_pcl` takes the centre. Each pixel has a point; one without a
    surface is NaN.

    The image is in `dataPtr`, or else it is a picture of the camera in `renderProductPath`, which also gives its size and focal
    length; then the node must be executed in every tick, and fires once per picture.
    """

    data_ptr: Buffer = In(default=0, doc="buffer with one float32 per pixel, m, top row first; inf without a surface")
    focal_length: Float = In(default=0.0, unit="mm", doc="focal length, in the unit of `horizontalAperture`")
    horizontal_aperture: Float = In(default=0.0, unit="mm", doc="width of the aperture")
    vertical_aperture: Float = In(default=0.0, unit="mm", doc="no effect: pixels are square")
    format: UInt64 = In(default=_R32_SFLOAT, doc="format of the image in `dataPtr`: 33 (R32_SFLOAT)")
    exec_out = ExecOut()
    data_ptr_out: Buffer = Out(
        default=0, name="dataPtr", doc="buffer with three float32 per pixel, for ROS2PublishPointCloud"
    )
    buffer_size_out: UInt = Out(name="bufferSize", doc="bytes in the buffer")
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
        """Set the outputs to the points of a depth image (m) with a focal length in pixels."""
        height, width = depth.shape
        right, down = (np.arange(width) - width / 2) / focal, (np.arange(height) - height / 2) / focal
        points = np.full((height, width, 3), np.nan, np.float32)
        seen = depth != np.inf
        with np.errstate(all="ignore"):  # inf times 0 where nothing is seen, and depths that float32 cannot hold
            for axis, along in enumerate((right[None, :], down[:, None], 1.0)):
                np.copyto(points[:, :, axis], depth * along, where=seen, casting="same_kind")
        self.data_ptr_out, self.buffer_size_out = points.reshape(-1, 3), points.nbytes
        self.height_out, self.width_out = 1, width * height
