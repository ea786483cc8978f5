"""Action servers of nodes, built from service servers and publishers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from graphengine.format.stateful import Stateful
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import Publisher, ServiceServer
from graphengine.messages.goals import ABORTED, CANCELED, CANCELING, SUCCEEDED, Goals, TrackedGoal


@dataclass(frozen=True, slots=True)
class ServerEndpoints:
    """The services and topics of an action server."""

    send_goal: ServiceServer
    cancel_goal: ServiceServer
    get_result: ServiceServer
    feedback: Publisher
    status: Publisher


E = TypeVar("E")


class ActionEndpoint(Stateful, Generic[E]):
    """An action server or client of a node; it stays open until every node that holds it has closed it.

    Args:
        action: full name.
        action_type: ROS 2 name.
        endpoints: services and topics of the action.
    """

    def __init__(self, action: str, action_type: str, endpoints: E) -> None:
        self.action = action
        self.action_type = action_type
        self.endpoints = endpoints
        self.holders = 1
        """Number of nodes that hold the endpoint: two while a changed graph replaces the running one."""

    def has(self, endpoints: E) -> bool:
        """Return whether this action uses exactly these service and topic objects."""
        names = type(endpoints).__slots__  # type: ignore[attr-defined]
        return all(getattr(self.endpoints, name, None) is getattr(endpoints, name) for name in names)

    def restart(self) -> None:
        """End all goals, because the graph restarts at time 0."""
        raise NotImplementedError

    def close(self) -> bool:
        """Remove one holder. If it was the last one, end all goals and return True."""
        self.holders -= 1
        if self.holders == 0:
            self.restart()
        return self.holders <= 0


class Goal(TrackedGoal):
    """A goal that a client sent; the node accepts or rejects it, and ends an accepted one.

    Attributes:
        identity: UUID of the goal, 16 bytes.
        message: the goal's message, such as a `control_msgs/action/FollowJointTrajectory_Goal`.
    """

    kept = (*TrackedGoal.kept, "pending")

    def __init__(self, server: ActionServer, identity: bytes, message: Any, request_id: bytes) -> None:
        super().__init__(identity)
        self.message = message
        self.request_id = request_id
        self.pending = True
        """Whether the goal was neither accepted nor rejected."""
        self._server = server

    @property
    def cancel_requested(self) -> bool:
        """Whether a client has requested to cancel the goal and the goal has not ended yet."""
        return self.status == CANCELING

    def accept(self) -> None:
        """Accept the goal: its status becomes executing. No effect if it was accepted or rejected before."""
        self._server.accept(self)

    def reject(self) -> None:
        """Reject the goal. No effect if it was accepted or rejected before."""
        self._server.reject(self)

    def feedback(self, message: Any) -> None:
        """Publish feedback if it has subscribers.

        Raises:
            MessageError: the message does not fit the action.
        """
        self._server.publish_feedback(self, message)

    def succeed(self, result: Any = None) -> None:
        """End the goal as succeeded; without `result`, the result has default values.

        Raises:
            ValueError: the goal is not active.
            MessageError: the result does not fit the action.
        """
        self._server.end(self, SUCCEEDED, result)

    def abort(self, result: Any = None) -> None:
        """End the goal as aborted. Takes the same argument and raises the same errors as `succeed`."""
        self._server.end(self, ABORTED, result)

    def canceled(self, result: Any = None) -> None:
        """End the goal as canceled; like `succeed`, but raises ValueError also if no client requested to cancel it."""
        self._server.end(self, CANCELED, result)


class ActionServer(ActionEndpoint[ServerEndpoints]):
    """An action server of a node.

        for goal in self.server.goals():
            goal.accept()
        ...
        self.server.update()

    Args:
        action: full name, such as `/arm_controller/follow_joint_trajectory`.
        action_type: ROS 2 name, such as `control_msgs/action/FollowJointTrajectory`.
        endpoints: services and topics of the action.
        now: returns the time of goals and results, s.
        definitions: message types.
    """

    def __init__(
        self,
        action: str,
        action_type: str,
        endpoints: ServerEndpoints,
        now: Callable[[], float],
        definitions: Definitions = DEFINITIONS,
    ) -> None:
        super().__init__(action, action_type, endpoints)
        self.handle = endpoints.send_goal.handle
        """Handle of the server for `Context.action`; never 0."""
        self.current: Goal | None = None
        """The goal that the graph executes; None between goals."""
        self.definitions = definitions
        self._now = now
        self._goals: Goals[Goal] = Goals(action_type, definitions)
        self._changed = False
        """Whether a status changed since it was published."""

    def save(self) -> Any:
        """Return a copy of the goals' state."""
        return self.current, self._goals.save()

    def restore(self, saved: Any) -> None:
        """Return to a saved state; the next `update` publishes it."""
        self.current, goals = saved
        self._goals.restore(goals)
        self._changed = True

    @property
    def active(self) -> Sequence[Goal]:
        """Accepted goals that have not ended, oldest first."""
        return [goal for goal in self._goals if goal.active]

    def goals(self) -> Sequence[Goal]:
        """Return the goals that arrived since the last call, oldest first; accept or reject each, in this tick or later.

        Also handles requests of clients for cancellation and results. Call it once per execution, before all other methods.
        """
        arrived: list[Goal] = []
        for request_id, request in self.endpoints.send_goal.take():
            goal = Goal(self, bytes(request.goal_id.uuid), request.goal, request_id)
            if self._goals.admit(goal):
                arrived.append(goal)
            else:
                self.reject(goal)
        for request_id, request in self.endpoints.cancel_goal.take():
            response = self._goals.cancel(request)
            self._changed |= bool(response.goals_canceling)
            self.endpoints.cancel_goal.answer(request_id, response)
        for request_id, request in self.endpoints.get_result.take():
            asked = self._goals.find(bytes(request.goal_id.uuid))
            if asked is not None and not asked.ended:
                asked.waiting.append(request_id)
            else:
                self.endpoints.get_result.answer(request_id, asked.result if asked else self._goals.unknown_result())
        return arrived

    def update(self) -> None:
        """Publish the goals' status if it changed, and discard old results. Call it at the end of each execution."""
        self._changed |= self._goals.expire(self._now())
        self._publish()

    def _publish(self) -> None:
        if self._changed:
            self._changed = False
            self.endpoints.status.publish(self._goals.status_array())

    def accept(self, goal: Goal) -> None:
        """Accept a goal; no effect if it was accepted or rejected before."""
        if not goal.pending:
            return
        goal.pending = False
        response = self._goals.accept(goal, messages.stamp(self._now()))
        self.endpoints.send_goal.answer(goal.request_id, response)
        self._changed = True

    def reject(self, goal: Goal) -> None:
        """Reject a goal; no effect if it was accepted or rejected before."""
        if goal.pending:
            goal.pending = False
            self.endpoints.send_goal.answer(goal.request_id, self._goals.reject(goal))

    def publish_feedback(self, goal: Goal, message: Any) -> None:
        """Publish feedback on a goal if it has subscribers."""
        if self.endpoints.feedback.wanted:
            self.endpoints.feedback.publish(self._goals.feedback(goal, message))

    def end(self, goal: Goal, status: int, result: Any) -> None:
        """End a goal, and send its result to the clients that wait for it."""
        response = self._goals.end(goal, status, result)
        while goal.waiting:
            self.endpoints.get_result.answer(goal.waiting.popleft(), response)
        self._changed = True

    def restart(self) -> None:
        """Abort all active goals and reject the others, because the graph restarts at time 0."""
        self.goals()
        for goal in self._goals:
            if goal.active:
                goal.abort()
            else:
                goal.reject()
        self.current = None
        self._goals.restart()
        self._publish()
