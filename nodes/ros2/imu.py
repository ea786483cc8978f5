"""A node that publishes IMU readings."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from graphengine.messages import messages
from graphengine.node import BadValueError, Doubles, In, Quaterniond, String, Vector3d
from graphengine.node.types import read_only
from graphengine.nodes.ros2.publisher import SensorPublisher

_UNKNOWN, _ABSENT = read_only(np.zeros(9)), read_only(np.array([-1.0, *[0.0] * 8]))
"""Covariances that sensor_msgs/Imu defines for a quantity of unknown accuracy and for a quantity that is not measured."""
_COVARIANCE = "covariance matrix, 3 x 3 numbers row by row; empty: zeros, which mean unknown"


class ROS2PublishImu(SensorPublisher, type="isaacsim.ros2.bridge.ROS2PublishImu"):
    """Publishes an IMU reading as sensor_msgs/Imu.

    A quantity whose `publish...` input is false is published as zeros, with -1 as the first number of its covariance.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/Imu"

    frame_id: String = In(default="sim_imu", setup=True)
    topic_name: String = In(default="imu", setup=True)
    publish_orientation: bool = In(default=True)
    publish_linear_acceleration: bool = In(default=True)
    publish_angular_velocity: bool = In(default=True)
    orientation: Quaterniond = In(default=(0.0, 0.0, 0.0, 1.0), doc="orientation (x, y, z, w) of the sensor")
    linear_acceleration: Vector3d = In(default=(0.0, 0.0, 0.0), unit="m/s2", doc="acceleration in the sensor's frame")
    angular_velocity: Vector3d = In(default=(0.0, 0.0, 0.0), unit="rad/s", doc="angular velocity in the sensor's frame")
    orientation_covariance: Doubles = In(default=np.zeros(0), extension=True, unit="rad2", doc=_COVARIANCE)
    linear_acceleration_covariance: Doubles = In(default=np.zeros(0), extension=True, unit="m2/s4", doc=_COVARIANCE)
    angular_velocity_covariance: Doubles = In(default=np.zeros(0), extension=True, unit="rad2/s2", doc=_COVARIANCE)

    def message(self) -> messages.Imu:
        """Return the message with the reading that the inputs give."""
        turned, turns = self.publish_orientation, self.publish_angular_velocity
        accelerates = self.publish_linear_acceleration
        return messages.Imu(
            self.header(),
            messages.Quaternion(*(self.orientation if turned else (0.0, 0.0, 0.0, 0.0))),
            self.covariance("orientation_covariance") if turned else _ABSENT,
            messages.Vector3(*(self.angular_velocity if turns else (0.0, 0.0, 0.0))),
            self.covariance("angular_velocity_covariance") if turns else _ABSENT,
            messages.Vector3(*(self.linear_acceleration if accelerates else (0.0, 0.0, 0.0))),
            self.covariance("linear_acceleration_covariance") if accelerates else _ABSENT,
        )

    def covariance(self, field: str) -> Doubles:
        """Return the covariance that an input gives, 9 numbers row by row, or zeros if the input is empty.

        Raises:
            BadValueError: the input is not empty and does not have 9 numbers.
        """
        numbers: Doubles = getattr(self, field)
        if len(numbers) not in (0, 9):
            raise BadValueError(type(self).fields[field].name, numbers, "9 numbers, or empty")
        return numbers if len(numbers) else _UNKNOWN
