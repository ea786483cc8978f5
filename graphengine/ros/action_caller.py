"""An action client outside of a session: sends goals over a transport and receives feedback and results."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import QoS
from graphengine.messages.goals import CANCEL_GOAL, FEEDBACK_READER_QOS, ActionPart, parts
from graphengine.ros.transport import Transport

MAX_CALLS = 1000
"""Maximum number of goals whose feedback a caller passes on; beyond it, the oldest goals get no more feedback."""


@dataclass(eq=False)
class GoalCall:
    """A sent goal. A thread of the transport completes its futures.

    Attributes:
        goal: UUID of the goal, 16 bytes.
        accepted: whether the server accepted the goal.
        result: response of get_result, with `status` and `result`; requested once the goal is accepted.
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
        transport: open transport, which closes the client's endpoints.
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
        """Calls without a result, by UUID."""
        named = parts(action, action_type)
        self._feedback_type = named["feedback"].message_type
        self._reader = transport.reader(*named["feedback"], FEEDBACK_READER_QOS, self._hear)
        self._send, self._cancel, self._get = (
            _Service(transport, named[role], definitions) for role in ("send_goal", "cancel_goal", "get_result")
        )

    @property
    def ready(self) -> bool:
        """Whether all services of the action have a server."""
        return all(service.ready for service in (self._send, self._cancel, self._get))

    def send(self, goal: Any, feedback: Callable[[Any], object] = lambda message: None) -> GoalCall:
        """Send a goal and return at once; without a server, the goal is lost.

        Args:
            goal: goal message of the action.
            feedback: called with each feedback message, in a thread of the transport.

        Raises:
            MessageError: the message is not a goal of the action.
            TransportError: the client is closed.
        """
        call = GoalCall(uuid.uuid4().bytes, feedback)
        request = self._request(f"{self.action_type}_SendGoal", call.goal)
        request.goal = goal
        self._calls[call.goal] = call
        while len(self._calls) > MAX_CALLS:
            del self._calls[next(iter(self._calls))]
        self._send.call(request).add_done_callback(lambda answer: self._answered(call, answer))
        return call

    def cancel(self, goal: bytes | None = None) -> Future[Any]:
        """Request to cancel a goal by its UUID, or all goals of the action; return a future of cancel_goal's response."""
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
            request = self._request(f"{self.action_type}_GetResult", call.goal)
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

    def _request(self, service: str, goal: bytes) -> Any:
        request = self._definitions.initial(f"{service}_Request")
        request.goal_id.uuid[:] = list(goal)
        return request


class _Service:
    """A client of one service, whose calls return futures."""

    def __init__(self, transport: Transport, part: ActionPart, definitions: Definitions) -> None:
        self._response = f"{part.message_type}_Response"
        self._definitions = definitions
        self._lock = threading.Lock()
        self._open: dict[int, Future[Any]] = {}
        self._early: dict[int, bytes] = {}
        """Responses that arrived before `call` knew the number of their request."""
        self._client = transport.client(part.name, part.message_type, QoS(), self._receive)

    @property
    def ready(self) -> bool:
        """Whether there is a server."""
        return self._client.ready

    def call(self, request: Any) -> Future[Any]:
        """Send a request."""
        future = Future[Any]()
        number = self._client.call(messages.encode(request, self._definitions))
        with self._lock:
            early = self._early.pop(number, None)
            if early is None:
                self._open[number] = future
        if early is not None:
            self._settle(future, early)
        return future

    def _receive(self, number: int, data: bytes) -> None:
        with self._lock:
            future = self._open.pop(number, None)
            if future is None:
                self._early[number] = data
        if future is not None:
            self._settle(future, data)

    def _settle(self, future: Future[Any], data: bytes) -> None:
        try:
            future.set_result(messages.decode(data, self._response, self._definitions))
        except TransportError as error:
            future.set_exception(error)

    def close(self) -> None:
        """Close the client."""
        self._client.close()
