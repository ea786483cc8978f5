"""The base class of nodes that publish each sample of a sensor as one message."""

from __future__ import annotations

from typing import Any, ClassVar

from graphengine.devices.device import TickSensor
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Context, State
from graphengine.nodes.ros2.publisher import TopicNode, send


class SamplePublisher(TopicNode):
    """Base of nodes that publish each sample of a sensor once; a subclass adds `frame_id`, `topic_name`, `setup` and `values`.

    Without subscribers, nothing is measured.
    """

    message_type: ClassVar[str]
    frame_id: str
    topic_name: str

    publisher: Publisher = Bound()
    sampled: TickSensor = Bound()
    last: int = State(default=-1)

    def publish_samples(self, context: Context, sensor: TickSensor) -> None:
        """Create the publisher on `topicName` for the samples of a sensor, at no more than one message per tick."""
        self.sampled = sensor
        rate = min(sensor.rate, 1.0 / context.clock.delta)
        facts: dict[str, Any] = {"namespace_from": sensor.prim_path, "rate": rate, "frame_id": self.frame_id}
        self.publisher = self.open_topic(context, self.message_type, self.topic_name, **facts)

    def compute(self) -> None:
        """Publish the sample of this tick, if it is new and the topic has subscribers."""
        sensor = self.sampled
        if not sensor.due or sensor.index == self.last:
            return
        self.last = sensor.index
        if self.publisher.wanted:
            send(self.publisher, DEFINITIONS.message_class(self.message_type)(*self.values()))

    def values(self) -> tuple[Any, ...]:
        """Return the fields of the message with the newest sample, in the order of its definition."""
        raise NotImplementedError
