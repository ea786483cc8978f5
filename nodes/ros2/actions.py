"""Nodes for an action client or an action server of any action type, with a port for each field.

An action server consists of three nodes: ROS2ActionServerGoal, ROS2ActionServerFeedback and ROS2ActionServerResult.
"""

from __future__ import annotations

from typing import Any, ClassVar

from graphengine.format.errors import BadValueError, ContextError
from graphengine.messages.action_client import ActionClient
from graphengine.messages.actions import ActionServer, Goal
from graphengine.messages.goals import STATUS_NAMES
from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Out, Pushes, State, String, Token, UInt64
from graphengine.nodes.ros2.fields import FieldNode, Layout


class ActionNode(FieldNode):
    """Base of action nodes that have a port for each field of the action type."""

    folder = "action"
    goal: ClassVar[Layout]
    result: ClassVar[Layout]
    feedback: ClassVar[Layout]

    message_package: String = In(required=True, setup=True, doc="package of the action type, such as `control_msgs`")
    message_subfolder: String = In(default="action", setup=True, doc="folder of the package that holds the action type")
    message_name: String = In(required=True, setup=True, doc="name of the action type, such as `FollowJointTrajectory`")


class NamedActionNode(ActionNode):
    """Base of nodes that create an action server or client, with inputs for the action's name, namespace, QoS and domain."""

    exec_in = ExecIn()
    context: UInt64 = In(default=0, setup=True, doc="ROS domain: handle from a ROS2Context; 0: the session's domain")
    node_namespace: String = In(default="", setup=True, doc="ROS namespace; `isaac:namespace` of prims is not added")
    action_name: String = In(default="/action_name", setup=True, doc="name of the action")
    qos_profile: String = In(
        default="", setup=True, doc="JSON from a ROS2QoSProfile; if empty: reliable, volatile, depth 10"
    )

    def endpoint(self) -> dict[str, Any]:
        """Return the inputs for namespace, QoS and domain as keyword arguments for the creation of a server or client."""
        return {"namespace": self.node_namespace, "qos_profile": self.qos_profile, "ros_context": self.context}


class ROS2ActionServerGoal(NamedActionNode, type="graphengine.ros2.ROS2ActionServerGoal"):
    """Creates an action server and outputs the fields of each goal, such as `Goal:order` of a Fibonacci.

    Execute the node in every tick. `graphrun nodes ROS2ActionServerGoal --message example_interfaces/action/Fibonacci` lists the
    outputs for the fields. `onGoal` fires once for each goal. When the nodes downstream of `onGoal` have run, the goal is
    accepted, unless one of them is a ROS2ActionServerResult that rejected the goal. At most one goal is active: if `preempts` is
    true, a new goal aborts the active goal; otherwise the new goal is rejected. Wire `serverHandle` to a
    ROS2ActionServerFeedback, which sends feedback, and to a ROS2ActionServerResult, which ends the goal. When the simulation
    stops, the active goal is aborted.
    """

    parts: ClassVar = {"goal": Out}

    preempts: bool = In(default=True, doc="true: a new goal aborts the active goal; false: it is rejected")
    on_goal = ExecOut(doc="fires once for each goal that arrives")
    on_cancel = ExecOut(
        doc="fires once when a client requests to cancel the active goal; if nothing is wired to it, the goal ends as canceled"
    )
    server_handle: UInt64 = Out(
        default=0, doc="handle of this action server, for ROS2ActionServerFeedback and ROS2ActionServerResult"
    )
    is_active: bool = Out(default=False, doc="whether a goal is active")

    server: ActionServer = Bound()
    tells_of_cancel: bool = Bound()
    cancelling: bytes = State(default=b"")

    def setup(self, context: Context) -> None:
        """Create the action server `actionName`."""
        self.server = context.action_server(self.bind(), self.action_name, **self.endpoint())
        self.server_handle = self.server.handle
        self.tells_of_cancel = context.wired("on_cancel")

    def compute(self) -> Pushes:
        """Fire `onCancel` if a client requests to cancel the active goal, then output each new goal and fire `onGoal`."""
        server = self.server
        self.server_handle = server.handle
        arrived, active = server.goals(), server.current
        if active is not None and active.cancel_requested and active.identity != self.cancelling:
            self.cancelling = active.identity
            if self.tells_of_cancel:
                yield self.on_cancel
            else:
                active.canceled()
        for goal in arrived:
            before = server.current if server.current is not None and server.current.active else None
            if before is not None and not self.preempts:
                goal.reject()
                continue
            server.current = goal
            self.goal.write(self, goal.message)
            self.is_active = True
            yield self.on_goal
            goal.accept()
            if not goal.status:
                server.current = before
            elif before is not None and before.active:
                before.abort()
        self.is_active = server.current is not None and server.current.active
        server.update()


class PursuingNode(ActionNode):
    """Base of nodes that send feedback on the current goal of a ROS2ActionServerGoal or end this goal with a result.

    The fields of the feedback or of the result are inputs of the node.
    """

    exec_in = ExecIn()
    server_handle: UInt64 = In(required=True, doc="handle of the action server, from a ROS2ActionServerGoal")

    door: Context = Bound()

    action_type: str = Bound()

    def setup(self, context: Context) -> None:
        """Check the values of the field inputs and, if `serverHandle` is already set, the action type of the server."""
        self.door, self.action_type = context, self.bind()
        if self.server_handle:
            self._find()

    def _find(self) -> ActionServer:
        server = self.door.action(self.server_handle)
        if server.action_type != self.action_type:
            raise ContextError(
                f"the node is for {self.action_type}, but the action {server.action} has type {server.action_type}",
                self.message_name,
                "name the same action type in both nodes",
            )
        return server

    def find(self) -> tuple[ActionServer, Goal | None]:
        """Return the action server with the handle `serverHandle`, and its current goal.

        The goal is None if the server has no new and no active goal.

        Raises:
            BadValueError: no action server has this handle, or the server has another action type.
        """
        try:
            server = self._find()
        except ContextError as error:
            legal = "the output serverHandle of a ROS2ActionServerGoal with the same action type"
            raise BadValueError("serverHandle", self.server_handle, legal) from error
        goal = server.current
        return server, goal if goal is not None and (goal.pending or goal.active) else None


class ROS2ActionServerFeedback(PursuingNode, type="graphengine.ros2.ROS2ActionServerFeedback", gated=True):
    """Sends feedback on the active goal of a ROS2ActionServerGoal; the fields of the feedback are inputs.

    `graphrun nodes ROS2ActionServerFeedback --message example_interfaces/action/Fibonacci` lists these inputs. If the node is
    executed downstream of `onGoal`, it accepts the new goal. Without a goal, it sends nothing and does not fire.
    """

    parts: ClassVar = {"feedback": In}

    exec_out = ExecOut(doc="fires if the server has a goal")

    def compute(self) -> Fire:
        """Accept the goal if it is new, and send feedback if the feedback topic has subscribers.

        Raises:
            BadValueError: no action server has the handle, the server has another action type, or the value of an input does not
                fit its field.
        """
        server, goal = self.find()
        if goal is None:
            return None
        goal.accept()
        if server.endpoints.feedback.wanted:
            self.feedback.send(self, goal.feedback)
        return self.exec_out


class ROS2ActionServerResult(PursuingNode, type="graphengine.ros2.ROS2ActionServerResult", gated=True):
    """Ends the goal of a ROS2ActionServerGoal; the fields of the result are inputs.

    `graphrun nodes ROS2ActionServerResult --message example_interfaces/action/Fibonacci` lists these inputs. Without a goal,
    the node sends nothing and does not fire.
    """

    parts: ClassVar = {"result": In}

    status: Token = In(
        default="succeeded",
        tokens=("succeeded", "aborted", "canceled", "rejected"),
        doc="final status of the goal; `aborted` is sent instead of `canceled` if no client requested to cancel the goal, and "
        "instead of `rejected` if the goal was already accepted",
    )
    exec_out = ExecOut(doc="fires when the node has ended a goal")

    def compute(self) -> Fire:
        """Send the result and end the goal, or reject a new goal if `status` is `rejected`.

        Raises:
            BadValueError: no action server has the handle, the server has another action type, or the value of an input does not
                fit its field.
        """
        server, goal = self.find()
        if goal is None:
            return None
        if goal.pending and self.status == "rejected":
            goal.reject()
            return self.exec_out
        self.result.send(self, lambda message: self._end(goal, message))
        server.update()
        return self.exec_out

    def _end(self, goal: Goal, message: Any) -> None:
        goal.accept()
        if self.status == "succeeded":
            goal.succeed(message)
        elif self.status == "canceled" and goal.cancel_requested:
            goal.canceled(message)
        else:
            goal.abort(message)


class ROS2ActionClient(NamedActionNode, type="graphengine.ros2.ROS2ActionClient"):
    """Sends goals to an action server, and outputs feedback and results.

    The fields of a goal are inputs, such as `Goal:order`; all other fields are outputs, such as `Result:sequence`.
    `graphrun nodes ROS2ActionClient --message example_interfaces/action/Fibonacci` lists these ports. Every execution of `execIn`
    creates a goal and sends it at the end of the tick, or later when a server appears. The outputs belong to the latest goal;
    events of older goals are ignored. If several feedback messages arrive in a tick, the newest one is output.
    """

    parts: ClassVar = {"goal": In, "feedback": Out, "result": Out}

    cancel = ExecIn(control=True, doc="requests that the server cancel the latest goal")
    on_accepted = ExecOut(doc="fires when the server has accepted the latest goal")
    on_rejected = ExecOut(doc="fires when the server has rejected the latest goal")
    on_feedback = ExecOut(doc="fires in each tick in which feedback on the latest goal arrives")
    on_result = ExecOut(doc="fires when the latest goal has ended; `status` is its final status")
    status: Token = Out(
        default="",
        doc="state of the latest goal: sent, rejected, accepted, executing, canceling, succeeded, canceled, aborted, unknown",
    )

    client: ActionClient = Bound()
    latest: bytes = State(default=b"")
    cancelling: bool = State(default=False)

    def setup(self, context: Context) -> None:
        """Create the client of the action `actionName`."""
        self.client = context.action_client(self.bind(), self.action_name, **self.endpoint())

    def compute(self) -> None:
        """Request to cancel the latest goal if `cancel` is executed, and send a new goal if `execIn` is executed.

        Raises:
            BadValueError: the value of an input does not fit its field of the goal.
        """
        if self.cancel and self.active and not self.cancelling:
            self.cancelling = True
            if self.status != "sent":
                self.client.cancel(self.latest)
        if self.exec_in:
            self.goal.send(self, self._send)

    def _send(self, message: Any) -> None:
        self.latest, self.cancelling = self.client.send(message), False
        self.status = "sent"
        self.active = True

    def update(self) -> Fire:
        """Set the outputs from the server's events for the latest goal, and fire the execution outputs of these events."""
        fired = 0
        for event in self.client.events():
            if event.goal != self.latest:
                continue
            self.status = "rejected" if event.kind == "rejected" else STATUS_NAMES[event.status]
            match event.kind:
                case "accepted":
                    fired |= self.on_accepted
                    if self.cancelling:
                        self.client.cancel(self.latest)
                case "rejected":
                    fired |= self.on_rejected
                    self.active = False
                case "feedback":
                    self.feedback.write(self, event.message)
                    fired |= self.on_feedback
                case "result":
                    self.result.write(self, event.message)
                    fired |= self.on_result
                    self.active = False
        return fired or None
