"""A node that publishes the readings of a range sensor as sensor_msgs/Range."""

from __future__ import annotations

from typing import Any, ClassVar

from graphengine.devices.range import RangeSensor
from graphengine.node import Bound, Context, In, String, Target
from graphengine.nodes.ros2.publisher import header
from graphengine.nodes.ros2.samples import SamplePublisher

_RADIATION = {"ultrasound": 0, "infrared": 1}


class RangePublisher(SamplePublisher, type="graphengine.ros2.RangePublisher"):
    """Publishes each sample of a range sensor as sensor_msgs/Range.

    As in REP 117, the range is +inf if no object is within `max_range`, and -inf if an object is closer than `min_range`.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/Range"

    range_prim: Target = In(
        required=True, setup=True, doc="prim of the range sensor; its x axis is the axis of the sensor's cone"
    )
    frame_id: String = In(default="sim_range", setup=True)
    topic_name: String = In(default="range", setup=True)

    sensor: RangeSensor = Bound()

    def setup(self, context: Context) -> None:
        """Look up the range sensor at `rangePrim` and create the publisher on `topicName`."""
        self.sensor = context.device(RangeSensor, self.range_prim[0])
        self.publish_samples(context, self.sensor)

    def values(self) -> tuple[Any, ...]:
        """Return the fields of the message with the newest reading."""
        sensor = self.sensor
        reading = sensor.reading()
        head, radiation = header(reading.time, self.publisher.claim.frame_id), _RADIATION[sensor.radiation_type]
        return head, radiation, sensor.field_of_view, *sensor.ranges, reading.range, sensor.noise_std**2
