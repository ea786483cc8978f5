"""Finds events of a recording for the timeline of the web page: commands, resets, errors, contacts of robots and verdicts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

MarkKind = Literal["command", "reset", "error", "contact", "verdict"]

MAX_MARKS = 500
"""Maximum number of marks of one kind."""
LONGEST = 160
"""Maximum length of a mark's text, characters."""
_RESETS = ("reset", "restore", "stop")


@dataclass(frozen=True, slots=True)
class RecordingMark:
    """An event of a recording.

    Attributes:
        tick: number of the tick, from 1: a command is executed before the tick, other events happen in it.
        kind: kind of the event.
        text: description in one line.
    """

    tick: int
    kind: MarkKind
    text: str


class Marks:
    """Collects the events of a replay.

    Args:
        gap: number of ticks after which a repeated contact or error text counts as a new event.
    """

    def __init__(self, gap: int = 60) -> None:
        self.all: list[RecordingMark] = []
        """All marks in chronological order."""
        self.tick = 0
        """Number of the tick that is replayed for the first time; 0: events are ignored."""
        self.gap = gap
        self._numbers: Counter[MarkKind] = Counter()
        self._last: dict[tuple[MarkKind, str], int] = {}

    def add(self, kind: MarkKind, text: str) -> None:
        """Add a mark for an event of the current tick; after `MAX_MARKS` of a kind, one last mark says that there are more."""
        if not self.tick or self._numbers[kind] > MAX_MARKS:
            return
        self._numbers[kind] += 1
        more = self._numbers[kind] > MAX_MARKS
        line = f"more than {MAX_MARKS} of a kind; the rest is not marked" if more else text.partition("\n")[0][:LONGEST]
        self.all.append(RecordingMark(self.tick, kind, line))

    def add_commands(self, commands: Sequence[tuple[str, Any]]) -> None:
        """Add marks for commands executed before the current tick."""
        for name, arguments in commands:
            self.add("reset" if name in _RESETS else "command", f"{name} {_short(arguments)}".strip())

    def add_contacts(self, touching: Mapping[str, str], robots: Callable[[], Collection[str]]) -> None:
        """Add a mark for each contact of a robot that begins in the current tick.

        Args:
            touching: a dict from each robot or object in contact to the name of the body that it touches.
            robots: function that returns the names of all robots; called when a contact begins.
        """
        for name, other in touching.items():
            text = f"{name} touches {other}"
            if self._begins("contact", text) and name in robots():
                self.add("contact", text)

    def log(self, severity: str, node: str, text: str) -> None:
        """Add a mark for an error that a node logs; the method can be the `log` function of a session."""
        told = f"{node}: {text}" if node else text
        if severity == "error" and self._begins("error", told):
            self.add("error", told)

    def _begins(self, kind: MarkKind, text: str) -> bool:
        """Return whether the same event did not occur in the last `gap` ticks."""
        if not self.tick or self._numbers[kind] > MAX_MARKS:
            return False
        before, self._last[kind, text] = self._last.get((kind, text), -self.gap), self.tick
        return self.tick - before >= self.gap


def _short(value: Any, depth: int = 3) -> str:
    """Return the names and values of a command's arguments as text."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, dict | list) and not depth:
        return "…"
    if isinstance(value, list):
        return f"({', '.join(_short(part, depth - 1) for part in value)})"
    if isinstance(value, dict):
        parts = {name: _short(part, depth - 1) for name, part in value.items() if part is not None}
        return ", ".join(f"{name} {part}" for name, part in parts.items() if part)
    return str(value)
