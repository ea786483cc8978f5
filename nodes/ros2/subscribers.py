"""Subscribers: the newest message of a tick, delivered once."""

from __future__ import annotations

import math

from graphengine.context import Clock, Context, Subscription
from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.types import String, UInt64, Vector3d

_STILL = (0.0, 0.0, 0.0)
_ROUNDING = 1e-9  # s; 9 / 60 - 3 / 60 is a little less than 0.1


class ROS2SubscribeTwist(Node, type="isaacsim.ros2.bridge.ROS2SubscribeTwist", gated=True):
    """Velocities of geometry_msgs/Twist; fires when a message came. One that is not finite is dropped, and told.

    With a timeout, silence for so long after a message sets both velocities to zero and fires once.
    """

    exec_in = ExecIn()
    context: UInt64 = In(default=0, setup=True, doc="handle from a ROS2Context; 0 is the session's domain")
    node_namespace: String = In(
        default="", setup=True, doc="used as it is; empty for `isaac:namespace` of the prims above"
    )
    topic_name: String = In(default="cmd_vel", setup=True)
    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; empty for reliable, volatile, queueSize"
    )
    queue_size: UInt64 = In(default=10, setup=True, doc="history depth, when no QoS profile is given")
    timeout: float = In(
        default=0.0, ge=0.0, unit="s", extension=True, doc="silence of simulation time that stops; 0 for never"
    )
    exec_out = ExecOut(doc="fires on a message, and once on a timeout")
    linear_velocity: Vector3d = Out(default=_STILL, unit="m/s")
    angular_velocity: Vector3d = Out(default=_STILL, unit="rad/s")

    subscription: Subscription = State()
    clock: Clock = State()
    logger: Context = State()
    heard: float = State(default=math.inf)

    def setup(self, context: Context) -> None:
        """Open the topic."""
        self.clock, self.logger = context.clock, context
        self.subscription = context.subscription(
            "geometry_msgs/msg/Twist",
            self.topic_name,
            namespace=self.node_namespace,
            qos_profile=self.qos_profile,
            queue_size=self.queue_size,
            ros_context=self.context,
        )

    def compute(self) -> Fire:
        """Take the newest message, or notice the silence."""
        message = self.subscription.newest()
        if message is not None:
            linear, angular = message.linear, message.angular
            values = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
            if all(map(math.isfinite, values)):
                self.linear_velocity, self.angular_velocity = values[:3], values[3:]
                self.heard = self.clock.time
                return self.exec_out
            self.logger.log("warning", f"{self.subscription.topic}: a Twist that is not finite was dropped")
        if self.timeout and self.clock.time - self.heard >= self.timeout - _ROUNDING:
            self.linear_velocity = self.angular_velocity = _STILL
            self.heard = math.inf
            return self.exec_out
        return None
