"""The robot file that an import is going to write, while its parts fill it in."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.diagnostics import Span
from graphengine.format.document import Document
from graphengine.physics.description.urdf import Urdf
from graphengine.physics.files.xml import Element


@dataclass(slots=True)
class Entry:
    """A key of the robot file with its value.

    Attributes:
        value: written on one line, or on one for each of its keys.
        comments: lines above the key.
        hint: a comment after the value.
    """

    value: dict[str, Any] = field(default_factory=dict)
    comments: list[str] = field(default_factory=list)
    hint: str = ""


@dataclass(frozen=True, slots=True)
class Remark:
    """What an import says about one part of the description.

    Attributes:
        text: one line.
        span: where the description says it; None if it says nothing.
    """

    text: str
    span: Span | None = None


@dataclass(slots=True, eq=False)
class Draft:
    """A robot file to be written.

    Attributes:
        urdf: the description.
        name: of the robot.
        source: where the description came from, for people.
        path: of the description, as the file names it.
        package_paths: folders of its packages, as the file names them.
        fixed_base: whether the root link is fixed to the world.
        controllers: parameters of ros2_control that the user gave.
        settings: keys at the top level of the file with plain values, such as `self_collision`.
        sections: entries by section (`joints`, `materials`, `sensors`, `graphs`, …) and key, in order of the file.
        carried: what the description says and the file repeats.
        guessed: what the description does not say and the file needs.
        lost: what the description says and the file cannot hold, with the reason.
    """

    urdf: Urdf
    name: str
    source: str
    path: str
    package_paths: Sequence[str] = ()
    fixed_base: bool = False
    controllers: Document | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    sections: defaultdict[str, dict[str, Entry]] = field(default_factory=lambda: defaultdict(dict))
    carried: list[Remark] = field(default_factory=list)
    guessed: list[Remark] = field(default_factory=list)
    lost: list[Remark] = field(default_factory=list)
    _used: dict[int, Element] = field(default_factory=dict)

    def entry(self, section: str, key: str) -> Entry:
        """Return the entry of a section with this key; a new one if there is none."""
        return self.sections[section].setdefault(key, Entry())

    def use(self, element: Element) -> None:
        """Mark an element of the description, and all in it, as used, so that it is not listed as left behind."""
        self._used.update((id(part), part) for part in element.walk())

    def used(self, element: Element) -> bool:
        """Return whether an element of the description was used."""
        return id(element) in self._used
