"""Reads values from the Gazebo elements of a description, and records which elements were read."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from graphengine.descriptions.files.xml import Element, number
from graphengine.descriptions.robot_files.draft import Claim, Draft, Remark
from graphengine.format.diagnostics import Span
from graphengine.format.wording import printable

TRUE = ("true", "1", "yes", "on")
GAZEBO_NAMES: dict[str, Any] = json.loads(Path(__file__).with_name("gazebo_names.json").read_text("utf-8"))
"""Tables of names in Gazebo; the modules that use a table describe it."""


class UnusableError(Exception):
    """An element of a description that an import cannot use.

    Attributes:
        reason: reason why the element cannot be used, for messages.
        span: source location of the element.
    """

    def __init__(self, reason: str, span: Span) -> None:
        super().__init__(reason)
        self.reason = reason
        self.span = span


@dataclass(frozen=True, slots=True)
class Values:
    """The values in an element and its descendants.

    A path is a sequence of tags, starting below the element. A tag `a|b` stands for the first child with tag a, else with tag b.
    """

    element: Element
    _read: set[int] = field(default_factory=set)

    def find(self, *path: str) -> Element | None:
        """Return the first element at a path, and mark it as read; None without an element."""
        found: Element | None = self.element
        for tags in path:
            children = [child for tag in tags.split("|") for child in (found.all(tag) if found is not None else ())]
            found = children[0] if children else None
        if found is not None and found is not self.element:
            self._read.add(id(found))
        return found

    def text(self, *path: str) -> str:
        """Return the text of the element at a path, else its attribute `value`, as in older descriptions; else an empty text."""
        found = self.find(*path)
        return (found.text or found.get("value")).strip() if found is not None else ""

    def number(self, *path: str, default: float = 0.0) -> float:
        """Return the number in the element at a path; `default` without such an element or text.

        Raises:
            UnusableError: the text is not a number.
        """
        text, found = self.text(*path), self.find(*path)
        if found is None or not text:
            return default
        value = number(text)
        if value is None:
            raise UnusableError(f"{found.tag} is not a number: {printable(text[:40])!r}", found.span)
        return value

    def flag(self, *path: str) -> bool | None:
        """Return the boolean in the element at a path; None without such an element or text."""
        text = self.text(*path).lower()
        return text in TRUE if text else None

    def skip(self, *path: str) -> None:
        """Mark the element at a path, and all elements below it, as read."""
        if (found := self.find(*path)) is not None:
            self._read.update(id(part) for part in found.walk())

    def unread(self) -> list[Element]:
        """Return the elements without children that were not read, in order of the file.

        Elements with value 0, and those without text and attributes, are left out.
        """
        leaves = (part for part in self.element.walk() if part is not self.element and not part.children)
        telling = (leaf for leaf in leaves if leaf.text or leaf.attributes)
        return [leaf for leaf in telling if id(leaf) not in self._read and number(leaf.text) != 0.0]


@dataclass(frozen=True, slots=True)
class Subject:
    """A link or sensor of a description, as `noun` says, with methods that add remarks on it.

    The same remark on several links, or on several sensors, becomes one line with all their names.
    """

    draft: Draft
    noun: str
    name: str
    span: Span

    def carried(self, text: str, claim: Claim) -> None:
        """Add a remark on a value that the import carried over, with the claim that the robot file contains the value."""
        self.draft.carried.append(self._remark(text, self.span, claim))

    def guessed(self, text: str) -> None:
        """Add a remark on a value that the import chose, because the description lacks it."""
        self.draft.guessed.append(self._remark(text, self.span))

    def lost(self, text: str, span: Span | None = None) -> None:
        """Add a remark on a value that a robot file cannot express; by default, the location is that of the link or sensor."""
        self.draft.lost.append(self._remark(text, span or self.span))

    def _remark(self, text: str, span: Span, claim: Claim | None = None) -> Remark:
        return Remark(text, span, claim or {}, (self.noun, printable(self.name[:60])))


@dataclass(frozen=True, slots=True)
class Figures:
    """The conversion of a Gazebo sensor for a robot file.

    Attributes:
        type: type of the sensor in the robot file, such as `lidar`.
        graph: name of the graph in `graphs/publishers` that publishes the sensor.
        profile: profile of the sensor in the robot file.
        told: short summary of the profile, for remarks.
        turned: whether the sensor keeps its orientation; otherwise it gets the orientation of its link.
    """

    type: str
    graph: str
    profile: dict[str, Any]
    told: str
    turned: bool = True


def rate(values: Values, default: float, sensor: Subject) -> float:
    """Return the rate of a sensor, Hz; without a rate in the description, return `default` and add a remark."""
    rate = values.number("update_rate") or values.number("plugin", "updateRate|update_rate")
    if rate > 0.0:
        return rate
    sensor.guessed(f"no update_rate: {default:g} Hz")
    return default


def noise(values: Values, sensor: Subject, *paths: tuple[str, ...]) -> float:
    """Return the standard deviation of the noise at the first existing path, in units of the measured value.

    Without noise at these paths, return the standard deviation in a ROS 1 plugin, or 0. Noise that a profile cannot express is
    reported as lost.
    """
    for path in paths:
        if (found := values.find(*path)) is None:
            continue
        kind = found.get("type") or values.text(*path, "type") or "none"
        mean, deviation = values.number(*path, "mean"), values.number(*path, "stddev")
        if kind == "none" or not (mean or deviation):
            return 0.0
        if not kind.startswith("gaussian"):
            sensor.lost(f"noise of type {printable(kind[:40])!r}", found.span)
            return 0.0
        if mean:
            sensor.lost(f"mean {mean:g} of its noise; the profile has the standard deviation alone", found.span)
        return deviation
    return values.number("plugin", "gaussianNoise")
