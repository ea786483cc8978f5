"""The calls of a client that wait for their answers, by number."""

from __future__ import annotations

import threading

from graphengine.format.stateful import Stateful

MAX_OPEN = 10_000
"""Calls that wait; beyond, the oldest is given up, as answers of a server that went never come."""


class Calls(Stateful):
    """Numbers that each call is given, from 1 up, and of which each is answered once at most."""

    kept = ("_last", "_open")

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._last = 0
        self._open: dict[int, None] = {}

    def begin(self) -> int:
        """Number of one more call."""
        with self._lock:
            self._last += 1
            self._open[self._last] = None
            if len(self._open) > MAX_OPEN:
                del self._open[next(iter(self._open))]
            return self._last

    def end(self, number: int) -> bool:
        """Whether a call still waited; from here on it does not."""
        with self._lock:
            return self._open.pop(number, self) is None
