"""Calls of a service that wait for their answers, by number."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from graphengine.format.stateful import Stateful

MAX_OPEN = 10_000
"""Calls that wait; beyond, the oldest is given up, as answers of a server that went never come."""


class Calls(Stateful):
    """Numbers that each call is given, from 1 up, and of which each is answered once at most.

    Args:
        give_up: called with what was kept of a call that is given up.
    """

    kept = ("_last", "_open")

    def __init__(self, give_up: Callable[[Any], object] = lambda kept: None) -> None:
        self._lock = threading.Lock()
        self._last = 0
        self._open: dict[int, Any] = {}
        self._give_up = give_up

    def begin(self, kept: Any = True) -> int:
        """Number of one more call, of which something is kept that its answer needs."""
        with self._lock:
            self._last += 1
            self._open[self._last] = kept
            if len(self._open) > MAX_OPEN:
                self._give_up(self._open.pop(next(iter(self._open))))
            return self._last

    def end(self, number: int) -> Any:
        """What was kept of a call, which no longer waits; None if it did not wait."""
        with self._lock:
            return self._open.pop(number, None)
