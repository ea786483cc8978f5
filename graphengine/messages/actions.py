"""The action server of a node, built from service servers and publishers, and the base class of action endpoints."""

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
    """The service servers and publishers of an action server."""

    send_goal: ServiceServer
    cancel_goal: ServiceServer
    get_result: ServiceServer
    feedback: Publisher
    status: Publisher


E = TypeVar("E")


class ActionEndpoint(Stateful, Generic[E]):
    """Base class of action servers and action clients. They exist until every node that holds them has called `close`.

    Args:
        action: full name of the action.
        action_type: ROS 2 name of the action type.
        endpoints: service and topic endpoints of the action.
    """

    def __init__(self, action: str, action_type: str, endpoints: E) -> None:
        self.action = action
        self.action_type = action_type
        self.endpoints = endpoints
        self.holders = 1
        """Number of nodes that hold this action server or client: two while a changed graph replaces the running graph."""

    def has(self, endpoints: E) -> bool:
        """Return whether this action server or client consists of exactly these endpoint objects."""
        names = type(endpoints).__slots__  # type: ignore[attr-defined]
        return all(getattr(self.endpoints, name, None) is getattr(endpoints, name) for name in names)

    def restart(self) -> None:
        """End all goals, because the graph restarts at time 0."""
        raise NotImplementedError

    def close(self) -> bool:
        """Remove one holder, and end all goals if it was the last one. Return whether no holder is left."""
        self.holders -= 1
        if self.holders == 0:
            self.restart()
        return self.holders <= 0


class Goal(TrackedGoal):
    """A goal that a client sent to an action server. The node accepts or rejects it, and ends it if it was accepted.

    Attributes:
        identity: UUID of the goal, 16 bytes.
        message: the goal's message, such as a `control_msgs/action/FollowJointTrajectory_Goal`; None after the end of the goal,
            to release the memory.
    """

    kept = (*TrackedGoal.kept, "pending")

    def __init__(self, server: ActionServer, identity: bytes, message: Any, request_id: bytes) -> None:
        super().__init__(identity)
        self.message = message
        self.request_id = request_id
        self.pending = True
        """Whether the goal still waits to be accepted or rejected."""
        self._server = server

    def save(self) -> Any:
        """Return a copy of the state. The copy shares the message, which never changes."""
        return super().save(), self.message

    def restore(self, saved: Any) -> None:
        """Return to a saved state."""
        state, self.message = saved
        super().restore(state)

    @property
    def cancel_requested(self) -> bool:
        """Whether a client has requested to cancel the goal and the goal has not ended yet."""
        return self.status == CANCELING

    def accept(self) -> None:
        """Accept the goal, whose status becomes executing; no effect if it was accepted or rejected before."""
        self._server.accept(self)

    def reject(self) -> None:
        """Reject the goal; no effect if it was accepted or rejected before."""
        self._server.reject(self)

    def feedback(self, message: Any) -> None:
        """Publish feedback on the goal, if the feedback topic has subscribers.

        Raises:
            MessageError: the message is not feedback of the action.
        """
        self._server.publish_feedback(self, message)

    def succeed(self, result: Any = None) -> None:
        """End the goal as succeeded and send the result; without `result`, a result with default values is sent.

        Raises:
            ValueError: the goal is not active.
            MessageError: the message is not a result of the action.
        """
        self._server.end(self, SUCCEEDED, result)

    def abort(self, result: Any = None) -> None:
        """End the goal as aborted. Takes the same argument and raises the same errors as `succeed`."""
        self._server.end(self, ABORTED, result)

    def canceled(self, result: Any = None) -> None:
        """End the goal as canceled. Takes the same argument and raises the same errors as `succeed`.

        ValueError is also raised if no client has requested to cancel the goal.
        """
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
        endpoints: service servers and publishers of the action.
        now: function that returns the current time, s.
        definitions: definitions of all known message types.
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
        """The goal that the graph executes, or executed last; None before the first goal and after a restart."""
        self.definitions = definitions
        self._now = now
        self._goals: Goals[Goal] = Goals(action_type, definitions)
        self._changed = False
        """Whether the status of a goal has changed since the statuses were published."""

    def save(self) -> Any:
        """Return a copy of the state of all goals, for `restore`."""
        return self.current, self._goals.save()

    def restore(self, saved: Any) -> None:
        """Return to a saved state; the next `update` publishes the statuses of its goals."""
        self.current, goals = saved
        self._goals.restore(goals)
        self._changed = True

    @property
    def active(self) -> Sequence[Goal]:
        """Accepted goals that have not ended, oldest first."""
        return [goal for goal in self._goals if goal.active]

    def goals(self) -> Sequence[Goal]:
        """Return the goals that arrived since the last call, oldest first. The node accepts or rejects each goal, now or later.

        The method also handles the clients' cancel requests and result requests. Call it once per execution, before all other
        methods.
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
        """Discard old results, and publish all statuses if a status has changed. Call this at the end of each execution."""
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
        """Publish feedback on a goal, if the feedback topic has subscribers."""
        if self.endpoints.feedback.wanted:
            self.endpoints.feedback.publish(self._goals.feedback(goal, message))

    def end(self, goal: Goal, status: int, result: Any) -> None:
        """End a goal, and send its result to the clients that wait for it."""
        response = self._goals.end(goal, status, result)
        goal.message = None
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
