"""Subscriber nodes, each for one message type. They output only the newest message of a tick."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from graphengine.messages import messages
from graphengine.messages.endpoints import Subscription
from graphengine.node import Bound, Clock, Context, ExecOut, Fire, In, Out, State
from graphengine.node.types import Doubles, String, Token, Tokens, Vector3d
from graphengine.nodes.ros2.publisher import TopicNode

_STILL = (0.0, 0.0, 0.0)
_ROUNDING = 1e-9  # s; 9 / 60 - 3 / 60 is a little less than 0.1
_TWISTS = {"twist": "geometry_msgs/msg/Twist", "twist_stamped": "geometry_msgs/msg/TwistStamped"}


class SubscriberNode(TopicNode):
    """Base of nodes that output the newest message of a tick; a subclass defines `message_type`, `topic_name` and `deliver`."""

    message_type: ClassVar[str]
    topic_name: str

    exec_out = ExecOut(doc="fires once in each tick in which messages arrived")

    subscription: Subscription = Bound()
    logger: Context = Bound()

    def setup(self, context: Context) -> None:
        """Create the subscription on `topicName`."""
        self.logger = context
        self.subscription = self.listen(context, self.message_type, self.topic_name)

    def compute(self) -> Fire:
        """Output the newest message of this tick and fire, if a message arrived and can be used."""
        message = self.subscription.newest()
        if message is None:
            return None
        fault = self.deliver(message)
        if fault:
            self.logger.log_dropped(f"{self.subscription.topic}: {fault} was dropped")
            return None
        return self.exec_out

    def deliver(self, message: Any) -> str:
        """Set the outputs from a message and return an empty string.

        If the message must be dropped, return a description of it instead, for the log entry "TOPIC: DESCRIPTION was dropped".
        """
        raise NotImplementedError


class ROS2SubscribeTwist(SubscriberNode, type="isaacsim.ros2.bridge.ROS2SubscribeTwist", gated=True):
    """Receives geometry_msgs/Twist or TwistStamped and fires when a message arrives.

    If `type` is `auto`, the node subscribes to the type of the topic's publisher, or to Twist if there is no publisher; Nav2
    publishes Twist in ROS 2 Jazzy and TwistStamped in later releases. The header of a TwistStamped is ignored. A message with
    infinite or NaN numbers is dropped and logged. If no message arrives for `timeout` after the last one, both velocities become
    zero and `execOut` fires once.
    """

    topic_name: String = In(default="cmd_vel", setup=True)
    type_in: Token = In(
        default="auto",
        name="type",
        setup=True,
        tokens=("auto", *_TWISTS),
        extension=True,
        doc="message type; `auto`: the type of the topic's publisher",
    )
    timeout: float = In(
        default=0.0,
        ge=0.0,
        unit="s",
        extension=True,
        doc="simulation time without messages after which both velocities become zero; 0: never",
    )
    linear_velocity: Vector3d = Out(default=_STILL, unit="m/s")
    angular_velocity: Vector3d = Out(default=_STILL, unit="rad/s")

    clock: Clock = Bound()
    heard: float = State(default=math.inf)

    def setup(self, context: Context) -> None:
        """Create the subscription on `topicName`, for one message type or for both."""
        self.clock, self.logger = context.clock, context
        first, *others = _TWISTS.values() if self.type_in == "auto" else (_TWISTS[self.type_in],)
        self.subscription = self.listen(context, first, self.topic_name, alternatives=others)

    def compute(self) -> Fire:
        """Output the newest message, or zero velocities after the timeout."""
        if (fired := super().compute()) is not None:
            self.heard = self.clock.time
            return fired
        if self.timeout and self.clock.time - self.heard >= self.timeout - _ROUNDING:
            self.linear_velocity = self.angular_velocity = _STILL
            self.heard = math.inf
            return self.exec_out
        return None

    def deliver(self, message: Any) -> str:
        """Set both velocities and return an empty text; if a number is infinite or NaN, return the reason to drop the message."""
        twist = message.twist if isinstance(message, messages.TwistStamped) else message
        linear, angular = twist.linear, twist.angular
        values = (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
        if not all(map(math.isfinite, values)):
            return "a Twist that is not finite"
        self.linear_velocity, self.angular_velocity = values[:3], values[3:]
        return ""


class ROS2SubscribeClock(SubscriberNode, type="isaacsim.ros2.bridge.ROS2SubscribeClock", gated=True):
    """Receives rosgraph_msgs/Clock and fires when a message arrives."""

    message_type: ClassVar[str] = "rosgraph_msgs/msg/Clock"

    topic_name: String = In(default="clock", setup=True)
    time_stamp: float = Out(unit="s")

    def deliver(self, message: Any) -> str:
        """Set `timeStamp` to the time in the message."""
        self.time_stamp = messages.seconds(message.clock)
        return ""


class ROS2SubscribeJointState(SubscriberNode, type="isaacsim.ros2.bridge.ROS2SubscribeJointState", gated=True):
    """Receives joint commands as sensor_msgs/JointState and fires when a message arrives.

    If an array in the message does not have one number per joint, the output for this array is NaN for each joint;
    IsaacArticulationController ignores NaN. A message is dropped and logged if it has no joints, if none of its arrays has one
    number per joint, or if a number is infinite.
    """

    message_type: ClassVar[str] = "sensor_msgs/msg/JointState"

    topic_name: String = In(default="joint_command", setup=True)
    time_stamp: float = Out(unit="s", doc="stamp in the message's header")
    joint_names: Tokens = Out()
    position_command: Doubles = Out(unit="rad, m")
    velocity_command: Doubles = Out(unit="rad/s, m/s")
    effort_command: Doubles = Out(unit="N m, N")

    def deliver(self, message: Any) -> str:
        """Set the outputs for time, joint names and commands; return the reason to drop the message, or an empty text."""
        joints = len(message.name)
        arrays = (message.position, message.velocity, message.effort)
        if not joints:
            return "a JointState without joints"
        if all(len(array) != joints for array in arrays):
            lengths = ", ".join(str(len(array)) for array in arrays)
            return f"a JointState of {joints} joints with {lengths} positions, velocities and efforts"
        if any(np.isinf(array).any() for array in arrays):
            return "a JointState with an infinite number"
        self.time_stamp = messages.seconds(message.header.stamp)
        self.joint_names = tuple(message.name)
        self.position_command, self.velocity_command, self.effort_command = (_one_each(a, joints) for a in arrays)
        return ""


def _one_each(array: NDArray[np.float64], joints: int) -> NDArray[np.float64]:
    return array.astype(np.float64, copy=False) if len(array) == joints else np.full(joints, np.nan)


class ROS2SubscribeAckermannDrive(SubscriberNode, type="isaacsim.ros2.bridge.ROS2SubscribeAckermannDrive", gated=True):
    """Receives ackermann_msgs/AckermannDriveStamped and fires when a message arrives.

    A message with infinite or NaN numbers is dropped and logged.
    """

    message_type: ClassVar[str] = "ackermann_msgs/msg/AckermannDriveStamped"

    topic_name: String = In(default="ackermann_cmd", setup=True)
    frame_id: String = Out(default="", doc="frame in the message's header")
    time_stamp: float = Out(unit="s", doc="stamp in the message's header")
    steering_angle: float = Out(unit="rad")
    steering_angle_velocity: float = Out(unit="rad/s")
    speed: float = Out(unit="m/s")
    acceleration: float = Out(unit="m/s2")
    jerk: float = Out(unit="m/s3")

    def deliver(self, message: Any) -> str:
        """Set the drive command and the values of the header, or return "an AckermannDrive that is not finite"."""
        drive = message.drive
        values = (drive.steering_angle, drive.steering_angle_velocity, drive.speed, drive.acceleration, drive.jerk)
        if not all(map(math.isfinite, values)):
            return "an AckermannDrive that is not finite"
        self.frame_id, self.time_stamp = message.header.frame_id, messages.seconds(message.header.stamp)
        self.steering_angle, self.steering_angle_velocity, self.speed, self.acceleration, self.jerk = values
        return ""
