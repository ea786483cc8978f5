"""Renders a draft as the text of a robot file, with comments on every link and joint and on values guessed and lost."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

from graphengine.descriptions.robot_files.draft import Draft, Entry, Remark
from graphengine.descriptions.urdf.shapes import Box, Capsule, Cylinder, Mesh, Shape, Sphere, kind_of
from graphengine.descriptions.urdf.urdf import WORLD, Urdf, UrdfJoint, UrdfLink
from graphengine.format.wording import printable
from graphengine.format.yaml_text import flow, scalar

_WIDTH = 120
_SECTIONS = ("links", "wheel_colliders", "materials", "frames", "sensors", "namespaces", "graphs")
"""Sections of the robot file after `joints`, in order of the file."""


def render(draft: Draft) -> str:
    """Return the text of the robot file that a draft describes."""
    urdf = draft.urdf
    lines = [f"# Imported by `graphrun import-robot` from {printable(draft.source)}."]
    lines += [
        "format: 1",
        f"robot: {scalar(draft.name)}",
        f"{'mjcf' if urdf.mjcf is not None else 'urdf'}: {scalar(draft.path)}",
    ]
    if draft.package_paths:
        lines += ["package_paths:", *(f"  - {scalar(folder)}" for folder in draft.package_paths)]
    lines += [f"base_link: {scalar(urdf.root)}"]
    if urdf.root == WORLD:
        lines[-1] += "    # which is the world itself: the robot is bolted to it"
    elif draft.fixed_base and urdf.moves_freely:
        lines += ["fixed_base: true"]
    lines += [f"{key}: {flow(value)}" for key, value in draft.settings.items()]
    lines += ["", f"# {len(urdf.links)} links, {urdf.mass:g} kg, and the shapes that they collide with, in m"]
    lines += [f"#   {line}" for line in _links(urdf)]
    lines += ["", f"# {len(urdf.joints)} joints; origins, axes and limits are those of the description"]
    lines += _joints(draft)
    for section in _SECTIONS:
        if entries := draft.sections[section]:
            lines += ["", f"{section}:"]
            for key, entry in entries.items():
                lines += _entry(key, entry)
    lines += _remarks("Noticed", draft.noticed)
    lines += _remarks("Guessed, as the description does not say", draft.guessed)
    lines += _remarks("Not carried over", draft.lost)
    return "\n".join(lines) + "\n"


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


def _entry(key: str, entry: Entry) -> Iterator[str]:
    for comment in entry.comments:
        yield f"  # {printable(comment)}"
    first, *more = _value(key, entry.value, "  ")
    yield first + (f"    # {printable(entry.hint)}" if entry.hint else "")
    yield from more


def _value(key: str, value: Any, indent: str) -> Iterator[str]:
    """Yield the lines of a key with its value: one line, or if that is too long, a line for each key of the value."""
    line = f"{indent}{scalar(key)}: {flow(value)}"
    if len(line) <= _WIDTH or not isinstance(value, dict) or not value:
        yield line
        return
    yield f"{indent}{scalar(key)}:"
    for name, item in value.items():
        yield from _value(name, item, indent + "  ")


def _links(urdf: Urdf) -> Iterator[str]:
    for link in urdf.depth_first():
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


def _joints(draft: Draft) -> Iterator[str]:
    urdf = draft.urdf
    moving = urdf.moving()
    if moving:
        yield "joints:"
    for joint in moving:
        yield f"  # {_about(joint, urdf.links[joint.child])}"
        yield from _entry(joint.name, draft.entry("joints", joint.name))
    for joint in urdf.joints.values():
        if not joint.moves:
            yield f"# {_about(joint, urdf.links[joint.child])}"


def _about(joint: UrdfJoint, child: UrdfLink) -> str:
    parts = [f"{scalar(joint.name)}: {joint.type}, {scalar(joint.parent)} -> {scalar(child.name)}"]
    unit, force = ("m", "N") if joint.type == "prismatic" else ("rad", "N m")
    if joint.moves:
        parts.append("axis " + " ".join(f"{value:g}" for value in joint.axis))
    if joint.moves and joint.limits is not None:
        parts.append(f"{joint.limits[0]:g} to {joint.limits[1]:g} {unit}")
    if joint.moves and joint.effort:
        parts.append(f"up to {joint.effort:g} {force}")
    if joint.mimic is not None:
        parts.append(f"follows {scalar(joint.mimic.leader)} x {joint.mimic.multiplier:g} + {joint.mimic.offset:g}")
    return printable(", ".join(parts))
