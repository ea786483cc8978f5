"""Bases of nodes with topics: inputs for domain, namespace and QoS; nothing is published without subscribers."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher, Subscription
from graphengine.node import BadValueError, Bound, Buffer, Context, ExecIn, In, Node, String, UInt64


class NetworkNode(Node):
    """Base of nodes that open topics or services, with inputs for domain and namespace."""

    exec_in = ExecIn()
    context: UInt64 = In(default=0, setup=True, doc="domain handle from a ROS2Context; 0: the session's domain")
    node_namespace: String = In(
        default="", setup=True, doc="ROS namespace; if empty, collected from `isaac:namespace` of the ancestor prims"
    )

    def endpoint(self) -> dict[str, Any]:
        """Return the options of a topic or service that the inputs set: namespace and domain."""
        return {"namespace": self.node_namespace, "ros_context": self.context}


class TopicNode(NetworkNode):
    """Base of nodes that open topics, with inputs for the QoS."""

    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; if empty: reliable, volatile, depth `queueSize`"
    )
    queue_size: UInt64 = In(default=10, setup=True, doc="history depth if `qosProfile` is empty")

    def open_topic(self, context: Context, message_type: str, topic: str, **facts: Any) -> Publisher:
        """Open a topic to publish on; `facts` are keyword arguments of `Context.publisher`."""
        return context.publisher(message_type, topic, **self.endpoint(), **facts)

    def listen(self, context: Context, message_type: str, topic: str, **facts: Any) -> Subscription:
        """Subscribe to a topic; `facts` are keyword arguments of `Context.subscription`."""
        return context.subscription(message_type, topic, **self.endpoint(), **facts)

    def endpoint(self) -> dict[str, Any]:
        """Return the options of a topic that the inputs set: namespace, QoS and domain."""
        return {**super().endpoint(), "qos_profile": self.qos_profile, "queue_size": self.queue_size}


class PublisherNode(TopicNode):
    """Base of nodes that publish one message per execution; a subclass defines `message_type`, `topicName` and `message`."""

    message_type: ClassVar[str]
    topic_name: str

    publisher: Publisher = Bound()

    def setup(self, context: Context) -> None:
        """Open the topic."""
        self.publisher = self.open(context)

    def open(self, context: Context, **facts: Any) -> Publisher:
        """Open the topic `topicName`; `facts` are keyword arguments of `Context.publisher`."""
        return self.open_topic(context, self.message_type, self.topic_name, **facts)

    def compute(self) -> None:
        """Publish a message, if the topic has subscribers.

        Raises:
            BadValueError: the message cannot hold an input's value.
        """
        if self.publisher.wanted:
            send(self.publisher, self.message())

    def message(self) -> Any:
        """Build the message of this execution."""
        raise NotImplementedError


class SensorPublisher(PublisherNode):
    """Base of nodes that publish a measurement from inputs, with a header; a subclass also defines `frameId`."""

    frame_id: str
    time_stamp: float = In(default=0.0, unit="s")

    def open(self, context: Context, **facts: Any) -> Publisher:
        """Open the topic `topicName`, for messages in the frame `frameId`."""
        return super().open(context, frame_id=self.frame_id, **facts)

    def header(self) -> messages.Header:
        """Build the header of this execution's message."""
        return header(self.time_stamp, self.publisher.claim.frame_id)


def array_or_buffer(array: NDArray[Any], buffer: Buffer) -> Buffer:
    """Return the array, or the buffer if the array is empty and a buffer is given."""
    return array if len(array) or isinstance(buffer, int) else buffer


def bytes_in(buffer: Buffer) -> NDArray[np.uint8]:
    """Return the bytes of a buffer, copied only if they are not contiguous."""
    view = memoryview(buffer)
    return np.frombuffer(view if view.c_contiguous else view.tobytes(), np.uint8)


def send(publisher: Publisher, message: Any) -> None:
    """Publish a message.

    Raises:
        BadValueError: a field cannot hold its value.
    """
    try:
        publisher.publish(message)
    except messages.MessageError as error:
        raise BadValueError("message", message) from error


def header(seconds: float, frame_id: str, port: str = "timeStamp") -> messages.Header:
    """Build a header from a frame and a time in seconds, the value of `port`. Raises the same errors as `stamp`."""
    return messages.Header(stamp(seconds, port), frame_id)


def stamp(seconds: float, port: str = "timeStamp") -> messages.Time:
    """Convert a time in seconds, the value of `port`, to a ROS time.

    Raises:
        BadValueError: the time is out of the range of a message.
    """
    try:
        return messages.stamp(seconds)
    except messages.MessageError as error:
        raise BadValueError(port, seconds) from error
