"""Writes a robot file for a description, with all links and joints, and comments on what could not be converted."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

from graphengine.format.wording import printable
from graphengine.format.yaml_text import scalar
from graphengine.physics.description.urdf import WORLD, Urdf, UrdfJoint, UrdfLink, shape_of
from graphengine.physics.files.xml import Element, numbers

WHEEL_DAMPING = 50.0
"""Of the velocity drive that a wheel gets, N m s/rad: it keeps within 0.02 % of its target."""

_WIDTH = 120


def left_behind(urdf: Urdf) -> list[str]:
    """Return the elements of a description that are not converted, one line for each kind."""
    root = urdf.element
    found = [(tag, [element.get("name") for element in root.all(tag)]) for tag in ("transmission", "ros2_control")]
    lines = [f"{tag}: {_names(names)}" for tag, names in found if names]
    alike: dict[str, list[str]] = {}
    for gazebo in root.all("gazebo"):
        alike.setdefault(", ".join(map(_told, gazebo.children)) or "nothing", []).append(gazebo.get("reference"))
    for what, about in alike.items():
        owners = _names([name for name in about if name])
        lines.append(f"gazebo {what}: {owners}" if owners else f"gazebo {what}")
    parts = [part for joint in urdf.joints.values() for part in joint.element.children]
    lines += [f"{tag} of joints" for tag in ("safety_controller", "calibration") if any(p.tag == tag for p in parts)]
    if any(element.tag == "texture" for element in root.walk()):
        lines.append("textures of materials")
    if any(part.tag == "limit" and (numbers(part.get("velocity", "0"), 1) or (0.0,))[0] > 0 for part in parts):
        lines.append("velocity limits of joints: only commands and a drive's max_acceleration limit their speed")
    return lines


def compose(urdf: Urdf, name: str, source: str, path: str, package_paths: Sequence[str], *, fixed_base: bool) -> str:
    """Return the text of a robot file.

    Args:
        urdf: robot description.
        name: name of the robot in the file.
        source: origin of the description, for a comment.
        path: path of the description, as written in the file.
        package_paths: folders of its packages, as written in the file.
        fixed_base: whether its root link is fixed to the world.
    """
    lines = [f"# Imported by `graphrun import-urdf` from {printable(source)}.", "format: 1", f"robot: {scalar(name)}"]
    lines += [f"urdf: {scalar(path)}"]
    if package_paths:
        lines += ["package_paths:", *(f"  - {scalar(folder)}" for folder in package_paths)]
    lines += [f"base_link: {scalar(urdf.root)}"]
    if urdf.root == WORLD:
        lines[-1] += "    # which is the world itself: the robot is bolted to it"
    elif fixed_base:
        lines += ["fixed_base: true"]
    lines += ["", f"# {len(urdf.links)} links, {urdf.mass:g} kg, and the shapes that they collide with, in m"]
    lines += [f"#   {line}" for line in _links(urdf)]
    lines += ["", f"# {len(urdf.joints)} joints; origins, axes and limits are those of the description", *_joints(urdf)]
    forgotten = left_behind(urdf)
    if forgotten:
        lines += ["", "# Not carried over"]
        for line in forgotten:
            lines += _wrapped(line)
    return "\n".join(lines) + "\n"


def _wrapped(line: str) -> list[str]:
    """Return a comment as lines, wrapped if it is long."""
    return textwrap.wrap(
        line, _WIDTH, initial_indent="#   ", subsequent_indent="#     ", break_long_words=False, break_on_hyphens=False
    )


def _links(urdf: Urdf) -> Iterator[str]:
    for link in urdf.depth_first():
        shapes = [_shape(collider) for collider in link.colliders]
        mass = f"{link.mass:g} kg" if link.mass else "no mass"
        yield printable(", ".join([f"{scalar(link.name)}: {mass}", *shapes]))


def _shape(collider: Element) -> str:
    shape = shape_of(collider)
    if shape is None:
        return "no shape"
    if shape.tag in ("box", "mesh"):
        return f"{shape.tag} {shape.get('size') or shape.get('filename')}"
    length = f" and length {shape.get('length')}" if shape.tag != "sphere" else ""
    return f"{shape.tag} of radius {shape.get('radius')}{length}"


def _joints(urdf: Urdf) -> Iterator[str]:
    moving = urdf.moving()
    rolling = {wheel.joint: wheel for wheel in urdf.wheels(moving)}
    if moving:
        yield "joints:"
    for joint in moving:
        yield f"  # {_about(joint, urdf.links[joint.child])}"
        if joint.name in rolling:
            wheel = rolling[joint.name]
            yield f"  # a wheel of radius {wheel.radius:g} m; its velocity drive follows what a controller commands"
            yield f"  {scalar(joint.name)}: {{drive: {{damping: {WHEEL_DAMPING}}}}}"
        elif joint.mimic is not None:
            yield f"  {scalar(joint.name)}: {{}}"
        else:
            yield f"  {scalar(joint.name)}: {{}}    # to hold it, e.g. {{drive: {_servo(joint)}}}"
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


def _servo(joint: UrdfJoint) -> str:
    """Return drive gains: an error of 0.1 rad or 10 mm causes the full effort, and the damping prevents strong oscillation."""
    stiffness = (joint.effort or 10.0) / (0.01 if joint.type == "prismatic" else 0.1)
    return f"{{stiffness: {_rounded(stiffness)}, damping: {_rounded(stiffness / 10)}}}"


def _rounded(number: float) -> str:
    """Return a number with three significant digits, as text."""
    return f"{float(f'{number:.3g}'):.10g}"


def _told(element: Element) -> str:
    """Return a short description of an element: its tag, and its name, type and text if it has them."""
    words = (element.tag, element.get("name"), element.get("type"), element.text[:60])
    return printable(" ".join(word for word in words if word))


def _names(names: Sequence[str]) -> str:
    return ", ".join(printable(scalar(name)) for name in names)
