"""The server of the action SimulateSteps, which runs a number of ticks and sends feedback after each tick.

Goals can be cancelled. Only one goal is active at a time; while it is active, other goals are rejected.
"""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future
from typing import Any

from graphengine.control.service_host import ServiceHost
from graphengine.control.simulation_interfaces import states
from graphengine.control.simulation_interfaces.results import FAILED, OK, text_of
from graphengine.messages import goals, messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.goals import ABORTED, ACCEPTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, Goals, TrackedGoal
from graphengine.ros.transport import Transport
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.commands import MAX_TICKS

TYPE = "simulation_interfaces/action/SimulateSteps"


class _Goal(TrackedGoal):
    """A goal with the number of ticks to run, `steps`, and the number of ticks that have run, `done`."""

    def __init__(self, identity: bytes, steps: int) -> None:
        super().__init__(identity)
        self.steps = steps
        self.done = 0


class SimulateSteps:
    """The action server of one session, usually at `/simulate_steps`.

    Args:
        queue: command queue of the session.
        transport: transport on which the action is created.
        offers: service host to which the services of the action are added.
        name: full name of the action.

    Raises:
        MessageTypeError: the transport does not know the action's types.
    """

    def __init__(self, queue: CommandQueue, transport: Transport, offers: ServiceHost, name: str) -> None:
        self._queue = queue
        self._lock = threading.RLock()
        """Lock for the goals, which several threads access."""
        self._goals: Goals[_Goal] = Goals(TYPE)
        self._closed = False
        parts = goals.parts(name, TYPE)
        self._feedback = transport.writer(*parts["feedback"], goals.FEEDBACK_QOS)
        self._status = transport.writer(*parts["status"], goals.STATUS_QOS)
        offers.add(*parts["send_goal"], self._accept, then=self._begin)
        offers.add(*parts["cancel_goal"], self._cancel, then=self._tell_status)
        offers.add(*parts["get_result"], self._result)

    def close(self) -> None:
        """Destroy the publishers of the action; active goals do not continue. The service host destroys the services."""
        self._closed = True
        self._feedback.close()
        self._status.close()

    def _accept(self, request: Any, response: Any) -> None:
        goal = _Goal(bytes(request.goal_id.uuid), int(request.goal.steps))
        with self._lock:
            self._goals.expire(time.monotonic())
            busy = any(other.active for other in self._goals)
            if not busy and 0 < goal.steps <= MAX_TICKS and self._goals.admit(goal):
                sent = self._goals.accept(goal, messages.stamp(time.time()), ACCEPTED)
                response.accepted, response.stamp = sent.accepted, sent.stamp

    def _begin(self, request: Any, response: Any) -> None:
        with self._lock:
            goal = self._goals.find(bytes(request.goal_id.uuid))
        if response.accepted and goal is not None:
            self._tell_status()
            self._next(goal)

    def _next(self, goal: _Goal) -> None:
        """Queue the next tick of a goal."""
        stepping = self._queue.ask(lambda session: states.run_steps(session, 1))
        stepping.add_done_callback(lambda future: self._stepped(goal, future))

    def _stepped(self, goal: _Goal, future: Future[Any]) -> None:
        """Continue or end a goal after a tick has run or failed; called in the session's thread."""
        if self._closed:
            return
        error = future.exception()
        if error is not None:
            self._end(goal, CANCELED if goal.status == CANCELING else ABORTED, text_of(error))
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
            self._end(goal, CANCELED, f"cancelled after {goal.done} of {goal.steps} steps")
        else:
            self._next(goal)

    def _end(self, goal: _Goal, status: int, error: str = "") -> None:
        outcome = DEFINITIONS.initial(f"{TYPE}_Result")
        outcome.result.result = OK if status == SUCCEEDED else FAILED
        outcome.result.error_message = error
        with self._lock:  # otherwise a cancellation at this moment could overwrite the status
            self._goals.end(goal, status, outcome)
            waiting = list(goal.waiting)
        self._tell_status()
        for ended in waiting:
            ended.set_result(None)

    def _result(self, request: Any, response: Any) -> Future[None]:
        """Return a future that fills in the response when the goal has ended; the response for an unknown goal has status 0."""
        ended = Future[None]()
        with self._lock:
            goal = self._goals.find(bytes(request.goal_id.uuid))

            def fill(_: Future[None]) -> None:
                if goal is not None:
                    response.status, response.result = goal.result.status, goal.result.result

            ended.add_done_callback(fill)  # the first callback, which runs before the response is sent
            if goal is not None and not goal.ended:
                goal.waiting.append(ended)
            else:
                ended.set_result(None)
        return ended

    def _cancel(self, request: Any, response: Any) -> None:
        """Cancel the given goal, all goals accepted up to a time, or all goals; an active goal ends after the current tick."""
        with self._lock:
            answer = self._goals.cancel(request)
        response.return_code, response.goals_canceling = answer.return_code, answer.goals_canceling

    def _tell_feedback(self, goal: _Goal) -> None:
        if not self._feedback.matched:
            return
        feedback = DEFINITIONS.initial(f"{TYPE}_Feedback")
        feedback.completed_steps, feedback.remaining_steps = goal.done, goal.steps - goal.done
        self._feedback.write(messages.encode(self._goals.feedback(goal, feedback)))

    def _tell_status(self, *_: object) -> None:
        with self._lock:
            message = self._goals.status_array()
        self._status.write(messages.encode(message))
