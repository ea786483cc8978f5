"""A client and a server of actions on a transport, for tests of the other side."""

from __future__ import annotations

import uuid
from typing import Any

from graphengine.messages import goals, messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
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
