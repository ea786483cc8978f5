"""A node that publishes the readings of a range sensor as sensor_msgs/Range."""

from __future__ import annotations

from graphengine.devices.range import RangeSensor
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Context, In, State, String, Target
from graphengine.nodes.ros2.publisher import TopicNode, header, send

_TYPE = "sensor_msgs/msg/Range"
_RADIATION = {"ultrasound": 0, "infrared": 1}


class RangePublisher(TopicNode, type="graphengine.ros2.RangePublisher"):
    """Publishes each sample of a range sensor as sensor_msgs/Range.

    As in REP 117, the range is +inf if no object is within `max_range`, and -inf if an object is closer than `min_range`.
    """

    range_prim: Target = In(
        required=True,
        setup=True,
        doc="prim of the range sensor; the x axis of the prim is the axis of the sensor's cone",
    )
    frame_id: String = In(default="sim_range", setup=True)
    topic_name: String = In(default="range", setup=True)

    sensor: RangeSensor = Bound()
    publisher: Publisher = Bound()
    last: int = State(default=-1)

    def setup(self, context: Context) -> None:
        """Look up the range sensor at `rangePrim` and create the publisher on `topicName`."""
        self.sensor = sensor = context.device(RangeSensor, self.range_prim[0])
        rate = min(sensor.rate, 1.0 / context.clock.delta)
        self.publisher = self.open_topic(
            context, _TYPE, self.topic_name, namespace_from=sensor.prim_path, rate=rate, frame_id=self.frame_id
        )

    def compute(self) -> None:
        """Publish the sample of this tick, if it is new and the topic has subscribers."""
        sensor = self.sensor
        if not sensor.due or sensor.index == self.last:
            return
        self.last = sensor.index
        if self.publisher.wanted:
            reading = sensor.reading()
            message = DEFINITIONS.message_class(_TYPE)(
                header(reading.time, self.publisher.claim.frame_id),
                _RADIATION[sensor.radiation_type],
                sensor.field_of_view,
                *sensor.ranges,
                reading.range,
                sensor.noise_std**2,
            )
            send(self.publisher, message)
