"""A desk at which any thread leaves word for a session, and hears what came of it."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Protocol

from graphengine.format.errors import GraphError, RecordingError, StateError, UsageError
from graphengine.runtime.commands import Step, parse
from graphengine.runtime.session import Session

MAX_WAITING = 1000
"""Commands that nobody has taken up yet; more are refused."""
SHARE = 0.01
"""Seconds of the processor after which what else was asked for waits until a tick ran."""


class Doable(Protocol):
    """Something to do with a session; one of `commands`, or what only looks."""

    def apply(self, session: Session) -> Any:
        """Do it; what came of it."""


@dataclass(frozen=True, slots=True)
class _Request:
    command: Doable
    answer: Future[Any]


class CommandDesk:
    """Commands wait here until the session looks, between two ticks; it does them in order of arrival.

    Futures end in the session's thread, callbacks included. They fail with what the session raised; also with `UsageError` for
    commands that make no sense, and with `StateError` for those that come too late or are too many.

    Args:
        clock: seconds, of the processor in this thread.
    """

    def __init__(self, clock: Callable[[], float] = time.thread_time) -> None:
        self._clock = clock
        self._arrived: queue.SimpleQueue[_Request | None] = queue.SimpleQueue()
        self._taken: deque[_Request | None] = deque()
        self._stepping: tuple[int, Future[Any]] | None = None
        self._lock = threading.Lock()
        self._closed = ""

    def submit(self, name: str, arguments: Mapping[str, Any] | None = None) -> Future[Any]:
        """Ask for one of `commands.COMMANDS`; from any thread."""
        try:
            return self.ask(parse(name, arguments))
        except UsageError as error:
            answer: Future[Any] = Future()
            answer.set_exception(error)
            return answer

    def ask(self, command: Doable) -> Future[Any]:
        """Ask for something to be done; from any thread."""
        answer: Future[Any] = Future()
        try:
            with self._lock:
                if self._closed:
                    raise StateError(self._closed)
                if self._arrived.qsize() >= MAX_WAITING:
                    raise StateError(f"{MAX_WAITING} commands wait to be done; no more are taken")
                self._arrived.put(_Request(command, answer))
        except UsageError as error:
            answer.set_exception(error)
        return answer

    def serve(self, session: Session) -> None:
        """Do what has arrived; what arrives meanwhile, or would take too long together, waits, so that ticks go on."""
        self._end_steps(session)
        waiting = len(self._taken) + self._arrived.qsize()
        end = self._clock() + SHARE
        for done in range(waiting):
            if done and self._clock() >= end:
                break
            request = self._taken.popleft() if self._taken else self._arrived.get()
            if request is not None and request.answer.set_running_or_notify_cancel():
                self._do(request, session)
                self._end_steps(session)

    def _do(self, request: _Request, session: Session) -> None:
        command, answer = request.command, request.answer
        try:
            result = command.apply(session)
        except RecordingError as error:  # it was done, and the run cannot be recorded any more
            answer.set_exception(error)
            raise
        except (GraphError, OSError) as error:
            answer.set_exception(error)
        except Exception as error:  # a fault of ours, which whoever asked is not to end the run with
            place = traceback.extract_tb(error.__traceback__)[-1]
            text = f"what was asked for went wrong: {type(error).__name__}: {error}"
            session.services.log("error", "", f"{text}\n  {place.filename}:{place.lineno}, in {place.name}")
            answer.set_exception(error)
        except BaseException as error:
            answer.set_exception(error)
            raise
        else:
            if isinstance(command, Step):
                self._stepping = (session.ticks + command.ticks, answer)
            else:
                answer.set_result(result)

    def _end_steps(self, session: Session) -> None:
        """Tell whoever asked for single ticks that they ran, or that they were cut short."""
        if self._stepping is None or session.advancing:
            return
        (last, answer), self._stepping = self._stepping, None
        missing = last - session.ticks
        if missing:
            answer.set_exception(StateError(f"cut short: {missing} of the ticks did not run"))
        else:
            answer.set_result(None)

    def wait(self, seconds: float) -> None:
        """Sleep until something is asked for, but no longer than so."""
        if self._taken:
            return
        with contextlib.suppress(queue.Empty):
            self._taken.append(self._arrived.get(timeout=seconds))

    def wake(self) -> None:
        """End a `wait`; safe in a signal handler, since the queue is."""
        self._arrived.put(None)

    def close(self, reason: str) -> None:
        """Refuse what was asked for and not done, and all that will be."""
        with self._lock:
            self._closed = self._closed or reason
        left = [self._stepping[1]] if self._stepping is not None else []
        self._stepping = None
        while self._taken or not self._arrived.empty():
            request = self._taken.popleft() if self._taken else self._arrived.get()
            if request is not None and request.answer.set_running_or_notify_cancel():
                left.append(request.answer)
        for answer in left:
            answer.set_exception(StateError(reason))
