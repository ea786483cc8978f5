"""Keeps the newest messages that nodes and the session have logged."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import islice

MOST_LINES, LONGEST_LINE = 1000, 2000
"""Maximum number of messages to keep, and of characters of a message."""


@dataclass(frozen=True, slots=True)
class LogLine:
    """A message in the log.

    Attributes:
        number: number of the message, from 1.
        time: simulation time of the message, s.
        severity: `info`, `warning` or `error`.
        node: prim path of the node that logged the message; empty for a message of the session.
        text: the message.
    """

    number: int
    time: float
    severity: str
    node: str
    text: str


class LogLines:
    """The newest messages.

    Args:
        time: returns the simulation time, s.
    """

    def __init__(self, time: Callable[[], float]) -> None:
        self._time = time
        self._lines: deque[LogLine] = deque(maxlen=MOST_LINES)
        self._count = 0

    def add(self, severity: str, node: str, text: str) -> None:
        """Add a message."""
        self._count += 1
        self._lines.append(LogLine(self._count, self._time(), severity, node, text[:LONGEST_LINE]))

    def after(self, number: int) -> Sequence[LogLine]:
        """Return the messages after the one with this number, oldest first."""
        new = min(self._count - number, len(self._lines))
        return [*islice(self._lines, len(self._lines) - new, None)] if new > 0 else []
