"""Base class of action server nodes that move joints of a robot, one goal at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphengine.messages import messages
from graphengine.messages.actions import ActionServer, Goal
from graphengine.node import Bound, Clock, Context, ExecOut, In, Out, State
from graphengine.node.types import Doubles, String, Tokens, UInt64
from graphengine.nodes.core.articulation import RobotNode
from graphengine.nodes.ros2.joint_spline import Floats


class RobotActionNode(RobotNode):
    """Base of action server nodes that command joints; the outputs are wired to an IsaacArticulationController.

    `execOut` fires only in ticks with a command: other nodes can command the joints between goals.
    """

    context: UInt64 = In(default=0, setup=True, doc="ROS domain: handle from a ROS2Context; 0: the session's domain")
    node_namespace: String = In(
        default="", setup=True, doc="ROS namespace; if empty, collected from `isaac:namespace` of the ancestor prims"
    )
    exec_out = ExecOut(doc="fires in each execution that commands joints")
    joint_names_out: Tokens = Out(name="jointNames", doc="names of the commanded joints, in the order of the commands")
    position_command: Doubles = Out(unit="rad, m", doc="position set point of each joint in `jointNames`")
    velocity_command: Doubles = Out(unit="rad/s, m/s", doc="velocity set point of each joint in `jointNames`")

    clock: Clock = Bound()
    logger: Context = Bound()
    server: ActionServer = Bound()
    commanded: Tokens = Bound()
    goal: Goal | None = State(default=None)

    def bind(self, context: Context, action_type: str, action: str) -> None:
        """Look up the robot and create the action server.

        Args:
            context: context of the node.
            action_type: ROS name of the action type.
            action: name of the action.
        """
        self.articulation = context.articulation(self.prim())
        self.clock, self.logger = context.clock, context
        self.server = context.action_server(action_type, action, collects_namespace=True, **self.endpoint())

    def endpoint(self) -> dict[str, Any]:
        """Return the inputs for namespace and domain as keyword arguments for the creation of endpoints."""
        return {"namespace": self.node_namespace, "ros_context": self.context}

    def command(self, positions: Floats, velocities: Floats) -> int:
        """Output the set points of the joints `commanded`, in rad or m and rad/s or m/s; return the port to fire."""
        self.joint_names_out = self.commanded
        self.position_command = np.minimum(np.maximum(positions, -_LARGEST), _LARGEST)  # a third of the time of `clip`
        self.velocity_command = np.minimum(np.maximum(velocities, -_LARGEST), _LARGEST)
        return self.exec_out


_LARGEST = 1e9
"""Maximum magnitude of a set point; the physics accepts up to 1e10."""


def message(message_type: str, *values: Any) -> Any:
    """Return a message of a type; the values of its fields are in the order of the definition."""
    return messages.message_class(message_type)(*values)


def duration(seconds: float) -> Any:
    """Return a builtin_interfaces/Duration, rounded to nanoseconds."""
    return message("builtin_interfaces/msg/Duration", *divmod(round(seconds * 1e9), 1_000_000_000))
