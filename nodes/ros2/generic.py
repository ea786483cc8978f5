"""A publisher node and a subscriber node for any message type, with a port for each message field."""

from __future__ import annotations

from typing import ClassVar

from graphengine.messages.endpoints import Publisher, Subscription
from graphengine.node import Bound, Context, ExecOut, In, Out, Pushes, String, Token
from graphengine.nodes.ros2.fields import FieldNode, Layout
from graphengine.nodes.ros2.publisher import TopicNode


class GenericNode(TopicNode, FieldNode):
    """Base of nodes with one topic of any message type and a port for each message field."""

    folder = "msg"
    message: ClassVar[Layout]

    topic_name: String = In(default="topic", setup=True)
    message_package: String = In(required=True, setup=True, doc="package of the message type, such as geometry_msgs")
    message_subfolder: String = In(default="msg", setup=True, doc="folder of the package that holds the message type")
    message_name: String = In(required=True, setup=True, doc="name of the message type, such as Twist")


class ROS2Publisher(GenericNode, type="isaacsim.ros2.bridge.ROS2Publisher"):
    """Publishes messages of any type; the message fields are inputs, such as `linear:x` of a Twist.

    `graphrun nodes ROS2Publisher --message geometry_msgs/msg/Twist` lists these inputs. The input of a field that is an array of
    messages is an array of tokens; each token is one message as JSON. An input that is not set has the default that ROS 2 defines
    for its field, for example 0 for a number, but 1 for `w` of a quaternion.
    """

    parts: ClassVar = {"message": In}

    exec_out = ExecOut()

    publisher: Publisher = Bound()

    def setup(self, context: Context) -> None:
        """Check the values of the inputs, and create the publisher on `topicName`."""
        self.publisher = self.open_topic(context, self.bind(), self.topic_name)

    def compute(self) -> None:
        """Publish a message with the values of the inputs, if the topic has subscribers.

        Raises:
            BadValueError: the value of an input does not fit its message field.
        """
        if self.publisher.wanted:
            self.message.send(self, self.publisher.publish)


class ROS2Subscriber(GenericNode, type="isaacsim.ros2.bridge.ROS2Subscriber"):
    """Receives messages of any type; the message fields are outputs, such as `linear:x` of a Twist.

    `graphrun nodes ROS2Subscriber --message geometry_msgs/msg/Twist` lists these outputs. The output of a field that is an array
    of messages is an array of tokens; each token is one message as JSON. `delivery` selects whether `execOut` fires once for each
    message that arrived in the tick, oldest first, or only for the newest message.
    """

    parts: ClassVar = {"message": Out}

    delivery: Token = In(
        default="each",
        tokens=("each", "newest"),
        extension=True,
        doc="messages that are output if several arrived in a tick: each of them, or only the newest",
    )
    exec_out = ExecOut(doc="fires once for each message that is output")

    subscription: Subscription = Bound()

    def setup(self, context: Context) -> None:
        """Create the subscription on `topicName`."""
        self.subscription = self.listen(context, self.bind(), self.topic_name)

    def compute(self) -> Pushes:
        """Set the outputs from each message, or from the newest only, and yield the port to fire after each."""
        if self.delivery == "newest":
            newest = self.subscription.newest()
            arrived = () if newest is None else (newest,)
        else:
            arrived = tuple(self.subscription.take())
        for message in arrived:
            self.message.write(self, message)
            yield self.exec_out
