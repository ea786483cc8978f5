"""A client and a server of actions on a transport, for tests of the other side."""

from __future__ import annotations

import uuid
from typing import Any

from graphengine.messages import goals, messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.plain import from_plain
from graphengine.messages.qos import LATCHED
from graphengine.ros.transport import Transport

STEPS = "simulation_interfaces/action/SimulateSteps"


class ActionPeer:
    """A client that sees every message of an action as it arrives.

    Args:
        transport: transport of the action.
        action: full name.
        action_type: ROS 2 name.
    """

    def __init__(self, transport: Transport, action: str, action_type: str = STEPS) -> None:
        self.action_type = action_type
        self.accepted: list[bool] = []
        self.cancelled: list[Any] = []
        self.results: list[Any] = []
        self.feedback: list[Any] = []
        self.status: list[list[int]] = []
        parts = goals.parts(action, action_type)

        def service(part: str, take: Any) -> Any:
            name, kind = parts[part]
            decode = lambda _, data: take(messages.decode(data, f"{kind}_Response"))  # noqa: E731
            return transport.client(name, kind, QoS(), decode)

        self._send = service("send_goal", lambda response: self.accepted.append(response.accepted))
        self._cancel = service("cancel_goal", self.cancelled.append)
        self._result = service("get_result", self.results.append)
        name, kind = parts["feedback"]
        transport.reader(name, kind, QoS(), lambda data: self.feedback.append(messages.decode(data, kind)))
        transport.reader(parts["status"].name, goals.STATUS_ARRAY, LATCHED, self._hear)

    def _hear(self, data: bytes) -> None:
        heard = messages.decode(data, goals.STATUS_ARRAY).status_list
        self.status.append([status.status for status in heard])

    def send(self, goal: uuid.UUID, **fields: Any) -> None:
        """Send a goal."""
        request = DEFINITIONS.initial(f"{self.action_type}_SendGoal_Request")
        request.goal_id.uuid[:] = list(goal.bytes)
        for name, value in fields.items():
            setattr(request.goal, name, value)
        self._send.call(messages.encode(request))

    def cancel(self, goal: uuid.UUID | None = None, stamp: Any = None) -> None:
        """Ask to cancel a goal, those up to a time, or all."""
        request = DEFINITIONS.initial(f"{goals.CANCEL_GOAL}_Request")
        if goal is not None:
            request.goal_info.goal_id.uuid[:] = list(goal.bytes)
        if stamp is not None:
            request.goal_info.stamp = stamp
        self._cancel.call(messages.encode(request))

    def ask_result(self, goal: uuid.UUID) -> None:
        """Ask for the result of a goal."""
        request = DEFINITIONS.initial(f"{self.action_type}_GetResult_Request")
        request.goal_id.uuid[:] = list(goal.bytes)
        self._result.call(messages.encode(request))


class ActionServerPeer:
    """A server that answers when it is told to.

    Args:
        transport: transport of the action.
        action: full name.
        action_type: ROS 2 name.
    """

    def __init__(self, transport: Transport, action: str, action_type: str = STEPS) -> None:
        self.action_type = action_type
        self.goals: list[bytes] = []
        """UUIDs of the goals that came."""
        self.messages: list[Any] = []
        self.asked: list[bytes] = []
        """UUIDs of the goals whose result was asked for."""
        self.cancelled: list[bytes] = []
        self._requests: dict[str, list[bytes]] = {"send_goal": [], "get_result": [], "cancel_goal": []}
        parts = goals.parts(action, action_type)
        self._kinds = {part: kind for part, (_, kind) in parts.items()}

        def service(part: str) -> Any:
            name, kind = parts[part]
            return transport.server(name, kind, QoS(), lambda request_id, data: self._take(part, request_id, data))

        self._servers = {part: service(part) for part in self._requests}
        self._feedback = transport.writer(*parts["feedback"], goals.FEEDBACK_QOS)
        self.status = transport.writer(*parts["status"], LATCHED)

    def _take(self, part: str, request_id: bytes, data: bytes) -> None:
        request = messages.decode(data, f"{self._kinds[part]}_Request")
        self._requests[part].append(request_id)
        if part == "cancel_goal":
            self.cancelled.append(bytes(request.goal_info.goal_id.uuid))
        else:
            (self.goals if part == "send_goal" else self.asked).append(bytes(request.goal_id.uuid))
        if part == "send_goal":
            self.messages.append(request.goal)

    def answer_goal(self, *, accepted: bool = True) -> None:
        """Answer the oldest goal."""
        self._answer("send_goal", accepted=accepted)

    def answer_result(self, status: int, **fields: Any) -> None:
        """Answer the oldest request for a result."""
        result = self._made("Result", fields)
        self._answer("get_result", status=status, result=result)

    def answer_cancel(self) -> None:
        """Answer the oldest request to cancel a goal: it is cancelled."""
        info = DEFINITIONS.initial("action_msgs/msg/GoalInfo")
        info.goal_id.uuid[:] = list(self.cancelled[-1])
        self._answer("cancel_goal", goals_canceling=[info])

    def say(self, goal: bytes, **fields: Any) -> None:
        """Send feedback."""
        message = DEFINITIONS.initial(self._kinds["feedback"])
        message.goal_id.uuid[:] = list(goal)
        message.feedback = self._made("Feedback", fields)
        self._feedback.write(messages.encode(message))

    def _made(self, part: str, fields: dict[str, Any]) -> Any:
        return from_plain(fields, f"{self.action_type}_{part}", DEFINITIONS, part)

    def _answer(self, part: str, **fields: Any) -> None:
        response = DEFINITIONS.initial(f"{self._kinds[part]}_Response")
        for name, value in fields.items():
            setattr(response, name, value)
        self._servers[part].answer(self._requests[part].pop(0), messages.encode(response))
