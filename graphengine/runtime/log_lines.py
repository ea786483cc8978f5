"""Keeps the newest messages that nodes and the session have logged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import takewhile

MOST_LINES, LONGEST_LINE = 1000, 2000
"""Maximum number of messages to keep, and of characters of a message."""


@dataclass(frozen=True, slots=True)
class LogLine:
    """A message in the log.

    Attributes:
        number: number of the message, from 1; the newest one of a repeated message.
        time: simulation time of the message, s.
        severity: `info`, `warning` or `error`.
        node: prim path of the node that logged the message; empty for a message of the session.
        text: the message.
        count: how often it was logged.
    """

    number: int
    time: float
    severity: str
    node: str
    text: str
    count: int


class LogLines:
    """The newest messages; a repeated message is kept once.

    Attributes:
        time: returns the simulation time, s.
    """

    def __init__(self) -> None:
        self.time: Callable[[], float] = lambda: 0.0
        self._lines: dict[tuple[str, str, str], LogLine] = {}
        """Messages by severity, node and text, in the order of their numbers."""
        self._count = 0

    def add(self, severity: str, node: str, text: str) -> None:
        """Add a message, or count a message that was logged before."""
        self._count += 1
        key = severity, node, text[:LONGEST_LINE]
        before = self._lines.pop(key, None)
        self._lines[key] = LogLine(self._count, self.time(), *key, before.count + 1 if before is not None else 1)
        if len(self._lines) > MOST_LINES:
            del self._lines[next(iter(self._lines))]

    def after(self, number: int) -> Sequence[LogLine]:
        """Return the messages after the one with this number, oldest first."""
        return [*takewhile(lambda line: line.number > number, reversed(self._lines.values()))][::-1]
