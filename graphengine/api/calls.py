"""Service calls and action goals that a program sends to the graphs of a session and to other programs."""

from __future__ import annotations

from typing import Any

from graphengine.api.runner import Runner
from graphengine.api.topics import encoded, find_end
from graphengine.format.closing import Closing
from graphengine.format.errors import StateError, TransportError
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.messages.goals import STATUS_NAMES, parts
from graphengine.ros.action_caller import ActionCaller, GoalCall


class ServiceCall(Closing):
    """A call of a service; the request is sent as soon as the service has a server. `Session.start_call` returns it.

    Attributes:
        service: full name of the service.
    """

    def __init__(self, runner: Runner, service: str, request: Any, type: str | None) -> None:
        self.service, transport, _, service_type = find_end(runner, service, type, ("serve", "call"))
        self._definitions = runner.scene.definitions
        request_type, self._response_type = self._definitions.service_parts(service_type)
        self._request = encoded(runner, request, request_type) if request is not None else None
        self._answers: list[bytes] = []
        self._sent = False
        self._client = transport.client(
            self.service, service_type, QoS(), lambda number, answer: self._answers.append(answer)
        )
        self._missing = f"there is no server of type {service_type}"
        self._send()

    @property
    def ready(self) -> bool:
        """Whether the service has a server."""
        return self._client.ready

    @property
    def done(self) -> bool:
        """Whether the response has arrived; reading this property sends a pending request."""
        self._send()
        return bool(self._answers)

    @property
    def response(self) -> Any:
        """The response message.

        Raises:
            TransportError: the response has not arrived.
        """
        if not self._answers:
            why = "" if self._sent else f"\n  {self._missing}"
            raise TransportError(f"{self.service}: no response{why}")
        return messages.decode(self._answers[0], self._response_type, self._definitions)

    def _send(self) -> None:
        if not self._sent and self._request is not None and self._client.ready:
            self._sent = True
            self._client.call(self._request)

    def close(self) -> None:
        """Close the client; a response that arrives later is discarded. Safe to call twice."""
        self._client.close()


def call_service(runner: Runner, service: str, request: Any, timeout: float, type: str | None) -> Any:
    """Call a service, run ticks until the response arrives, and return it. The arguments are those of `Session.call`."""
    with ServiceCall(runner, service, request, type) as call:
        runner.run(timeout, None, lambda _: not call.done)
        try:
            return call.response
        except TransportError as error:
            first, *more = str(error).split("\n")
            raise TransportError("\n".join([f"{first} within {timeout:g} s of simulation", *more])) from None


class Goal(Closing):
    """A goal of an action; it is sent as soon as the action has a server. `Session.send_goal` returns it.

    Attributes:
        action: full name of the action.
        feedback: newest feedback message; None before the first one.
    """

    def __init__(self, runner: Runner, action: str, goal: Any, type: str | None) -> None:
        send = parts(action, type or "")["send_goal"][0]
        end = f"{type}_SendGoal" if type is not None else None
        found, transport, _, send_type = find_end(runner, send, end, ("serve", "call"))
        self.action = found.removesuffix("/_action/send_goal")
        action_type, definitions = send_type.removesuffix("_SendGoal"), runner.scene.definitions
        goal_type = f"{action_type}_Goal"
        self._goal = messages.decode(encoded(runner, goal, goal_type), goal_type, definitions)
        self._caller = ActionCaller(transport, self.action, action_type, definitions)
        self._call: GoalCall | None = None
        self.feedback: Any = None
        self._send()

    def _send(self) -> None:
        if self._call is None and self._caller.ready:
            self._call = self._caller.send(self._goal, self._hear)

    def _hear(self, message: Any) -> None:
        self.feedback = message

    @property
    def status(self) -> str:
        """Status of the goal: `sent`, `rejected`, `accepted`, or the status with which it ended, such as `succeeded`.

        Reading this property sends a pending goal.

        Raises:
            TransportError: the server does not answer.
        """
        self._send()
        if self._call is None or not self._call.accepted.done():
            return "sent"
        if not self._call.accepted.result():
            return "rejected"
        if not self._call.result.done():
            return "accepted"
        return STATUS_NAMES[self._call.result.result().status]

    @property
    def done(self) -> bool:
        """Whether the goal has ended or was rejected."""
        return self.status not in ("sent", "accepted")

    @property
    def result(self) -> Any:
        """Result message of the action.

        Raises:
            StateError: the goal has not ended, or was rejected.
        """
        if self.status == "rejected" or not self.done or self._call is None:
            raise StateError(f"{self.action}: the goal is {self.status}, it has no result")
        return self._call.result.result().result

    def cancel(self) -> None:
        """Ask the server to cancel the goal."""
        if self._call is not None:
            self._caller.cancel(self._call.goal)

    def close(self) -> None:
        """Close the client; the goal continues. Safe to call twice."""
        self._caller.close()
