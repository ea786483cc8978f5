"""Publisher of compressed pictures."""

from __future__ import annotations

from typing import ClassVar

from graphengine.messages import messages
from graphengine.node import Buffer, In, String, Token, UChars, UInt64
from graphengine.nodes.ros2.publisher import SensorPublisher, array_or_buffer, bytes_in


class ROS2PublishCompressedImage(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishCompressedImage"):
    """Publishes a compressed picture or video packet as sensor_msgs/CompressedImage; publishes nothing if it is empty.

    The node does not compress: it publishes the bytes unchanged.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/CompressedImage"

    frame_id: String = In(default="sim_camera", setup=True)
    topic_name: String = In(default="image_raw/compressed", setup=True)
    data: UChars = In(doc="compressed bytes")
    data_ptr: Buffer = In(default=0, doc="buffer of compressed bytes, used if `data` is empty")
    buffer_size: UInt64 = In(default=0, doc="no effect: the size is that of the buffer in `dataPtr`")
    input_format: Token = In(default="h264", name="input_format", tokens=("h264",))
    format: Token = In(
        default="",
        tokens=("", "jpeg", "png"),
        extension=True,
        doc="picture format of the message; if empty, `input_format` is used",
    )

    def compute(self) -> None:
        """Publish the bytes, if there are any and the topic has subscribers."""
        if len(bytes_in(array_or_buffer(self.data, self.data_ptr))):
            super().compute()

    def message(self) -> messages.CompressedImage:
        """Build the message from the bytes."""
        data = bytes_in(array_or_buffer(self.data, self.data_ptr))
        return messages.CompressedImage(self.header(), self.format or self.input_format, data)
