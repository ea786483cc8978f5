"""Renders a draft as the text of a robot file, with comments on every link and joint and on values guessed and lost."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import Any

from graphengine.descriptions.robot_description import WORLD, Joint, RobotDescription
from graphengine.descriptions.robot_files.draft import SECTIONS, Draft, Remark
from graphengine.descriptions.robot_files.entries import Entry
from graphengine.descriptions.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere, kind_of
from graphengine.format.diagnostics import Source, Span
from graphengine.format.document import Document, Value
from graphengine.format.wording import printable
from graphengine.format.yaml_text import flow, read_back, scalar

_WIDTH = 120
_REMARK = textwrap.TextWrapper(_WIDTH, "#   ", "#     ", break_long_words=False, break_on_hyphens=False)


def render(draft: Draft, path: Path) -> Document:
    """Return the text of the robot file that a draft describes, as the source of a document with the positions of all keys.

    Args:
        draft: draft of the robot file.
        path: path of the robot file.
    """
    page = _Page([f"# Imported by `graphrun import-robot` from {printable(draft.source)}."])
    description, data = draft.description, draft.data()
    for key in [key for key in data if key not in SECTIONS]:
        page.add((key,), data[key])
        if key == "base_link" and description.root == WORLD:
            page.lines[-1] += "    # which is the world itself: the robot is bolted to it"
    total = f"{len(description.links)} links, {description.mass:g} kg, and the shapes that they collide with, in m"
    page.lines += ["", f"# {total}", *(f"#   {line}" for line in _links(description))]
    page.lines += ["", f"# {len(description.joints)} joints; origins, axes and limits are those of the description"]
    if "joints" in data:
        page.open(("joints",))
    for joint in description.moving():
        page.add_entry("joints", joint.name, draft.joints[joint.name], _about(joint))
    page.lines += [f"# {printable(_about(joint))}" for joint in description.joints.values() if not joint.moves]
    for section in [key for key in SECTIONS[1:] if key in data]:
        page.lines.append("")
        page.open((section,))
        for key, entry in getattr(draft, section).items():
            page.add_entry(section, key, entry)
    page.lines += _remarks("Noticed", draft.noticed)
    page.lines += _remarks("Guessed, as the description does not say", draft.guessed)
    page.lines += _remarks("Not carried over", draft.lost)
    return page.document(path)


@dataclass(slots=True)
class _Page:
    """The lines of a robot file, and location, value and line number of each key in block style."""

    lines: list[str]
    rows: list[tuple[tuple[str, ...], Any, int]] = field(default_factory=list)

    def add_entry(self, section: str, key: str, entry: Entry[Any], *comments: str) -> None:
        """Add a key of a section, below the given comments and the comments of the entry."""
        self.lines += [f"  # {printable(comment)}" for comment in (*comments, *entry.comments)]
        number = len(self.lines)
        self.add((section, key), entry.value)
        if entry.hint:
            self.lines[number] += f"    # {printable(entry.hint)}"

    def add(self, location: tuple[str, ...], value: Any) -> None:
        """Add a key with its value on one line, or with one line for each key of the value if one line would be too long."""
        indent, key = "  " * (len(location) - 1), scalar(location[-1])
        line = f"{indent}{key}: {flow(value)}"
        if isinstance(value, dict) and value and len(line) > _WIDTH:
            self.open(location)
            for name, item in value.items():
                self.add((*location, name), item)
        elif isinstance(value, list) and not indent:
            self.lines += [f"{key}:", *(f"  - {flow(item)}" for item in value)]
            self.rows.append((location, value, len(self.lines) - len(value)))
        else:
            self.lines.append(line)
            self.rows.append((location, value, len(self.lines)))

    def open(self, location: tuple[str, ...]) -> None:
        """Add a key whose mapping is on the lines below."""
        self.lines.append(f"{'  ' * (len(location) - 1)}{scalar(location[-1])}:")
        self.rows.append((location, None, len(self.lines)))

    def document(self, path: Path) -> Document:
        """Return the document of all lines, with the position of each key and value."""
        source = Source(str(path), (*self.lines, ""))
        root = Value(Span(source, 1, 1), {})
        for (*above, key), value, number in self.rows:
            holder = root
            for name in above:
                holder = holder.data[name]
            place = Span(source, number, 2 * len(above) + 1, len(scalar(key)))
            if not holder.keys:
                holder.span = place.part(0, 1)  # a mapping in block style begins at its first key
            holder.keys[key] = place
            if value is None:
                holder.data[key] = Value(place, {})
            elif isinstance(value, list) and not above:
                items = [_placed(item, Span(source, number + line, 5)) for line, item in enumerate(value, 1)]
                holder.data[key] = Value(Span(source, number + 1, 3), items)
            else:
                holder.data[key] = _placed(value, place.part(place.length + 2, 1))
        return Document(source, root, 0)


def _remarks(title: str, remarks: Sequence[Remark]) -> Iterator[str]:
    if remarks:
        yield from ("", f"# {title}")
    for remark in remarks:
        yield from _REMARK.wrap(printable(remark.text))


def _links(description: RobotDescription) -> Iterator[str]:
    for link in description.depth_first():
        shapes = [_shape(collider) for collider in link.colliders]
        mass = f"{link.mass:g} kg" if link.mass else "no mass"
        yield printable(", ".join([f"{scalar(link.name)}: {mass}", *shapes]))


def _shape(collider: Shape) -> str:
    kind = kind_of(collider.geometry)
    match collider.geometry:
        case Box(size):
            return f"{kind} {' '.join(f'{length:.12g}' for length in size)}"
        case Mesh(filename):
            return f"{kind} {filename}"
        case Sphere(radius):
            return f"{kind} of radius {radius:.12g}"
        case Cylinder(radius, length) | Capsule(radius, length):
            return f"{kind} of radius {radius:.12g} and length {length:.12g}"


def _about(joint: Joint) -> str:
    parts = [f"{scalar(joint.name)}: {joint.type}, {scalar(joint.parent)} -> {scalar(joint.child)}"]
    unit, force = ("m", "N") if joint.type == "prismatic" else ("rad", "N m")
    if joint.moves:
        parts.append("axis " + " ".join(f"{value:g}" for value in joint.axis))
    if joint.moves and joint.limits is not None:
        parts.append(f"{joint.limits[0]:g} to {joint.limits[1]:g} {unit}")
    if joint.moves and joint.effort:
        parts.append(f"up to {joint.effort:g} {force}")
    if joint.mimic is not None:
        parts.append(f"follows {scalar(joint.mimic.leader)} x {joint.mimic.multiplier:g} + {joint.mimic.offset:g}")
    return ", ".join(parts)


def _placed(value: Any, span: Span) -> Value:
    """Return a value in flow style that begins at a position, with the positions of all keys and values in it."""
    if isinstance(value, list):
        starts = accumulate((len(flow(item)) + 2 for item in value), initial=1)
        return Value(span, [_placed(item, span.part(start, 1)) for item, start in zip(value, starts, strict=False)])
    if not isinstance(value, dict):
        text = flow(value)
        return Value(span.part(0, len(text)), read_back(value), plain=text[:1] != '"')
    found, column = Value(span, {}), 1
    for key, item in value.items():
        found.keys[key] = span.part(column, len(scalar(key)))
        column += len(scalar(key)) + 2
        found.data[key] = _placed(item, span.part(column, 1))
        column += len(flow(item)) + 2
    return found
