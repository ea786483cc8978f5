"""Publisher of pictures that somebody compressed."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphengine.messages import messages
from graphengine.node import Buffer, In, String, Token, UChars, UInt64
from graphengine.nodes.ros2.publisher import SensorPublisher


class ROS2PublishCompressedImage(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishCompressedImage"):
    """Publishes bytes of a compressed picture, or of a piece of film, as sensor_msgs/CompressedImage; none without bytes.

    Nothing is compressed here: the bytes go out as they came.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/CompressedImage"

    frame_id: String = In(default="sim_camera", setup=True)
    topic_name: String = In(default="image_raw/compressed", setup=True)
    data: UChars = In(doc="the bytes")
    data_ptr: Buffer = In(default=0, doc="the bytes, where no array is given")
    buffer_size: UInt64 = In(default=0, doc="no effect: a buffer knows its size")
    input_format: Token = In(default="h264", name="input_format", tokens=("h264",))
    format: Token = In(
        default="", tokens=("", "jpeg", "png"), extension=True, doc="of pictures; else input_format tells"
    )

    def compute(self) -> None:
        """Send the bytes, if there are any and anybody wants them."""
        if len(self.data) or not isinstance(self.data_ptr, int):
            super().compute()

    def message(self) -> messages.CompressedImage:
        """The bytes."""
        data = self.data if len(self.data) else np.frombuffer(self.data_ptr, np.uint8)
        return messages.CompressedImage(self.header(), self.format or self.input_format, data)
