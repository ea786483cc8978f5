"""Publisher and subscriber of any message, whose fields are ports."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import Publisher, Subscription
from graphengine.node import Bound, Context, ExecOut, In, Out, Pushes, String, Token
from graphengine.nodes.ros2.fields import Layout, expect, find_layout
from graphengine.nodes.ros2.publisher import TopicNode


class GenericNode(TopicNode):
    """A node with one topic, whose message its inputs name; the file gives them, for ports are made before wires are read."""

    layout: ClassVar[Layout]

    topic_name: String = In(default="topic", setup=True)
    message_package: String = In(required=True, setup=True, doc="package of the message, such as geometry_msgs")
    message_subfolder: String = In(default="msg", setup=True, doc="where in the package the message is defined")
    message_name: String = In(required=True, setup=True, doc="such as Twist")

    def bind(self) -> Layout:
        """The layout that the class was made with.

        Raises:
            ContextError: the inputs name another message by now.
        """
        named = f"{self.message_package}/{self.message_subfolder}/{self.message_name}"
        layout: Layout | None = getattr(self, "layout", None)
        expect(layout.message_type if layout else None, named)
        assert layout is not None
        return layout


class ROS2Publisher(GenericNode, type="isaacsim.ros2.bridge.ROS2Publisher"):
    """Publishes any message; its fields are inputs, such as `linear:x` of a Twist.

    `graphrun nodes ROS2Publisher --message geometry_msgs/msg/Twist` shows them. An array of messages is an array of texts,
    each a message as JSON. What nobody sets is as in a new message of ROS 2: zero, but for the w of a quaternion, which is 1.
    """

    exec_out = ExecOut()

    publisher: Publisher = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """An input for each field."""
        layout = find_layout(literals, definitions)
        return {"layout": layout, **layout.ports(In, {port.name for port in cls.fields.values()})}

    def setup(self, context: Context) -> None:
        """Open the topic."""
        layout = self.bind()
        layout.check(self)
        self.publisher = self.open_topic(context, layout.message_type, self.topic_name)

    def compute(self) -> None:
        """Send a message, if anybody wants it.

        Raises:
            BadValueError: the message cannot hold what an input does.
        """
        if self.publisher.wanted:
            self.layout.send(self, self.publisher.publish)


class ROS2Subscriber(GenericNode, type="isaacsim.ros2.bridge.ROS2Subscriber"):
    """Delivers any message; its fields are outputs, such as `linear:x` of a Twist.

    `graphrun nodes ROS2Subscriber --message geometry_msgs/msg/Twist` shows them. An array of messages is an array of texts,
    each a message as JSON. Of several messages in a tick each one runs what hangs on `execOut`, oldest first.
    """

    delivery: Token = In(
        default="each", tokens=("each", "newest"), extension=True, doc="every message of a tick, or the newest alone"
    )
    exec_out = ExecOut(doc="fires for each message")

    subscription: Subscription = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """An output for each field."""
        layout = find_layout(literals, definitions)
        return {"layout": layout, **layout.ports(Out)}

    def setup(self, context: Context) -> None:
        """Open the topic."""
        self.subscription = self.listen(context, self.bind().message_type, self.topic_name)

    def compute(self) -> Pushes:
        """Deliver what came."""
        if self.delivery == "newest":
            newest = self.subscription.newest()
            arrived = () if newest is None else (newest,)
        else:
            arrived = tuple(self.subscription.take())
        for message in arrived:
            self.layout.write(self, message)
            yield self.exec_out
