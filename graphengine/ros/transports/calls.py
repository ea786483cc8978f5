"""Numbers the calls of a service client, and keeps the unanswered calls."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from graphengine.format.stateful import Stateful

MAX_OPEN = 10_000
"""Maximum number of unanswered calls; beyond this number, the oldest call is discarded, because its server may be gone."""


class Calls(Stateful):
    """The unanswered calls of a service; each has a number, counted from 1, and gets at most one response.

    Args:
        give_up: called with the data of each call that `begin` discards because too many calls are unanswered.
    """

    kept = ("_last", "_open")

    def __init__(self, give_up: Callable[[Any], object] = lambda kept: None) -> None:
        self._lock = threading.Lock()
        self._last = 0
        self._open: dict[int, Any] = {}
        self._give_up = give_up

    def begin(self, kept: Any = True) -> int:
        """Return the number of a new call; `end` returns `kept` for this number."""
        with self._lock:
            self._last += 1
            self._open[self._last] = kept
            if len(self._open) > MAX_OPEN:
                self._give_up(self._open.pop(next(iter(self._open))))
            return self._last

    def end(self, number: int) -> Any:
        """Remove a call and return its data; None if the call is not open."""
        with self._lock:
            return self._open.pop(number, None)
