"""The action SimulateSteps: runs single ticks with feedback after each; goals can be cancelled.

An action consists of three services and two topics (design.ros2.org/articles/actions.html). Only one goal is active at a time.
"""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from graphengine.control.service_host import SERVICES, Offers
from graphengine.control.simulation_interfaces import states
from graphengine.control.simulation_interfaces.results import FAILED, OK, text_of
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.qos import LATCHED
from graphengine.ros.transport import Transport
from graphengine.runtime.command_queue import Desk
from graphengine.runtime.commands import MAX_TICKS

TYPE = "simulation_interfaces/action/SimulateSteps"
KEPT = 100
"""Goals whose results are kept."""

# Of action_msgs/msg/GoalStatus.
UNKNOWN, ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(7)
# Of action_msgs/srv/CancelGoal.
_NONE, _REJECTED, _UNKNOWN_GOAL, _TERMINATED = range(4)


@dataclass(eq=False, slots=True)
class _Goal:
    """An accepted goal."""

    identity: bytes
    steps: int
    done: int = 0
    status: int = ACCEPTED
    error: str = ""
    stamp: Any = field(default_factory=lambda: messages.stamp(time.time()))
    """When it was accepted, by the wall clock."""
    ended: Future[None] = field(default_factory=Future)

    @property
    def active(self) -> bool:
        """Whether the goal has not ended yet."""
        return self.status in (ACCEPTED, EXECUTING, CANCELING)


class SimulateSteps:
    """The action server of one session, usually at `/simulate_steps`.

    Args:
        desk: command queue of the session.
        transport: transport that carries the action.
        offers: services to which those of the action are added.
        name: absolute name.

    Raises:
        MessageTypeError: the transport does not know the action's types.
    """

    def __init__(self, desk: Desk, transport: Transport, offers: Offers, name: str) -> None:
        self._desk = desk
        self._lock = threading.RLock()
        self._goals: dict[bytes, _Goal] = {}
        self._closed = False
        hidden = f"{name}/_action"
        self._feedback = transport.writer(f"{hidden}/feedback", f"{TYPE}_FeedbackMessage", SERVICES)
        self._status = transport.writer(f"{hidden}/status", "action_msgs/msg/GoalStatusArray", LATCHED)
        offers.add(f"{hidden}/send_goal", f"{TYPE}_SendGoal", self._accept, then=self._begin)
        offers.add(f"{hidden}/cancel_goal", "action_msgs/srv/CancelGoal", self._cancel, then=self._tell_status)
        offers.add(f"{hidden}/get_result", f"{TYPE}_GetResult", self._result)

    def close(self) -> None:
        """Close the topics of the action; active goals do not continue."""
        self._closed = True
        self._feedback.close()
        self._status.close()

    def _accept(self, request: Any, response: Any) -> None:
        goal = _Goal(bytes(request.goal_id.uuid), int(request.goal.steps))
        response.stamp = goal.stamp
        with self._lock:
            busy = any(other.active for other in self._goals.values())
            response.accepted = not busy and 0 < goal.steps <= MAX_TICKS and goal.identity not in self._goals
            if response.accepted:
                self._goals[goal.identity] = goal
                for old in list(self._goals)[:-KEPT]:
                    del self._goals[old]

    def _begin(self, request: Any, response: Any) -> None:
        if response.accepted:
            self._tell_status()
            self._next(self._goals[bytes(request.goal_id.uuid)])

    def _next(self, goal: _Goal) -> None:
        """Queue the next tick of a goal."""
        stepping = self._desk.ask(lambda session: states.run_steps(session, 1))
        stepping.add_done_callback(lambda future: self._stepped(goal, future))

    def _stepped(self, goal: _Goal, future: Future[Any]) -> None:
        """Continue or end a goal after a tick ran or failed; called in the session's thread."""
        if self._closed:
            return
        error = future.exception()
        if error is not None:
            goal.error = text_of(error)
            self._end(goal, CANCELED if goal.status == CANCELING else ABORTED)
            return
        goal.done += 1
        self._tell_feedback(goal)
        with self._lock:
            cancelled = goal.status == CANCELING
            if not cancelled:
                goal.status = EXECUTING
        if goal.done == 1 and not cancelled:
            self._tell_status()
        if goal.done == goal.steps:
            self._end(goal, SUCCEEDED)
        elif cancelled:
            goal.error = f"cancelled after {goal.done} of {goal.steps} steps"
            self._end(goal, CANCELED)
        else:
            self._next(goal)

    def _end(self, goal: _Goal, status: int) -> None:
        with self._lock:  # else one who cancels just then could write over it
            goal.status = status
        self._tell_status()
        goal.ended.set_result(None)

    def _result(self, request: Any, response: Any) -> Future[None] | None:
        """Answer with the result of a goal when it has ended; unknown goals have the status 0."""
        goal = self._goals.get(bytes(request.goal_id.uuid))
        if goal is None:
            return None

        def fill(_: Future[None]) -> None:
            response.status = goal.status
            response.result.result.result = OK if goal.status == SUCCEEDED else FAILED
            response.result.result.error_message = goal.error

        goal.ended.add_done_callback(fill)  # before the answer leaves, as callbacks run in the order they were added
        return goal.ended

    def _cancel(self, request: Any, response: Any) -> None:
        """Cancel active goals after their current tick: the given goal, goals accepted up to a time, or all."""
        identity, before = bytes(request.goal_info.goal_id.uuid), messages.seconds(request.goal_info.stamp)
        every = not any(identity) and not before
        with self._lock:
            known = self._goals.get(identity)
            active = [goal for goal in self._goals.values() if goal.active]
            meant = [goal for goal in active if every or goal is known or messages.seconds(goal.stamp) <= before]
            for goal in meant:
                goal.status = CANCELING
            if not meant:
                response.return_code = _TERMINATED if known else _UNKNOWN_GOAL if any(identity) else _REJECTED
        response.goals_canceling = [_info(goal) for goal in meant]

    def _tell_feedback(self, goal: _Goal) -> None:
        if not self._feedback.matched:
            return
        message = DEFINITIONS.initial(f"{TYPE}_FeedbackMessage")
        message.goal_id.uuid[:] = list(goal.identity)
        message.feedback.completed_steps = goal.done
        message.feedback.remaining_steps = goal.steps - goal.done
        self._feedback.write(messages.encode(message))

    def _tell_status(self, *_: object) -> None:
        message = DEFINITIONS.initial("action_msgs/msg/GoalStatusArray")
        with self._lock:
            for goal in self._goals.values():
                status = DEFINITIONS.initial("action_msgs/msg/GoalStatus")
                status.goal_info, status.status = _info(goal), goal.status
                message.status_list.append(status)
        self._status.write(messages.encode(message))


def _info(goal: _Goal) -> Any:
    info = DEFINITIONS.initial("action_msgs/msg/GoalInfo")
    info.goal_id.uuid[:] = list(goal.identity)
    info.stamp = goal.stamp
    return info
