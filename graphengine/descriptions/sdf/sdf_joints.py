"""Reads the joints of SDF models, and writes `<gazebo>` elements for properties that URDF lacks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.robot_description import WORLD, Bounds, Joint, Link, Mimic
from graphengine.descriptions.sdf.sdf_frames import FIRST_WITH_FRAMES, SdfFrame, place_of
from graphengine.descriptions.sdf.sdf_shapes import shape_of
from graphengine.descriptions.sdf.sdf_values import (
    SdfError,
    find,
    flag_at,
    leaf,
    limit_at,
    number_at,
    numbers_at,
    seen_from,
    text_at,
)
from graphengine.devices.rotation import NOWHERE, Pose, Vector3, rotate, unrotate
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import did_you_mean, listing, printable

TYPES = ("revolute", "continuous", "prismatic", "fixed")
TWO_AXES = ("universal", "revolute2")
"""Types of joints with two axes: `axis` is fixed in the parent link, `axis2` in the child link."""
_UNSUPPORTED = {
    "ball": "write three revolute joints with an empty link between each",
    "screw": "write a prismatic joint, or a revolute one",
    "gearbox": "write a revolute joint with <mimic>",
}
_FIRST_IN_JOINT_FRAME = 5
"""Minor number of the first SDF version with joint axes in the joint frame; earlier versions use the model frame."""
_FAR = 1e6
"""Value of the missing limit of a joint that has only a lower or only an upper limit, m or rad."""
_CONVERTED = ("parent", "child", "pose", "axis", "axis2")
_SLIGHTLY = 1e-15
_SAME_PLACE = 1e-6
"""Maximum distance (m) of a ball's centre from its joint."""


def is_moving(joint: SdfFrame) -> bool:
    """Return whether a joint is of any type but fixed."""
    return joint.element.get("type") != "fixed"


def fastened(joint: SdfFrame) -> tuple[SdfFrame | None, SdfFrame]:
    """Return the parent and the child link of a joint; the parent is None if it is the world.

    Raises:
        SdfError: the parent or child is not given, does not exist, or is attached to no link.
    """
    child = joint.scope.child_of(joint.element).link()
    parent = joint.element.first("parent")
    if parent is None or not parent.text:
        raise SdfError(f"joint {printable(joint.name)!r}: no <parent>", joint.element.span)
    if parent.text == WORLD and WORLD not in joint.scope.links:
        return None, child
    return joint.scope.require(parent.text, parent).link(), child


def parts_of(
    joint: SdfFrame, frames: Mapping[SdfFrame, Pose], carries: Mapping[SdfFrame, SdfFrame], findings: Findings
) -> Iterator[Link | Joint | Element]:
    """Yield an SDF joint as a joint of a robot, then `<gazebo>` elements that refer to it or to its child link.

    A ball joint of a caster ball becomes a fixed joint, and the ball loses its friction; a joint with two axes becomes two joints
    with a link without mass between them. A note says so.

    Args:
        joint: frame of the SDF joint.
        frames: a dict from links to the pose of the link's frame in the description, in the outermost scope.
        carries: a dict from links that carry a joint to one such joint.
        findings: receives notes.

    Raises:
        SdfError: the joint's type is not supported, or a value is invalid.
    """
    parent, child = fastened(joint)
    element, kind, name = joint.element, _kind(joint), printable(joint.full_name)
    rolls = kind == "ball" and _is_ball(joint, child) and child not in carries
    if rolls:
        kind = "fixed"
        text = f"joint {name!r}: the ball joint becomes fixed, so the ball slides instead of rolling"
        findings.add("N103", text, element.span, "the ball has no friction, so it does not brake the robot")
    elif kind not in (*TYPES, *TWO_AXES):
        advice = _UNSUPPORTED.get(kind) or did_you_mean(kind, TYPES) or listing(TYPES)
        text = f"joint {name!r}: type {printable(kind)!r} is not supported"
        raise SdfError(text, element.place("type"), advice)
    pose = seen_from(frames[parent] if parent is not None else NOWHERE, joint.place)
    ends = parent.full_name if parent is not None else WORLD, child.full_name
    if kind in TWO_AXES:
        yield from _two_joints(joint, pose, ends, findings)
    else:
        yield _joint(joint, joint.full_name, kind, pose, ends, element.first("axis"))
    if rolls:
        slippery = [leaf("mu1", "0.0", element.span), leaf("mu2", "0.0", element.span)]
        yield Element("gazebo", {"reference": child.full_name}, element.span, slippery)
    yield _for_gazebo(joint, element.first("axis"))


def _two_joints(joint: SdfFrame, pose: Pose, ends: tuple[str, str], findings: Findings) -> Iterator[Link | Joint]:
    """Yield the two joints of a joint with two axes, and the link between them.

    The joint about `axis` keeps the name; the joint about `axis2`, which moves the child link, gets the name with `_axis2`.
    """
    element, name, (parent, child) = joint.element, joint.full_name, ends
    between, second = f"{name}_cross", f"{name}_axis2"
    text = f"joint {printable(name)!r}: type {element.get('type')} becomes two revolute joints"
    findings.add("N103", text, element.span, f"{printable(name)} turns about <axis>, {printable(second)} about <axis2>")
    yield Link(between, Element("link", {"name": between}, element.span), None, ())
    for tag, made, at, links in (("axis", name, pose, (parent, between)), ("axis2", second, NOWHERE, (between, child))):
        axis = element.first(tag)
        yield _joint(joint, made, "continuous" if _is_limitless(axis) else "revolute", at, links, axis)


def _joint(joint: SdfFrame, name: str, kind: str, pose: Pose, ends: tuple[str, str], axis: Element | None) -> Joint:
    """Return the URDF joint for one axis of an SDF joint.

    Args:
        joint: frame of the SDF joint.
        name: name of the URDF joint.
        kind: type of the URDF joint.
        pose: pose of the URDF joint in its parent link.
        ends: names of the parent link and of the child link.
        axis: element `<axis>` or `<axis2>` of the SDF joint; None if the SDF joint has no axis.
    """
    made = Joint(name, kind, *ends, pose, Element("joint", {"name": name, "type": kind}, joint.element.span))
    if kind != "fixed":
        made.stated_axis = _direction(joint, axis)
        made.bounds = _bounds(axis, find(axis, "limit") or axis or joint.element)
        made.losses = _losses(joint, axis)
        made.mimic = _mimic(joint, find(axis, "mimic"))
    return made


def _kind(joint: SdfFrame) -> str:
    """Return the URDF type of a joint; a revolute joint without limits is continuous."""
    kind = joint.element.get("type")
    return "continuous" if kind == "revolute" and _is_limitless(joint.element.first("axis")) else kind


def _is_limitless(axis: Element | None) -> bool:
    return math.inf == _limit(axis, "upper") == -_limit(axis, "lower")


def _limit(axis: Element | None, end: str) -> float:
    return limit_at(axis, "limit", end, default=math.inf if end == "upper" else -math.inf)


def _bounds(axis: Element | None, element: Element) -> Bounds:
    """Return the limits of a joint. Without position limits, these are None; without a limit, effort or velocity is 0."""
    largest = (limit_at(axis, "limit", end, default=math.inf) for end in ("effort", "velocity"))
    effort, velocity = (value if 0.0 < value < math.inf else 0.0 for value in largest)
    if _is_limitless(axis):
        return Bounds(None, None, effort, velocity, element)
    ends = (_limit(axis, end) for end in ("lower", "upper"))
    lower, upper = (value if math.isfinite(value) else math.copysign(_FAR, value) for value in ends)
    return Bounds(lower, upper, effort, velocity, element)


def _losses(joint: SdfFrame, axis: Element | None) -> tuple[float, float]:
    """Return damping and friction of a joint; raise SdfError if one of them is negative or not a number."""
    damping, friction = (number_at(axis, "dynamics", name, default=0.0) for name in ("damping", "friction"))
    if min(damping, friction) < 0.0:
        text = f"joint {printable(joint.full_name)!r}: damping and friction must be numbers of at least 0"
        raise SdfError(text, (find(axis, "dynamics") or joint.element).span)
    return damping, friction


def _mimic(joint: SdfFrame, mimic: Element | None) -> Mimic | None:
    if mimic is None:
        return None
    law = ("multiplier", "offset", "reference")
    multiplier, offset, reference = (number_at(mimic, name, default=0.0) for name in law)
    leader = joint.scope.require(mimic.get("joint"), mimic, "joint")
    return Mimic(leader.full_name, multiplier, offset - multiplier * reference, mimic)


def _direction(joint: SdfFrame, axis: Element | None) -> Vector3:
    """Return the axis (x, y, z) of a joint in the joint frame.

    Raises:
        SdfError: the axis is zero or not numeric, or the frame in which it is expressed does not exist.
    """
    x, y, z = numbers_at(axis, "xyz", default=(0.0, 0.0, 1.0))
    if not (x or y or z):
        assert axis is not None
        raise SdfError(f"joint {printable(joint.full_name)!r}: the axis must not be zero", axis.span)
    direction = find(axis, "xyz")
    named = direction.get("expressed_in") if direction is not None else ""
    by_model = joint.scope.version < _FIRST_IN_JOINT_FRAME
    if joint.scope.version < FIRST_WITH_FRAMES and flag_at(axis, "use_parent_model_frame") is not None:
        by_model = flag_at(axis, "use_parent_model_frame") is True
    if named and direction is not None:
        base = joint.scope.require(named, direction, "expressed_in")
    elif by_model:
        base = joint.scope.frame
    else:
        return x, y, z
    x, y, z = unrotate(joint.place[1], rotate(base.place[1], (x, y, z)))
    x, y, z = (0.0 if abs(part) < _SLIGHTLY else part for part in (x, y, z))
    return x, y, z


def _for_gazebo(joint: SdfFrame, axis: Element | None) -> Element:
    """Return a `<gazebo>` element with the joint's spring and its elements that URDF does not have."""
    made = Element("gazebo", {"reference": joint.full_name}, joint.element.span)
    if axis is not None and number_at(axis, "dynamics", "spring_stiffness", default=0.0):
        for name, tag in (("springStiffness", "spring_stiffness"), ("springReference", "spring_reference")):
            made.children.append(leaf(name, text_at(axis, "dynamics", tag) or "0", axis.span))
    made.children += [child for child in joint.element.children if child.tag not in (*_CONVERTED, "physics")]
    return made


def _is_ball(joint: SdfFrame, child: SdfFrame) -> bool:
    """Return whether the child link of a joint is a ball centred at the joint, as in a ball caster."""
    collisions = child.element.all("collision")
    for collision in collisions:
        shape = shape_of(collision)
        apart = math.dist(place_of(collision, child)[0], joint.place[0])
        if shape is None or shape.tag != "sphere" or apart > _SAME_PLACE:
            return False
    return bool(collisions)
