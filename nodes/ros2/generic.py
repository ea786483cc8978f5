"""Publisher and subscriber for any message type, with a port for each field."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import Publisher, Subscription
from graphengine.node import Bound, Context, ExecOut, In, Out, Pushes, String, Token
from graphengine.nodes.ros2.fields import Layout, expect, find_layout
from graphengine.nodes.ros2.publisher import TopicNode


class GenericNode(TopicNode):
    """Base of nodes with one topic of any message type, which the graph file sets: ports are made before wires are read."""

    layout: ClassVar[Layout]

    topic_name: String = In(default="topic", setup=True)
    message_package: String = In(required=True, setup=True, doc="package of the message type, such as geometry_msgs")
    message_subfolder: String = In(default="msg", setup=True, doc="folder of the message type in the package")
    message_name: String = In(required=True, setup=True, doc="name of the message type, such as Twist")

    def bind(self) -> Layout:
        """Return the mapping between the node's ports and the fields of the message.

        Raises:
            ContextError: the inputs name a message type other than the one the ports were made for.
        """
        expect(getattr(self, "layout", None), self.message_package, self.message_subfolder, self.message_name)
        return self.layout


class ROS2Publisher(GenericNode, type="isaacsim.ros2.bridge.ROS2Publisher"):
    """Publishes a message of any type; its fields are inputs, such as `linear:x` of a Twist.

    `graphrun nodes ROS2Publisher --message geometry_msgs/msg/Twist` lists them. An input for an array of messages takes
    tokens, each with one message as JSON. An input that is not set has the ROS 2 default of its field: 0, but 1 for the w of a
    quaternion.
    """

    exec_out = ExecOut()

    publisher: Publisher = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Make an input for each field."""
        layout = find_layout(literals, definitions)
        return {"layout": layout, **layout.ports(In, {port.name for port in cls.fields.values()})}

    def setup(self, context: Context) -> None:
        """Open the topic."""
        layout = self.bind()
        layout.check(self)
        self.publisher = self.open_topic(context, layout.message_type, self.topic_name)

    def compute(self) -> None:
        """Publish a message, if the topic has subscribers.

        Raises:
            BadValueError: the message cannot hold an input's value.
        """
        if self.publisher.wanted:
            self.layout.send(self, self.publisher.publish)


class ROS2Subscriber(GenericNode, type="isaacsim.ros2.bridge.ROS2Subscriber"):
    """Receives messages of any type; their fields are outputs, such as `linear:x` of a Twist.

    `graphrun nodes ROS2Subscriber --message geometry_msgs/msg/Twist` lists them. An array of messages is an array of tokens,
    each of which is one message as JSON. Each message that arrived in a tick fires `execOut` once, oldest first.
    """

    delivery: Token = In(
        default="each",
        tokens=("each", "newest"),
        extension=True,
        doc="which messages of a tick fire: each, or the newest",
    )
    exec_out = ExecOut(doc="fires once for each message that is output")

    subscription: Subscription = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Make an output for each field."""
        layout = find_layout(literals, definitions)
        return {"layout": layout, **layout.ports(Out)}

    def setup(self, context: Context) -> None:
        """Open the topic."""
        self.subscription = self.listen(context, self.bind().message_type, self.topic_name)

    def compute(self) -> Pushes:
        """Yield once for each message, after setting the outputs."""
        if self.delivery == "newest":
            newest = self.subscription.newest()
            arrived = () if newest is None else (newest,)
        else:
            arrived = tuple(self.subscription.take())
        for message in arrived:
            self.layout.write(self, message)
            yield self.exec_out
