"""A node that publishes compressed images and video packets."""

from __future__ import annotations

from typing import ClassVar

from graphengine.messages import messages
from graphengine.node import Buffer, In, String, Token, UChars, UInt, UInt64
from graphengine.nodes.ros2.image_compression import COMPRESSED_IMAGE, ENCODINGS, JPEG_QUALITY, compressed
from graphengine.nodes.ros2.publisher import SensorPublisher, array_or_buffer, bytes_in


class ROS2PublishCompressedImage(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishCompressedImage"):
    """Publishes a compressed image or video packet as sensor_msgs/CompressedImage; publishes nothing if there are no bytes.

    If `encoding` is empty, the bytes are published unchanged. Otherwise the bytes are pixels, and the node compresses them to
    `format` in the same tick. Subscribers of image_transport can decode the compressed images, because the node uses the format
    strings of compressed_image_transport. For an image topic IMAGE, such subscribers expect compressed images on the topic
    IMAGE/compressed. Isaac Sim's node publishes H.264 packets only.
    """

    message_type: ClassVar[str] = COMPRESSED_IMAGE

    frame_id: String = In(default="sim_camera", setup=True)
    topic_name: String = In(default="image_raw/compressed", setup=True)
    data: UChars = In(doc="compressed bytes; if `encoding` is set, pixels row by row, top row first")
    data_ptr: Buffer = In(default=0, doc="buffer with the compressed bytes or pixels, used if `data` is empty")
    buffer_size: UInt64 = In(default=0, doc="no effect: the size is that of the buffer in `dataPtr`")
    input_format: Token = In(default="h264", name="input_format", tokens=("h264",))
    format: Token = In(
        default="",
        tokens=("", *ENCODINGS),
        extension=True,
        doc="image format of the message; if empty: jpeg if `encoding` is set, otherwise `input_format`",
    )
    encoding: Token = In(
        default="",
        tokens=("", *ENCODINGS["png"]),
        extension=True,
        doc="pixel format of the image to compress; 16UC1 needs `format` png; if empty, the bytes are published unchanged",
    )
    width: UInt = In(default=0, unit="pixel", extension=True, doc="width of the image to compress")
    height: UInt = In(default=0, unit="pixel", extension=True, doc="height of the image to compress")
    jpeg_quality: UInt = In(default=JPEG_QUALITY, ge=1, le=100, extension=True, doc="JPEG quality, 1 to 100")

    def compute(self) -> None:
        """Publish the bytes, if there are any and the topic has subscribers.

        Raises:
            BadValueError: the pixels do not match `encoding`, `width` and `height`, or `jpegQuality` is out of range.
        """
        if len(bytes_in(array_or_buffer(self.data, self.data_ptr))):
            super().compute()

    def message(self) -> messages.CompressedImage:
        """Return the message with the given bytes, or with the compressed pixels if `encoding` is set."""
        given = array_or_buffer(self.data, self.data_ptr)
        if not self.encoding:
            return messages.CompressedImage(self.header(), self.format or self.input_format, bytes_in(given))
        size, compression = (self.width, self.height), self.format or "jpeg"
        return compressed(self.header(), self.encoding, size, given, compression, self.jpeg_quality)
