"""A node that publishes drive commands for a vehicle with Ackermann steering."""

from __future__ import annotations

from typing import Any, ClassVar

from graphengine.messages import messages
from graphengine.node import In, String
from graphengine.nodes.ros2.publisher import SensorPublisher


class ROS2PublishAckermannDrive(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishAckermannDrive"):
    """Publishes a drive command as ackermann_msgs/AckermannDriveStamped. The message has float32 values."""

    message_type: ClassVar[str] = "ackermann_msgs/msg/AckermannDriveStamped"

    topic_name: String = In(default="ackermann_cmd", setup=True)
    frame_id: String = In(default="", setup=True)
    steering_angle: float = In(default=0.0, unit="rad")
    steering_angle_velocity: float = In(default=0.0, unit="rad/s")
    speed: float = In(default=0.0, unit="m/s")
    acceleration: float = In(default=0.0, unit="m/s2")
    jerk: float = In(default=0.0, unit="m/s3")

    def message(self) -> Any:
        """Return the command message with the values of the inputs."""
        values = (self.steering_angle, self.steering_angle_velocity, self.speed, self.acceleration, self.jerk)
        drive = messages.message_class("ackermann_msgs/msg/AckermannDrive")(*values)
        return messages.message_class(self.message_type)(self.header(), drive)
