"""The action client of a node, built from service clients and subscriptions."""

from __future__ import annotations

import hashlib
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from graphengine.messages.actions import ActionEndpoint
from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import ServiceClient, Subscription
from graphengine.messages.goals import ACCEPTED, CANCEL_GOAL, STATUS_NAMES, UNKNOWN, goal_request

MAX_OPEN = 1000
"""Maximum number of goals without a result that a client keeps; if there are more, the client drops the oldest goals."""


@dataclass(frozen=True, slots=True)
class ClientEndpoints:
    """The service clients and subscriptions of an action client."""

    send_goal: ServiceClient
    cancel_goal: ServiceClient
    get_result: ServiceClient
    feedback: Subscription
    status: Subscription


class ActionEvent(NamedTuple):
    """A message of the action server about a goal: acceptance, rejection, feedback, status or result."""

    kind: Literal["accepted", "rejected", "feedback", "status", "result"]
    goal: bytes
    """UUID of the goal, as `ActionClient.send` returned it."""
    status: int
    """Status of the goal, as in action_msgs/msg/GoalStatus; 0 if the goal was rejected."""
    message: Any = None
    """Feedback or result message; None for the other kinds of events."""


class ActionClient(ActionEndpoint[ClientEndpoints]):
    """An action client of a node.

        goal = self.client.send(message)
        ...
        for event in self.client.events():
            ...

    Args:
        action: full name, such as `/arm_controller/follow_joint_trajectory`.
        action_type: ROS 2 name, such as `control_msgs/action/FollowJointTrajectory`.
        endpoints: service clients and subscriptions of the action.
        definitions: definitions of all known message types.
        node: prim path of the node.
        identity: bytes that identify this session on the network; empty if all peers are in this session.
    """

    kept = ("_asked", "_count", "_open", "_sent")

    def __init__(
        self,
        action: str,
        action_type: str,
        endpoints: ClientEndpoints,
        definitions: Definitions,
        node: str,
        identity: bytes,
    ) -> None:
        super().__init__(action, action_type, endpoints)
        self._definitions = definitions
        self._origin = hashlib.blake2b(b"\0".join((identity, node.encode(), action.encode())))
        self._repeats = not identity
        self._count = 0
        """Number of goals sent since the start of the session, from which the UUIDs of the goals are derived."""
        self._sent: dict[int, bytes] = {}
        """A dict from the number of a send_goal call to the UUID of its goal, until the server accepts or rejects the goal."""
        self._asked: dict[int, bytes] = {}
        """A dict from the number of a get_result call to the UUID of its goal, until the result arrives."""
        self._open: dict[bytes, int] = {}
        """Status of each accepted goal without a result."""

    def restore(self, saved: Any) -> None:
        """Return to a saved state.

        If there are peers outside the session, the count of goals is not restored: otherwise, a UUID would be used twice.
        """
        count = self._count
        super().restore(saved)
        self._count = self._count if self._repeats else count

    def send(self, goal: Any) -> bytes:
        """Send a goal at the end of the tick, or later when a server appears; return the UUID of the goal.

        Raises:
            MessageError: the message is not a goal of the action.
        """
        made = self._origin.copy()
        made.update(self._count.to_bytes(8, "big"))
        identity = uuid.UUID(bytes=made.digest()[:16], version=4).bytes
        request = goal_request(self._definitions, f"{self.action_type}_SendGoal", identity)
        request.goal = goal
        self._sent[self.endpoints.send_goal.call(request)] = identity
        self._count += 1
        _limit(self._sent)
        return identity

    def cancel(self, goal: bytes) -> None:
        """Ask the server to cancel the goal with this UUID; this has no effect if the server has not accepted the goal yet."""
        request = self._definitions.initial(f"{CANCEL_GOAL}_Request")
        request.goal_info.goal_id.uuid[:] = list(goal)
        self.endpoints.cancel_goal.call(request)

    def events(self) -> Sequence[ActionEvent]:
        """Return the server's messages since the last call.

        The order is: acceptances and rejections, feedback, changes of status, results.
        """
        found: list[ActionEvent] = []
        ends = self.endpoints
        ends.cancel_goal.take()  # the responses are not needed: the status shows whether the goal is canceled
        for number, response in ends.send_goal.take():
            goal = self._sent.pop(number, None)
            if goal is None:
                continue
            if response.accepted:
                self._open[goal] = ACCEPTED
                request = goal_request(self._definitions, f"{self.action_type}_GetResult", goal)
                self._asked[ends.get_result.call(request)] = goal
                _limit(self._open)
                _limit(self._asked)
            found.append(ActionEvent("accepted" if response.accepted else "rejected", goal, int(response.accepted)))
        for message in ends.feedback.take():
            goal = bytes(message.goal_id.uuid)
            if goal in self._open:
                found.append(ActionEvent("feedback", goal, self._open[goal], message.feedback))
        for array in ends.status.take():
            for told in array.status_list:
                goal = bytes(told.goal_info.goal_id.uuid)
                if self._open.get(goal, told.status) != told.status and told.status in range(len(STATUS_NAMES)):
                    self._open[goal] = told.status
                    found.append(ActionEvent("status", goal, told.status))
        for number, response in ends.get_result.take():
            goal = self._asked.pop(number, None)
            if goal is not None:
                self._open.pop(goal, None)
                status = response.status if response.status in range(len(STATUS_NAMES)) else UNKNOWN
                found.append(ActionEvent("result", goal, status, response.result))
        return found

    def restart(self) -> None:
        """Discard all goals, because the graph restarts at time 0; the server continues to execute them."""
        for known in (self._sent, self._asked, self._open):
            known.clear()


def _limit(known: dict[Any, Any]) -> None:
    """Remove the oldest entries until at most MAX_OPEN are left."""
    while len(known) > MAX_OPEN:
        del known[next(iter(known))]
