"""Writes URDF: descriptions in other formats, and URDF descriptions that robot files have changed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from graphengine.descriptions.files.xml import Element, document_text, number
from graphengine.descriptions.robot_description import TERMS, Inertial, Joint, Link, RobotDescription
from graphengine.descriptions.shapes import Box, Capsule, Cylinder, Geometry, Mesh, Shape, Sphere, kind_of
from graphengine.descriptions.urdf.link_parts import origin_of
from graphengine.devices.rotation import NOWHERE, Pose, to_rpy
from graphengine.format.diagnostics import Span


def description_text(description: RobotDescription) -> str:
    """Return a description as URDF text, with the current positions, limits and types of its joints."""
    now = {joint.element: _as_now(joint) for joint in description.joints.values()}
    root = replace(description.element, children=[now.get(child, child) for child in description.element.children])
    return document_text(root)


def _as_now(joint: Joint) -> Element:
    """Return a copy of a joint's element with the position, limits and type that the joint has now."""
    element, changes = joint.element, dict[str, dict[str, str]]()
    if (origin_of(element) or NOWHERE)[0] != joint.pose[0]:
        changes["origin"] = {"xyz": _numbers(joint.pose[0])}
    ends = {"lower": joint.bounds.lower, "upper": joint.bounds.upper}
    if any(number(element.at("limit", name)) != end for name, end in ends.items()):
        changes["limit"] = {name: repr(end) for name, end in ends.items()}
    children = [replace(each, attributes=each.attributes | changes.pop(each.tag, {})) for each in element.children]
    for tag, attributes in changes.items():
        children.insert(0 if tag == "origin" else len(children), Element(tag, attributes, element.span))
    return replace(element, attributes=element.attributes | {"type": joint.type}, children=children)


def as_urdf(
    name: str, links: Iterable[Link], joints: Iterable[Joint], span: Span, others: Iterable[Element] = ()
) -> Element:
    """Return the `robot` element of a description.

    The content of the links and joints is written into their elements. Each joint follows the links that it connects; the tree
    can be read from top to bottom.

    Args:
        name: name of the robot.
        links: links in order of the description.
        joints: joints in order of the description.
        span: source location of the whole.
        others: elements for other programs.
    """
    root = Element("robot", {"name": name}, span)
    waiting, known = list(joints), set[str]()
    for link in links:
        link.element.children = [*_inertial(link.inertial, link.element.span), *map(_shape, link.shapes)]
        root.children.append(link.element)
        known.add(link.name)
        while waiting and known.issuperset((waiting[0].parent, waiting[0].child)):
            joint = waiting.pop(0)
            joint.element.children = list(_joint(joint))
            root.children.append(joint.element)
    root.children += others
    return root


def _inertial(inertial: Inertial | None, span: Span) -> Iterator[Element]:
    if inertial is not None:
        moments = inertial.moments or (0.0,) * 6
        numbers = [*map(repr, moments[:3]), *(repr(product) if product else "0" for product in moments[3:])]
        terms = dict(zip(TERMS, numbers, strict=True))
        mass = Element("mass", {"value": repr(inertial.mass)}, span)
        yield Element("inertial", {}, span, [_origin(inertial.pose, span), mass, Element("inertia", terms, span)])


def _shape(shape: Shape) -> Element:
    span = shape.span
    attributes = {key: _numbers(values) for key, values in _sizes(shape.geometry)}
    if isinstance(shape.geometry, Mesh):
        attributes = {"filename": shape.geometry.filename, **attributes}
    geometry = Element(kind_of(shape.geometry), attributes, shape.place)
    shape.element.children = [_origin(shape.pose, span), Element("geometry", {}, span, [geometry])]
    if shape.colour is not None:
        rgba = _numbers(shape.colour)  # RViz uses one colour for all materials with the same name
        colour = Element("color", {"rgba": rgba}, span)
        shape.element.children.append(Element("material", {"name": rgba}, span, [colour]))
    return shape.element


def _sizes(geometry: Geometry) -> Iterator[tuple[str, Iterable[float]]]:
    match geometry:
        case Box(size):
            yield "size", size
        case Mesh(_, scale):
            yield "scale", scale
        case Sphere(radius):
            yield "radius", (radius,)
        case Cylinder(radius, length) | Capsule(radius, length):
            yield from (("radius", (radius,)), ("length", (length,)))


def _joint(joint: Joint) -> Iterator[Element]:
    span, bounds = joint.element.span, joint.bounds
    yield _origin(joint.pose, span)
    yield from (Element("parent", {"link": joint.parent}, span), Element("child", {"link": joint.child}, span))
    if joint.moves:
        limits = {"lower": bounds.lower, "upper": bounds.upper, "effort": bounds.effort, "velocity": bounds.velocity}
        given = {name: repr(value) for name, value in limits.items() if value is not None}
        place = bounds.element.span if bounds.element is not None else span
        yield Element("axis", {"xyz": _numbers(joint.stated_axis)}, place)
        yield Element("limit", given, place)
        yield Element("dynamics", dict(zip(("damping", "friction"), map(repr, joint.losses), strict=True)), place)
    if joint.mimic is not None:
        law = {"joint": joint.mimic.leader, "multiplier": repr(joint.mimic.multiplier)}
        yield Element("mimic", {**law, "offset": repr(joint.mimic.offset)}, joint.mimic.element.span)


def _origin(pose: Pose, span: Span) -> Element:
    return Element("origin", {"xyz": _numbers(pose[0]), "rpy": _numbers(to_rpy(pose[1]))}, span)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(repr, values))
