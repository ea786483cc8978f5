"""Tracks the goals of an action server: their states, and the responses to clients, by the rules of rcl_action.

An action consists of three services and two topics (design.ros2.org/articles/actions.html). This module sends no messages: an
action server passes requests to it, and sends the messages that its functions return.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

from graphengine.format.stateful import Stateful
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import QoS
from graphengine.messages.names import ACTION_PART
from graphengine.messages.qos import LATCHED

# Of action_msgs/msg/GoalStatus.
UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(7)
STATUS_NAMES = ("unknown", "accepted", "executing", "canceling", "succeeded", "canceled", "aborted")
# Of action_msgs/srv/CancelGoal.
_NONE, _REJECTED, _UNKNOWN_GOAL, _TERMINATED = range(4)

CANCEL_GOAL = "action_msgs/srv/CancelGoal"
STATUS_ARRAY = "action_msgs/msg/GoalStatusArray"
STATUS_QOS = LATCHED
FEEDBACK_QOS = QoS()
FEEDBACK_READER_QOS = QoS(depth=100)
"""QoS of a client's feedback subscription. Its depth is large: a server may send many messages per tick."""

MAX_ACTIVE = 100
"""Maximum number of goals of an action server that have not ended."""
MAX_ENDED = 100
"""Maximum number of ended goals whose results are kept."""
RESULT_TIMEOUT = 900.0
"""Time for which the result of a goal is kept after its end, s; rclpy's default."""
MAX_WAITING = 100
"""Maximum number of result requests for one goal that wait for the end of this goal."""


class TrackedGoal(Stateful):
    """A goal and its state in an action server; the status is UNKNOWN until the goal is accepted.

    Args:
        identity: UUID that the client gave the goal, 16 bytes.
    """

    kept: ClassVar[tuple[str, ...]] = ("ended_at", "result", "stamp", "status", "waiting")

    def __init__(self, identity: bytes) -> None:
        self.identity = identity
        self.status = UNKNOWN
        self.stamp: Any = None
        """Time of acceptance, a builtin_interfaces/Time."""
        self.result: Any = None
        """Response of the get_result service; None until the goal has ended."""
        self.ended_at: float | None = None
        """Time from which `RESULT_TIMEOUT` counts, s; None until the first call of `Goals.expire` after the end of the goal."""
        self.waiting: deque[Any] = deque(maxlen=MAX_WAITING)
        """IDs of the result requests that arrived before the goal ended; the action server chooses their type."""

    @property
    def active(self) -> bool:
        """Whether the goal was accepted and has not ended."""
        return self.status in (ACCEPTED, EXECUTING, CANCELING)

    @property
    def ended(self) -> bool:
        """Whether the goal has ended: it succeeded, was canceled or was aborted."""
        return self.status >= SUCCEEDED


G = TypeVar("G", bound=TrackedGoal)


class Goals(Stateful, Generic[G]):
    """The goals of an action server. Not thread-safe.

    Args:
        action_type: ROS 2 name, such as `control_msgs/action/FollowJointTrajectory`.
        definitions: definitions of all known message types.
    """

    kept = ("_goals",)

    def __init__(self, action_type: str, definitions: Definitions = DEFINITIONS) -> None:
        self.action_type = action_type
        self._definitions = definitions
        self._goals: dict[bytes, G] = {}

    def __iter__(self) -> Iterator[G]:
        """Iterate over a copy of the goals in order of arrival; goals that wait for acceptance are included."""
        return iter(tuple(self._goals.values()))

    def save(self) -> Any:
        """Return a copy of the state of all goals, for `restore`."""
        return super().save(), [goal.save() for goal in self]

    def restore(self, saved: Any) -> None:
        """Return to a saved state. The `TrackedGoal` objects themselves are restored, not copies of them."""
        table, states = saved
        super().restore(table)
        for goal, state in zip(self, states, strict=True):
            goal.restore(state)

    def find(self, identity: bytes) -> G | None:
        """Return the accepted goal with this UUID, or None."""
        goal = self._goals.get(identity)
        return goal if goal is not None and goal.status != UNKNOWN else None

    def admit(self, goal: G) -> bool:
        """Add a goal that a client requested, and return True.

        If its UUID is known, or `MAX_ACTIVE` goals have not ended, the goal is not added and False is returned.
        """
        if goal.identity in self._goals or sum(not other.ended for other in self) >= MAX_ACTIVE:
            return False
        self._goals[goal.identity] = goal
        return True

    def accept(self, goal: G, stamp: Any, status: int = EXECUTING) -> Any:
        """Accept a goal that waits for acceptance; return the response of the send_goal service."""
        goal.stamp, goal.status = stamp, status
        return self._sent(accepted=True, stamp=stamp)

    def reject(self, goal: G) -> Any:
        """Remove a goal that waits for acceptance or was not admitted; return the response of the send_goal service."""
        if self._goals.get(goal.identity) is goal:
            del self._goals[goal.identity]
        return self._sent(accepted=False)

    def _sent(self, *, accepted: bool, stamp: Any = None) -> Any:
        response = self._definitions.initial(f"{self.action_type}_SendGoal_Response")
        response.accepted = accepted
        response.stamp = response.stamp if stamp is None else stamp
        return response

    def end(self, goal: G, status: int, result: Any = None) -> Any:
        """End an active goal; return the response of the get_result service.

        Args:
            goal: active goal.
            status: SUCCEEDED, CANCELED or ABORTED.
            result: result message of the action; None: a result with default values.

        Raises:
            ValueError: the goal is not active, or `status` is CANCELED and no client has requested to cancel the goal.
            MessageError: the message is not a result of the action.
        """
        if not goal.active or (status == CANCELED and goal.status != CANCELING):
            raise ValueError(f"a goal that is {STATUS_NAMES[goal.status]} cannot become {STATUS_NAMES[status]}")
        response = self._definitions.initial(f"{self.action_type}_GetResult_Response")
        response.status = status
        if result is not None:
            response.result = result
        messages.check(response, self._definitions)
        goal.status, goal.result = status, response
        return response

    def unknown_result(self) -> Any:
        """Return the response of the get_result service for a goal that the server does not know."""
        return self._definitions.initial(f"{self.action_type}_GetResult_Response")

    def cancel(self, request: Any) -> Any:
        """Apply a CancelGoal request: the running goals that it selects become CANCELING. Return the response."""
        response = self._definitions.initial(f"{CANCEL_GOAL}_Response")
        identity, stamp = bytes(request.goal_info.goal_id.uuid), _order(request.goal_info.stamp)
        one, every = any(identity) and not any(stamp), not any(identity) and not any(stamp)
        known = self.find(identity)
        for goal in self:
            meant = goal is known or every or (not one and goal.active and _order(goal.stamp) <= stamp)
            if meant and goal.status in (ACCEPTED, EXECUTING):
                goal.status = CANCELING
                response.goals_canceling.append(self._info(goal))
        if one and not response.goals_canceling:
            response.return_code = _TERMINATED if known else _UNKNOWN_GOAL
        return response

    def expire(self, now: float) -> bool:
        """Discard goals that ended more than `RESULT_TIMEOUT` ago, and the oldest ended goals if more than `MAX_ENDED` are kept.

        Return whether a goal was discarded.
        """
        ended = [goal for goal in self if goal.ended]
        for goal in ended:
            goal.ended_at = now if goal.ended_at is None else goal.ended_at
        old = ended[: max(len(ended) - MAX_ENDED, 0)]
        old += [goal for goal in ended if goal not in old and now - (goal.ended_at or 0.0) > RESULT_TIMEOUT]
        for goal in old:
            del self._goals[goal.identity]
        return bool(old)

    def restart(self) -> None:
        """Keep all results for another `RESULT_TIMEOUT`; called when the clock restarts at 0."""
        for goal in self:
            goal.ended_at = None

    def feedback(self, goal: G, feedback: Any) -> Any:
        """Return the message for the feedback topic: the feedback with the UUID of the goal."""
        message = self._definitions.initial(f"{self.action_type}_FeedbackMessage")
        message.goal_id.uuid[:] = list(goal.identity)
        message.feedback = feedback
        return message

    def status_array(self) -> Any:
        """Return a GoalStatusArray with the status of each goal that was accepted and has not been discarded."""
        message = self._definitions.initial(STATUS_ARRAY)
        for goal in self:
            if goal.status != UNKNOWN:
                status = self._definitions.initial("action_msgs/msg/GoalStatus")
                status.goal_info, status.status = self._info(goal), goal.status
                message.status_list.append(status)
        return message

    def _info(self, goal: G) -> Any:
        info = self._definitions.initial("action_msgs/msg/GoalInfo")
        info.goal_id.uuid[:] = list(goal.identity)
        info.stamp = goal.stamp
        return info


class ActionPart(NamedTuple):
    """Name and type of one of the services or topics of an action."""

    name: str
    message_type: str


def parts(action: str, action_type: str) -> Mapping[str, ActionPart]:
    """Return a dict from send_goal, cancel_goal, get_result, feedback and status to these services and topics of an action."""
    types = {
        "send_goal": f"{action_type}_SendGoal",
        "cancel_goal": CANCEL_GOAL,
        "get_result": f"{action_type}_GetResult",
        "feedback": f"{action_type}_FeedbackMessage",
        "status": STATUS_ARRAY,
    }
    return {part: ActionPart(f"{action}{ACTION_PART}{part}", message_type) for part, message_type in types.items()}


def goal_request(definitions: Definitions, service: str, goal: bytes) -> Any:
    """Return a request of an action's service, such as `…_GetResult`, for the goal with the UUID `goal`."""
    request = definitions.initial(f"{service}_Request")
    request.goal_id.uuid[:] = list(goal)
    return request


def _order(stamp: Any) -> tuple[int, int]:
    """Return a builtin_interfaces/Time as a tuple that can be compared."""
    return stamp.sec, stamp.nanosec
