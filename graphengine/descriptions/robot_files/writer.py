"""Renders a draft as the text of a robot file, with comments on every link and joint and on values guessed and lost."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

from graphengine.descriptions.robot_description import WORLD, Joint, RobotDescription
from graphengine.descriptions.robot_files.draft import SECTIONS, Draft, Remark
from graphengine.descriptions.robot_files.entries import Entry
from graphengine.descriptions.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere, kind_of
from graphengine.format.wording import printable
from graphengine.format.yaml_text import flow, scalar

_WIDTH = 120


def render(draft: Draft) -> str:
    """Return the text of the robot file that a draft describes."""
    lines = [f"# Imported by `graphrun import-robot` from {printable(draft.source)}."]
    description, data = draft.description, draft.data()
    for key in [key for key in data if key not in SECTIONS]:
        lines += _lines(key, data[key])
        if key == "base_link" and description.root == WORLD:
            lines[-1] += "    # which is the world itself: the robot is bolted to it"
    lines += [
        "",
        f"# {len(description.links)} links, {description.mass:g} kg, and the shapes that they collide with, in m",
    ]
    lines += [f"#   {line}" for line in _links(description)]
    lines += ["", f"# {len(description.joints)} joints; origins, axes and limits are those of the description"]
    if "joints" in data:
        lines.append("joints:")
    for joint in description.moving():
        lines += _entry(joint.name, draft.joints[joint.name], _about(joint))
    lines += [f"# {printable(_about(joint))}" for joint in description.joints.values() if not joint.moves]
    for section in [key for key in SECTIONS[1:] if key in data]:
        lines += ["", f"{section}:"]
        for key, entry in getattr(draft, section).items():
            lines += _entry(key, entry)
    lines += _remarks("Noticed", draft.noticed)
    lines += _remarks("Guessed, as the description does not say", draft.guessed)
    lines += _remarks("Not carried over", draft.lost)
    return "\n".join([*lines, ""])


def _entry(key: str, entry: Entry, *comments: str) -> Iterator[str]:
    """Yield the lines of a key of a section, below the given comments and those of its entry."""
    yield from (f"  # {printable(comment)}" for comment in (*comments, *entry.comments))
    first, *more = _lines(key, entry.value, "  ")
    yield f"{first}    # {printable(entry.hint)}" if entry.hint else first
    yield from more


def _lines(key: str, value: Any, indent: str = "") -> list[str]:
    """Return a key with its value: one line, or if that is too long, a line for each key of the value."""
    line = f"{indent}{scalar(key)}: {flow(value)}"
    if isinstance(value, dict) and value and len(line) > _WIDTH:
        inner = (each for name, item in value.items() for each in _lines(name, item, f"{indent}  "))
        return [f"{indent}{scalar(key)}:", *inner]
    if isinstance(value, list) and not indent:
        return [f"{scalar(key)}:", *(f"  - {flow(item)}" for item in value)]
    return [line]


def _remarks(title: str, remarks: Sequence[Remark]) -> Iterator[str]:
    if remarks:
        yield from ("", f"# {title}")
    for remark in remarks:
        yield from textwrap.wrap(
            printable(remark.text),
            _WIDTH,
            initial_indent="#   ",
            subsequent_indent="#     ",
            break_long_words=False,
            break_on_hyphens=False,
        )


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
