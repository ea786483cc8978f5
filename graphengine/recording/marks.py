"""The events of a recording that a viewer wants to find: commands, resets, errors, contacts of robots."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

MarkKind = Literal["command", "reset", "error", "contact"]

MAX_MARKS = 500
"""Of one kind."""
LONGEST = 160
"""Characters of a mark's text."""
_RESETS = ("reset", "restore", "stop")


@dataclass(frozen=True, slots=True)
class RecordingMark:
    """An event.

    Attributes:
        tick: the tick that it came before or happened in, from 1.
        kind: what it is.
        text: one line.
    """

    tick: int
    kind: MarkKind
    text: str


class Marks:
    """Collects the events of a replay.

    Args:
        gap: ticks after which a contact, or an error of the same text, counts as another one.
    """

    def __init__(self, gap: int = 60) -> None:
        self.all: list[RecordingMark] = []
        """In the order they happened."""
        self.tick = 0
        """The tick that runs for the first time; 0 while none does, and nothing is marked."""
        self.gap = gap
        self._numbers: Counter[MarkKind] = Counter()
        self._last: dict[tuple[MarkKind, str], int] = {}

    def add(self, kind: MarkKind, text: str) -> None:
        """RecordingMark an event of the present tick."""
        if not self.tick or self._numbers[kind] > MAX_MARKS:
            return
        self._numbers[kind] += 1
        more = self._numbers[kind] > MAX_MARKS
        line = f"there are more, which are not marked, than {MAX_MARKS}" if more else text.partition("\n")[0][:LONGEST]
        self.all.append(RecordingMark(self.tick, kind, line))

    def add_commands(self, commands: Sequence[tuple[str, Any]]) -> None:
        """RecordingMark what was asked of the session."""
        for name, arguments in commands:
            self.add("reset" if name in _RESETS else "command", f"{name} {_short(arguments)}".strip())

    def add_contacts(self, touching: Mapping[str, str], robots: Callable[[], Collection[str]]) -> None:
        """RecordingMark contacts of robots where they begin.

        Args:
            touching: what each robot or object touches.
            robots: returns the names of all robots; called where a contact begins.
        """
        for name, other in touching.items():
            text = f"{name} touches {other}"
            if self._begins("contact", text) and name in robots():
                self.add("contact", text)

    def log(self, severity: str, node: str, text: str) -> None:
        """RecordingMark an error that a node logs; the signature is that of a session's log."""
        told = f"{node}: {text}" if node else text
        if severity == "error" and self._begins("error", told):
            self.add("error", told)

    def _begins(self, kind: MarkKind, text: str) -> bool:
        """Whether an event that may go on over many ticks has not been there for a while."""
        if not self.tick or self._numbers[kind] > MAX_MARKS:
            return False
        before, self._last[kind, text] = self._last.get((kind, text), -self.gap), self.tick
        return self.tick - before >= self.gap


def _short(value: Any, depth: int = 3) -> str:
    """Arguments of a command without those that are not given, each after its name."""
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
