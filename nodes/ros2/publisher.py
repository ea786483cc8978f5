"""Base classes of nodes with topics, and functions that build headers and publish messages."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.messages import messages
from graphengine.messages.endpoints import Publisher, Subscription
from graphengine.node import BadValueError, Bound, Buffer, Context, ExecIn, In, Node, String, UInt64


class NetworkNode(Node):
    """Base of nodes that create publishers, subscriptions or services, with inputs for domain and namespace."""

    exec_in = ExecIn()
    context: UInt64 = In(default=0, setup=True, doc="ROS domain: handle from a ROS2Context; 0: the session's domain")
    node_namespace: String = In(
        default="", setup=True, doc="ROS namespace; if empty, collected from `isaac:namespace` of the ancestor prims"
    )

    def endpoint(self) -> dict[str, Any]:
        """Return the inputs for namespace and domain as keyword arguments for the creation of a topic or service endpoint."""
        return {"namespace": self.node_namespace, "ros_context": self.context}


class TopicNode(NetworkNode):
    """Base of nodes that create publishers or subscriptions, with inputs for the QoS of these endpoints."""

    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; if empty: reliable, volatile, depth `queueSize`"
    )
    queue_size: UInt64 = In(default=10, setup=True, doc="history depth if `qosProfile` is empty")

    def open_topic(self, context: Context, message_type: str, topic: str, **facts: Any) -> Publisher:
        """Create a publisher with the QoS, namespace and domain that the inputs give.

        `facts` are further keyword arguments of `Context.publisher`.
        """
        return context.publisher(message_type, topic, **self.endpoint(), **facts)

    def listen(self, context: Context, message_type: str, topic: str, **facts: Any) -> Subscription:
        """Create a subscription with the QoS, namespace and domain that the inputs give.

        `facts` are further keyword arguments of `Context.subscription`.
        """
        return context.subscription(message_type, topic, **self.endpoint(), **facts)

    def endpoint(self) -> dict[str, Any]:
        """Return the inputs for namespace, QoS and domain as keyword arguments for the creation of a topic endpoint."""
        return {**super().endpoint(), "qos_profile": self.qos_profile, "queue_size": self.queue_size}


class PublisherNode(TopicNode):
    """Base of nodes that publish one message per execution, unless the topic has no subscribers.

    A subclass defines `message_type`, `topic_name` and `message`.
    """

    message_type: ClassVar[str]
    topic_name: str
    time_stamp: float = In(default=0.0, unit="s")

    publisher: Publisher = Bound()

    def setup(self, context: Context) -> None:
        """Create the publisher on `topicName`."""
        self.publisher = self.open(context)

    def open(self, context: Context, **facts: Any) -> Publisher:
        """Create the publisher on `topicName`; `facts` are further keyword arguments of `Context.publisher`."""
        return self.open_topic(context, self.message_type, self.topic_name, **facts)

    def compute(self) -> None:
        """Publish a message, if the topic has subscribers.

        Raises:
            BadValueError: the value of an input does not fit its message field.
        """
        if self.publisher.wanted:
            send(self.publisher, self.message())

    def message(self) -> Any:
        """Return the message that this execution publishes."""
        raise NotImplementedError


class SensorPublisher(PublisherNode):
    """Base of nodes that publish the measurement in their inputs as a message with a header. Subclasses add `frame_id`."""

    frame_id: str

    def open(self, context: Context, **facts: Any) -> Publisher:
        """Create the publisher on `topicName`, for messages in the frame `frameId`."""
        return super().open(context, frame_id=self.frame_id, **facts)

    def header(self) -> messages.Header:
        """Return the header of the message: the time `timeStamp` and the published name of the frame `frameId`."""
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
        BadValueError: a value does not fit its field of the message.
    """
    try:
        publisher.publish(message)
    except messages.MessageError as error:
        raise BadValueError("message", message) from error


def header(seconds: float, frame_id: str, port: str = "timeStamp") -> messages.Header:
    """Return a header with a frame and a time in seconds, the value of the input `port`.

    Raises:
        BadValueError: the time is out of the range of builtin_interfaces/Time.
    """
    return messages.Header(stamp(seconds, port), frame_id)


def stamp(seconds: float, port: str = "timeStamp") -> messages.Time:
    """Convert a time in seconds, the value of the input `port`, to a ROS time.

    Raises:
        BadValueError: the time is out of the range of builtin_interfaces/Time.
    """
    try:
        return messages.stamp(seconds)
    except messages.MessageError as error:
        raise BadValueError(port, seconds) from error
