"""Nodes that convert images (`isaacsim.core.nodes`).

In Isaac Sim, these nodes get a buffer from the renderer. Here they convert the buffer that another node outputs to `dataPtr`. If
`dataPtr` is not wired, they convert the images of the camera that `renderProductPath` selects.
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
"""Number of Carbonite's image format with one float32 per pixel."""
_HOST = "no effect: buffers are in host memory"


class ImageBufferNode(Node):
    """Base of nodes that convert the image in a buffer, or the newest image of a camera if there is no buffer.

    A subclass implements the conversion in `from_buffer` and `from_picture`, and defines `data_ptr` and `exec_out`.
    """

    exec_out: ClassVar[ExecOut]
    data_ptr: Buffer

    exec_in = ExecIn()
    render_product_path: Token = In(
        default="",
        setup=True,
        extension=True,
        doc="camera whose images are converted if `dataPtr` is empty: path from IsaacCreateRenderProduct, or prim path",
    )
    cuda_device_index: Int = In(default=-1, doc=_HOST)
    width: UInt = In(ge=1, unset=True, unit="pixel", doc="width of the image in `dataPtr`")
    height: UInt = In(ge=1, unset=True, unit="pixel", doc="height of the image in `dataPtr`")
    buffer_size: UInt = In(default=0, doc="no effect: the node knows the size of the buffer in `dataPtr`")
    cuda_device_index_out: Int = Out(default=-1, name="cudaDeviceIndex", doc="always -1: host memory")

    camera: Camera | None = Bound()

    def setup(self, context: Context) -> None:
        """Look up the camera that `renderProductPath` selects, if it is not empty."""
        self.camera = context.device(Camera, self.render_product_path) if self.render_product_path else None

    def compute(self) -> Fire:
        """Convert the image in `dataPtr`, or without a buffer the image that the camera delivers in this tick, and fire.

        Do not fire if there is no buffer and the camera delivers no image in this tick.

        Raises:
            BadValueError: there is neither a buffer nor a camera, the size of the buffer does not match `width` and `height`, or
                another input that describes the buffer is not legal.
        """
        if not isinstance(self.data_ptr, int):
            self.from_buffer(memoryview(self.data_ptr))
            return self.exec_out
        if self.camera is None:
            legal = "a buffer in dataPtr or a camera path in renderProductPath"
            raise BadValueError("dataPtr, renderProductPath", self.data_ptr, legal)
        if self.camera.due:
            self.camera.request()
        picture = self.camera.delivered()
        if picture is None:
            return None
        self.from_picture(self.camera, picture)
        return self.exec_out

    def pixels(self, buffer: memoryview, dtype: str, channels: int) -> NDArray[np.generic]:
        """Return the image in a buffer as an array of shape (height, width, channels).

        Args:
            buffer: the buffer, top row first.
            dtype: NumPy type of one channel of a pixel.
            channels: number of channels of a pixel.

        Raises:
            BadValueError: `width` or `height` is 0, or the size of the buffer does not match them.
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
        """Set the outputs from an image of the camera."""
        raise NotImplementedError


class IsaacConvertRGBAToRGB(ImageBufferNode, type="isaacsim.core.nodes.IsaacConvertRGBAToRGB", gated=True):
    """Converts an rgba8 image to rgb8 and fires.

    The node converts the image in the buffer `dataPtr`. If `dataPtr` is empty, the node outputs the images of the camera that
    `renderProductPath` selects; in this case, execute the node in every tick; it then fires once per image. Isaac Sim's node
    converts only buffers in GPU memory; it outputs buffers in host memory unchanged, with their alpha.
    """

    data_ptr: Buffer = In(default=0, doc="rgba8 image: buffer with four bytes per pixel, top row first")
    encoding: Token = In(default="rgba8", doc="encoding of the image in `dataPtr`: rgba8")
    format: UInt64 = In(default=0, doc="no effect: `encoding` sets the pixel format")
    exec_out = ExecOut()
    data_ptr_out: Buffer = Out(default=0, name="dataPtr", doc="rgb8 image: buffer with three bytes per pixel")
    encoding_out: Token = Out(name="encoding", doc="always rgb8")
    width_out: UInt = Out(name="width", unit="pixel", doc="width of the image")
    height_out: UInt = Out(name="height", unit="pixel", doc="height of the image")
    buffer_size_out: UInt = Out(name="bufferSize", doc="size of the rgb8 image in bytes")

    def from_buffer(self, buffer: memoryview) -> None:
        """Output the image in the buffer without its alpha channel."""
        one_of("encoding", self.encoding, ("rgba8",))
        self.put_out(np.ascontiguousarray(self.pixels(buffer, "u1", 4)[:, :, :3]))

    def from_picture(self, camera: Camera, picture: Picture) -> None:
        """Output the colours of an image of the camera."""
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
    corner of each pixel, while ROS2CameraHelper with `type: depth_pcl` uses the centre. The output has one point per pixel; the
    coordinates are NaN at pixels without a surface.

    The node converts the image in the buffer `dataPtr`. If `dataPtr` is empty, the node converts the images of the camera that
    `renderProductPath` selects, with the camera's image size and focal length; in this case, execute the node in every tick; it
    then fires once per image.
    """

    data_ptr: Buffer = In(
        default=0, doc="depth image, m: buffer with one float32 per pixel, top row first; inf without a surface"
    )
    focal_length: Float = In(gt=0.0, unset=True, unit="mm", doc="focal length, in the unit of `horizontalAperture`")
    horizontal_aperture: Float = In(
        gt=0.0, unset=True, unit="mm", doc="width of the aperture, in the unit of `focalLength`"
    )
    vertical_aperture: Float = In(default=0.0, unit="mm", doc="no effect: pixels are square")
    format: UInt64 = In(default=_R32_SFLOAT, doc="format of the image in `dataPtr`: 33 (R32_SFLOAT)")
    exec_out = ExecOut()
    data_ptr_out: Buffer = Out(
        default=0, name="dataPtr", doc="points, m: buffer with x, y and z of one point per pixel as float32"
    )
    buffer_size_out: UInt = Out(name="bufferSize", doc="size of the buffer of points in bytes")
    height_out: UInt = Out(default=1, name="height", doc="always 1")
    width_out: UInt = Out(default=0, name="width", doc="number of points")

    def from_buffer(self, buffer: memoryview) -> None:
        """Output the points of the depth image in the buffer."""
        if self.format != _R32_SFLOAT:
            raise BadValueError("format", self.format, f"{_R32_SFLOAT} (one float32 per pixel)")
        if not (self.focal_length > 0.0 and self.horizontal_aperture > 0.0):
            given = [self.focal_length, self.horizontal_aperture]
            raise BadValueError("focalLength, horizontalAperture", given, "above 0")
        focal = self.width * self.focal_length / self.horizontal_aperture
        self.put_out(self.pixels(buffer, "<f4", 1)[:, :, 0].astype(np.float32), focal)

    def from_picture(self, camera: Camera, picture: Picture) -> None:
        """Output the points of the camera's depth image."""
        self.put_out(picture.depth, camera.intrinsics[0])

    def put_out(self, depth: NDArray[np.float32], focal: float) -> None:
        """Set the outputs to the points of a depth image.

        Args:
            depth: depth of each pixel, m, shape (height, width); inf without a surface.
            focal: focal length, pixels.
        """
        height, width = depth.shape
        right, down = (np.arange(width) - width / 2) / focal, (np.arange(height) - height / 2) / focal
        points = np.full((height, width, 3), np.nan, np.float32)
        seen = depth != np.inf
        with np.errstate(all="ignore"):  # inf times 0 at pixels without a surface, and depths that float32 cannot hold
            for axis, along in enumerate((right[None, :], down[:, None], 1.0)):
                np.copyto(points[:, :, axis], depth * along, where=seen, casting="same_kind")
        self.data_ptr_out, self.buffer_size_out = points.reshape(-1, 3), points.nbytes
        self.height_out, self.width_out = 1, width * height
