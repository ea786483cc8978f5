"""What nodes with topics have in common: where they are, with which QoS, and that nothing is built that nobody wants."""

from __future__ import annotations

from typing import Any, ClassVar

from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher, Subscription
from graphengine.node import BadValueError, Bound, Context, ExecIn, In, Node, String, UInt64


class NetworkNode(Node):
    """A node that is executed and is on the network, in a domain and a namespace that its ports give."""

    exec_in = ExecIn()
    context: UInt64 = In(default=0, setup=True, doc="handle from a ROS2Context; 0 is the session's domain")
    node_namespace: String = In(
        default="", setup=True, doc="used as it is; empty for `isaac:namespace` of the prims above"
    )

    def endpoint(self) -> dict[str, Any]:
        """What the ports say of a topic or service besides its type and name."""
        return {"namespace": self.node_namespace, "ros_context": self.context}


class TopicNode(NetworkNode):
    """A node that opens topics, whose QoS its ports give."""

    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; empty for reliable, volatile, queueSize"
    )
    queue_size: UInt64 = In(default=10, setup=True, doc="history depth, when no QoS profile is given")

    def open_topic(self, context: Context, message_type: str, topic: str, **facts: Any) -> Publisher:
        """A topic to write to; `facts` as for `Context.publisher`."""
        return context.publisher(message_type, topic, **self.endpoint(), **facts)

    def listen(self, context: Context, message_type: str, topic: str, **facts: Any) -> Subscription:
        """A topic to read from; `facts` as for `Context.subscription`."""
        return context.subscription(message_type, topic, **self.endpoint(), **facts)

    def endpoint(self) -> dict[str, Any]:
        """What the ports say of a topic besides its type and name."""
        return {**super().endpoint(), "qos_profile": self.qos_profile, "queue_size": self.queue_size}


class PublisherNode(TopicNode):
    """A node that sends one message an execution; a subclass gives `message_type`, `topicName` and `message`."""

    message_type: ClassVar[str]
    topic_name: str

    publisher: Publisher = Bound()

    def setup(self, context: Context) -> None:
        """Open the topic."""
        self.publisher = self.open(context)

    def open(self, context: Context, **facts: Any) -> Publisher:
        """The topic that the ports name; `facts` as for `Context.publisher`."""
        return self.open_topic(context, self.message_type, self.topic_name, **facts)

    def compute(self) -> None:
        """Send a message, if anybody wants it.

        Raises:
            BadValueError: the inputs make no message.
        """
        if self.publisher.wanted:
            send(self.publisher, self.message())

    def message(self) -> Any:
        """The message of this execution."""
        raise NotImplementedError


class SensorPublisher(PublisherNode):
    """A publisher of what a sensor measured, from arrays and numbers; a subclass gives `frameId` too."""

    frame_id: str
    time_stamp: float = In(default=0.0, unit="s")

    def open(self, context: Context, **facts: Any) -> Publisher:
        """The topic that the ports name, with its frame."""
        return super().open(context, frame_id=self.frame_id, **facts)

    def header(self) -> messages.Header:
        """Time and frame of this execution's message."""
        return header(self.time_stamp, self.frame_id)


def send(publisher: Publisher, message: Any) -> None:
    """Publish a message.

    Raises:
        BadValueError: a field of it cannot hold its value.
    """
    try:
        publisher.publish(message)
    except messages.MessageError as error:
        raise BadValueError("message", message) from error


def header(seconds: float, frame_id: str, port: str = "timeStamp") -> messages.Header:
    """A header with that time and frame; errors as for `stamp`."""
    return messages.Header(stamp(seconds, port), frame_id)


def stamp(seconds: float, port: str = "timeStamp") -> messages.Time:
    """A time in seconds, given by `port`, as ROS writes it.

    Raises:
        BadValueError: the time is beyond what a message can hold.
    """
    try:
        return messages.stamp(seconds)
    except messages.MessageError as error:
        raise BadValueError(port, seconds) from error
