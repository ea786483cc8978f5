"""A node that publishes the readings of a force-torque sensor as geometry_msgs/WrenchStamped."""

from __future__ import annotations

from typing import Any, ClassVar

from graphengine.devices.force_torque import ForceTorqueSensor
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import Bound, Context, In, String, Target
from graphengine.nodes.ros2.publisher import header
from graphengine.nodes.ros2.samples import SamplePublisher


class ForceTorquePublisher(SamplePublisher, type="graphengine.ros2.ForceTorquePublisher"):
    """Publishes each sample of a force-torque sensor as geometry_msgs/WrenchStamped: force (N), and torque (N m)."""

    message_type: ClassVar[str] = "geometry_msgs/msg/WrenchStamped"

    force_torque_prim: Target = In(required=True, setup=True, doc="prim of the sensor; the torque is about its origin")
    frame_id: String = In(
        default="sim_force_torque", setup=True, doc="frame of force and torque; the sensor's profile selects its axes"
    )
    topic_name: String = In(default="wrench", setup=True)

    sensor: ForceTorqueSensor = Bound()

    def setup(self, context: Context) -> None:
        """Look up the sensor at `forceTorquePrim` and create the publisher on `topicName`."""
        self.sensor = context.device(ForceTorqueSensor, self.force_torque_prim[0])
        self.publish_samples(context, self.sensor)

    def values(self) -> tuple[Any, ...]:
        """Return the fields of the message with the newest reading."""
        reading = self.sensor.reading()
        parts = messages.Vector3(*reading.force), messages.Vector3(*reading.torque)
        wrench = DEFINITIONS.message_class("geometry_msgs/msg/Wrench")(*parts)
        return header(reading.time, self.publisher.claim.frame_id), wrench
