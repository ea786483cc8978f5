"""The command queue, through which other threads control a session."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

from graphengine.format.errors import GraphError, RecordingError, StateError, UsageError
from graphengine.runtime.commands import parse
from graphengine.runtime.session_core import SessionCore

MAX_WAITING = 1000
"""Maximum number of waiting commands; further commands are refused."""
SHARE = 0.01
"""CPU time for commands between two ticks, s; a command that cannot start in this time waits for the next tick."""


Action = Callable[[SessionCore], Any]
"""A function that the session's thread calls with the session; the result completes the command's future."""


class CommandQueue:
    """A queue for commands from any thread; the session executes them between two ticks, in order of arrival.

    The session's thread completes the futures and runs their callbacks. A future gets the exception that the session raised, a
    `UsageError` if the command is invalid, or a `StateError` if the session has ended or too many commands are waiting.

    Args:
        clock: function that returns the CPU time of the session's thread, s.
    """

    def __init__(self, clock: Callable[[], float] = time.thread_time) -> None:
        self._clock = clock
        self._arrived: queue.SimpleQueue[tuple[Action, Future[Any]] | None] = queue.SimpleQueue()
        self._taken: deque[tuple[Action, Future[Any]] | None] = deque()
        self._stepping: tuple[int, Future[Any]] | None = None
        self._lock = threading.Lock()
        self._closed = ""

    def submit(self, name: str, arguments: Mapping[str, Any] | None = None) -> Future[Any]:
        """Queue a command by its name in `commands.COMMANDS`; return the future of its result. Thread-safe."""
        try:
            return self.ask(parse(name, arguments).apply)
        except UsageError as error:
            return _failed(error)

    def ask(self, action: Action) -> Future[Any]:
        """Queue a function that the session's thread calls with the session; return the future of its result. Thread-safe."""
        answer = Future[Any]()
        with self._lock:
            if self._closed:
                return _failed(StateError(self._closed))
            if self._arrived.qsize() >= MAX_WAITING:
                return _failed(StateError(f"the queue is full: {MAX_WAITING} commands are waiting"))
            self._arrived.put((action, answer))
        return answer

    def serve(self, session: SessionCore) -> None:
        """Execute waiting commands for up to `SHARE` s of CPU time; the remaining commands wait for the next call."""
        self._end_steps(session)
        waiting = len(self._taken) + self._arrived.qsize()
        end = self._clock() + SHARE
        for done in range(waiting):
            if done and self._clock() >= end:
                break
            request = self._taken.popleft() if self._taken else self._arrived.get()
            if request is not None and request[1].set_running_or_notify_cancel():
                self._do(*request, session)
                self._end_steps(session)

    def _do(self, action: Action, answer: Future[Any], session: SessionCore) -> None:
        advancing = session.advancing
        try:
            result = action(session)
        except RecordingError as error:  # the command was executed, but the run can no longer be recorded
            answer.set_exception(error)
            raise
        except (GraphError, OSError) as error:
            answer.set_exception(error)
        except Exception as error:  # an internal error, which must not end the run
            place = traceback.extract_tb(error.__traceback__)[-1]
            text = f"a request failed with an internal error: {type(error).__name__}: {error}"
            session.services.log("error", "", f"{text}\n  {place.filename}:{place.lineno}, in {place.name}")
            answer.set_exception(error)
        except BaseException as error:
            answer.set_exception(error)
            raise
        else:
            if session.advancing and not advancing:  # the command `step` is complete when its ticks have run
                self._stepping = (session.ticks + session.advancing, answer)
            else:
                answer.set_result(result)

    def _end_steps(self, session: SessionCore) -> None:
        """Complete the future of a command `step` if its ticks have run or were cancelled."""
        if self._stepping is None or session.advancing:
            return
        (last, answer), self._stepping = self._stepping, None
        missing = last - session.ticks
        if missing:
            answer.set_exception(StateError(f"cancelled: {missing} of the ticks did not run"))
        else:
            answer.set_result(None)

    def wait(self, seconds: float) -> None:
        """Sleep until a command arrives or `wake` is called, for at most `seconds`."""
        if self._taken:
            return
        with contextlib.suppress(queue.Empty):
            self._taken.append(self._arrived.get(timeout=seconds))

    def wake(self) -> None:
        """End the current or next `wait`. Thread-safe; also safe in a signal handler, because `SimpleQueue` is reentrant."""
        self._arrived.put(None)

    def close(self, reason: str) -> None:
        """Reject all waiting and all later commands with a `StateError` whose message is `reason`."""
        with self._lock:
            self._closed = self._closed or reason
        left = [self._stepping[1]] if self._stepping is not None else []
        self._stepping = None
        while self._taken or not self._arrived.empty():
            request = self._taken.popleft() if self._taken else self._arrived.get()
            if request is not None and request[1].set_running_or_notify_cancel():
                left.append(request[1])
        for answer in left:
            answer.set_exception(StateError(reason))


def _failed(error: UsageError) -> Future[Any]:
    """Return a future with an exception."""
    answer = Future[Any]()
    answer.set_exception(error)
    return answer
