"""An action client outside of a session: sends goals over a transport and receives feedback and results."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.goals import CANCEL_GOAL, FEEDBACK_READER_QOS, goal_request, parts
from graphengine.ros.service_caller import ServiceCaller
from graphengine.ros.transport import Transport

MAX_CALLS = 1000
"""Maximum number of goals without a result; beyond this number, the oldest goal gets no further feedback."""


@dataclass(eq=False)
class GoalCall:
    """A sent goal. A thread of the transport completes the futures `accepted` and `result`.

    Attributes:
        goal: UUID of the goal, 16 bytes.
        accepted: whether the server accepted the goal.
        result: response of the action's GetResult service, with `status` and `result`; only for an accepted goal.
    """

    goal: bytes
    feedback: Callable[[Any], object]
    accepted: Future[bool] = field(default_factory=Future)
    result: Future[Any] = field(default_factory=Future)


class ActionCaller:
    """A client of an action.

        caller = ActionCaller(transport, "/fibonacci", "example_interfaces/action/Fibonacci")
        call = caller.send(goal)
        if call.accepted.result(timeout=5.0):
            print(call.result.result(timeout=60.0).result)

    Args:
        transport: open transport; closing it also closes this client.
        action: full name of the action.
        action_type: ROS 2 name of the type.
        definitions: message types.

    Raises:
        MessageTypeError: the type is unknown.
    """

    def __init__(
        self, transport: Transport, action: str, action_type: str, definitions: Definitions = DEFINITIONS
    ) -> None:
        definitions.action_parts(action_type)
        self.action_type = action_type
        self._definitions = definitions
        self._calls: dict[bytes, GoalCall] = {}
        """The call of each goal that has no result yet, by the goal's UUID."""
        named = parts(action, action_type)
        self._feedback_type = named["feedback"].message_type
        self._reader = transport.reader(*named["feedback"], FEEDBACK_READER_QOS, self._hear)
        self._send, self._cancel, self._get = (
            ServiceCaller(transport, *named[role], definitions) for role in ("send_goal", "cancel_goal", "get_result")
        )

    @property
    def ready(self) -> bool:
        """Whether all services of the action have a server."""
        return all(service.ready for service in (self._send, self._cancel, self._get))

    def send(self, goal: Any, feedback: Callable[[Any], object] = lambda message: None) -> GoalCall:
        """Send a goal and return without waiting; if there is no server, the goal is lost.

        Args:
            goal: goal message of the action.
            feedback: called with each feedback message, in a thread of the transport.

        Raises:
            MessageError: the message is not a goal of the action.
            TransportError: the client is closed.
        """
        call = GoalCall(uuid.uuid4().bytes, feedback)
        request = goal_request(self._definitions, f"{self.action_type}_SendGoal", call.goal)
        request.goal = goal
        self._calls[call.goal] = call
        while len(self._calls) > MAX_CALLS:
            del self._calls[next(iter(self._calls))]
        self._send.call(request).add_done_callback(lambda answer: self._answered(call, answer))
        return call

    def cancel(self, goal: bytes | None = None) -> Future[Any]:
        """Cancel the goal with this UUID, or all goals of the action (None); return a future of the CancelGoal response."""
        request = self._definitions.initial(f"{CANCEL_GOAL}_Request")
        if goal is not None:
            request.goal_info.goal_id.uuid[:] = list(goal)
        return self._cancel.call(request)

    def close(self) -> None:
        """Close the client; safe to call twice."""
        self._reader.close()
        for service in (self._send, self._cancel, self._get):
            service.close()

    def _answered(self, call: GoalCall, answer: Future[Any]) -> None:
        error = answer.exception()
        if error is not None:
            call.accepted.set_exception(error)
        elif answer.result().accepted:
            request = goal_request(self._definitions, f"{self.action_type}_GetResult", call.goal)
            try:
                self._get.call(request).add_done_callback(lambda result: self._ended(call, result))
            except TransportError as closed:
                call.result.set_exception(closed)
            call.accepted.set_result(True)
            return
        else:
            call.accepted.set_result(False)
        self._calls.pop(call.goal, None)

    def _ended(self, call: GoalCall, result: Future[Any]) -> None:
        self._calls.pop(call.goal, None)
        error = result.exception()
        if error is not None:
            call.result.set_exception(error)
        else:
            call.result.set_result(result.result())

    def _hear(self, data: bytes) -> None:
        try:
            message = messages.decode(data, self._feedback_type, self._definitions)
        except TransportError:
            return
        call = self._calls.get(bytes(message.goal_id.uuid))
        if call is not None:
            call.feedback(message.feedback)
