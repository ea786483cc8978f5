"""Builds and publishes sensor_msgs/Image messages."""

from __future__ import annotations

from typing import ClassVar

from graphengine.messages import messages
from graphengine.node import BadValueError, Buffer, In, Int, String, Token, UChars, UInt, UInt64
from graphengine.nodes.checked import one_of
from graphengine.nodes.ros2.publisher import SensorPublisher, array_or_buffer, bytes_in

PIXEL_BYTES = {"rgb8": 3, "rgba8": 4, "32FC1": 4, "32SC1": 4}
"""Bytes per pixel of each encoding: 8-bit colour channels, one float32, one int32."""


def image(header: messages.Header, encoding: str, size: tuple[int, int], pixels: Buffer) -> messages.Image:
    """Return an image message that refers to a buffer of pixels without copying the buffer.

    Args:
        header: time and frame.
        encoding: pixel format, a key of PIXEL_BYTES.
        size: width and height, pixels.
        pixels: rows of pixels, top row first, little-endian.

    Raises:
        BadValueError: the encoding is unknown, or the size of the buffer does not match the image size and the encoding.
    """
    width, height = size
    data, step = bytes_in(pixels), width * PIXEL_BYTES[one_of("encoding", encoding, PIXEL_BYTES)]
    if len(data) != step * height:
        legal = f"consistent, with a buffer of {step * height} bytes for {width} x {height} pixels of {encoding}"
        raise BadValueError("data, width, height, encoding, dataPtr", len(data), legal)
    return messages.Image(header, height, width, encoding, 0, step, data)


class ROS2PublishImage(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishImage"):
    """Publishes pixels as sensor_msgs/Image, from an array of bytes or from a buffer."""

    message_type: ClassVar[str] = "sensor_msgs/msg/Image"

    frame_id: String = In(default="sim_camera", setup=True)
    topic_name: String = In(default="rgb", setup=True)
    data: UChars = In(doc="bytes of the pixels row by row, top row first")
    width: UInt = In(default=0, unit="pixel")
    height: UInt = In(default=0, unit="pixel")
    encoding: Token = In(default="rgb8", tokens=tuple(PIXEL_BYTES), doc="pixel format")
    data_ptr: Buffer = In(default=0, doc="buffer of pixels, used if `data` is empty")
    cuda_device_index: Int = In(default=-1, doc="no effect: buffers are in host memory")
    buffer_size: UInt = In(default=0, doc="no effect: the size is that of the buffer in `dataPtr`")
    format: UInt64 = In(default=0, doc="no effect: `encoding` sets the pixel format")

    def message(self) -> messages.Image:
        """Return the image message with the given pixels."""
        pixels = array_or_buffer(self.data, self.data_ptr)
        return image(self.header(), self.encoding, (self.width, self.height), pixels)
