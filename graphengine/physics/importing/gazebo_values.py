"""Reads values from a description's Gazebo elements, and records which elements were read."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from graphengine.format.diagnostics import Span
from graphengine.format.wording import printable
from graphengine.physics.files.xml import Element, number
from graphengine.physics.importing.draft import Draft, Remark

TRUE = ("true", "1", "yes", "on")


class UnusableError(Exception):
    """An element of a description that an import cannot use.

    Attributes:
        reason: reason, for messages.
        span: location of the element.
    """

    def __init__(self, reason: str, span: Span) -> None:
        super().__init__(reason)
        self.reason = reason
        self.span = span


@dataclass(frozen=True, slots=True)
class Values:
    """The values in an element and its descendants. Paths are tags from the element down; `a|b` is the first of several tags."""

    element: Element
    _read: set[int] = field(default_factory=set)

    def find(self, *path: str) -> Element | None:
        """Return the first element at a path, or None."""
        found: Element | None = self.element
        for tags in path:
            children = [child for tag in tags.split("|") for child in (found.all(tag) if found is not None else ())]
            found = children[0] if children else None
        if found is not None and found is not self.element:
            self._read.add(id(found))
        return found

    def text(self, *path: str) -> str:
        """Return the text at a path, or its attribute `value`, which older descriptions use; empty without an element."""
        found = self.find(*path)
        return (found.text or found.get("value")).strip() if found is not None else ""

    def number(self, *path: str, default: float = 0.0) -> float:
        """Return the number at a path.

        Raises:
            UnusableError: there is something else.
        """
        text, found = self.text(*path), self.find(*path)
        if found is None or not text:
            return default
        value = number(text)
        if value is None:
            raise UnusableError(f"{found.tag} is no number: {printable(text[:40])!r}", found.span)
        return value

    def flag(self, *path: str) -> bool | None:
        """Return the boolean at a path; None without an element."""
        text = self.text(*path).lower()
        return text in TRUE if text else None

    def skip(self, *path: str) -> None:
        """Mark the element at a path as read."""
        if (found := self.find(*path)) is not None:
            self._read.update(id(part) for part in found.walk())

    def unread(self) -> list[Element]:
        """Return the unread elements with a value other than zero, in order of the file."""
        leaves = (part for part in self.element.walk() if part is not self.element and not part.children)
        return [leaf for leaf in leaves if id(leaf) not in self._read and number(leaf.text) != 0.0]


@dataclass(slots=True)
class Notes:
    """Collects remarks; a remark on several subjects becomes one line with all their names."""

    _said: dict[tuple[str, str], list[tuple[str, Span]]] = field(default_factory=dict)

    def add(self, kind: Literal["carried", "guessed", "lost"], subject: str, text: str, span: Span) -> None:
        """Add a remark on a subject, such as the name of a sensor."""
        self._said.setdefault((kind, text), []).append((subject, span))

    def tell(self, draft: Draft, noun: str) -> None:
        """Add the remarks to a draft, with a noun such as `sensor` before the names of the subjects."""
        for (kind, text), subjects in self._said.items():
            names = ", ".join(dict.fromkeys(printable(subject[:60]) for subject, _ in subjects))
            several = "s" if len(subjects) > 1 else ""
            getattr(draft, kind).append(Remark(f"{noun}{several} {names}: {text}", subjects[0][1]))


@dataclass(frozen=True, slots=True)
class Subject:
    """Adds remarks on one part of a description."""

    notes: Notes
    name: str
    span: Span

    def carried(self, text: str) -> None:
        """Add a remark on a value taken over into the robot file."""
        self.notes.add("carried", self.name, text, self.span)

    def guessed(self, text: str) -> None:
        """Add a remark on a value that the description lacks."""
        self.notes.add("guessed", self.name, text, self.span)

    def lost(self, text: str, span: Span | None = None) -> None:
        """Add a remark on a value that a robot file cannot express; by default at the location of the subject."""
        self.notes.add("lost", self.name, text, span or self.span)
