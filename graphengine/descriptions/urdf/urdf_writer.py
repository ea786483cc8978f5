"""Writes links and joints as URDF, for descriptions that are not read from URDF."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.urdf.shapes import Box, Capsule, Cylinder, Geometry, Mesh, Shape, Sphere, kind_of
from graphengine.descriptions.urdf.urdf import TERMS, Inertial, UrdfJoint, UrdfLink
from graphengine.devices.rotation import Pose, to_rpy
from graphengine.format.diagnostics import Span


def as_urdf(name: str, links: Iterable[UrdfLink], joints: Iterable[UrdfJoint], span: Span) -> Element:
    """Return the `robot` element of a description.

    The elements of links and joints get their content. Each joint follows the links that it connects, so that the tree can be
    read from top to bottom.

    Args:
        name: name of the robot.
        links: links in order of the description.
        joints: joints in order of the description.
        span: source location of the whole.
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
    geometry = Element(kind_of(shape.geometry), attributes, span)
    shape.element.children = [_origin(shape.pose, span), Element("geometry", {}, span, [geometry])]
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


def _joint(joint: UrdfJoint) -> Iterator[Element]:
    span, bounds = joint.element.span, joint.bounds
    yield _origin(joint.pose, span)
    yield from (Element("parent", {"link": joint.parent}, span), Element("child", {"link": joint.child}, span))
    if joint.moves:
        limits = {"lower": bounds.lower, "upper": bounds.upper, "effort": bounds.effort, "velocity": bounds.velocity}
        given = {name: repr(value) for name, value in limits.items() if value is not None}
        yield Element("axis", {"xyz": _numbers(joint.stated_axis)}, span)
        yield Element("limit", given, span)
        yield Element("dynamics", dict(zip(("damping", "friction"), map(repr, joint.losses), strict=True)), span)
    if joint.mimic is not None:
        law = {"joint": joint.mimic.leader, "multiplier": repr(joint.mimic.multiplier)}
        yield Element("mimic", {**law, "offset": repr(joint.mimic.offset)}, span)


def _origin(pose: Pose, span: Span) -> Element:
    return Element("origin", {"xyz": _numbers(pose[0]), "rpy": _numbers(to_rpy(pose[1]))}, span)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(repr, values))
