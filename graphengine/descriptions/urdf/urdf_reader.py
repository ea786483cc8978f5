"""Parses the XML of a URDF description into links and joints.

Only `link`, `joint` and `material` elements are parsed. Elements for other programs (gazebo, ros2_control, transmission) are
kept in the text that robot_state_publisher publishes.
"""

from __future__ import annotations

import math

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element, number, numbers
from graphengine.descriptions.link_tree import LEGAL, assembled
from graphengine.descriptions.robot_description import MOVING, Bounds, Joint, Link, Mimic, RobotDescription
from graphengine.descriptions.shapes import MAX_COLOUR
from graphengine.descriptions.urdf.link_parts import MADE, colours_by_name, inertial_of, origin_of, shapes_of, triple
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import did_you_mean, listing

_COUNTS = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "effort": 1, "velocity": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mesh": {"scale": 3},
    "color": {"rgba": 4},
} | {tag: counts for tag, (counts, _) in MADE.items()}
"""For each tag: the numeric attributes of its elements, and how many numbers each must have."""
_SINGLE = {
    "link": ("inertial",),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
    "inertial": ("origin", "mass", "inertia"),
    "collision": ("origin", "geometry"),
    "visual": ("origin", "geometry"),
}
"""For each tag: tags of the child elements that its elements can have only once; ROS reads the first of several."""
_IN_WORDS = {1: "a number", 3: "three numbers", 4: "four numbers"}


def read_urdf(root: Element, packages: Packages, findings: Findings) -> RobotDescription | None:
    """Return the links and joints of a description; None after an error, which is added to `findings`."""
    if root.tag != "robot":
        findings.add("S103", f"a robot description begins with <robot>, not <{root.tag[:40]}>", root.span)
        return None
    before = len(findings.errors)
    for owner in root.children:
        if owner.tag in _SINGLE:
            _leave_first_parts(owner, findings)
        if owner.tag == "link":
            _leave_one_shape(owner, findings)
        if owner.tag in ("link", "joint", "material"):
            check_numbers(owner, findings)
    colours = colours_by_name(root)
    links = [
        Link(each.get("name"), each, inertial_of(each, findings), list(shapes_of(each, colours, findings)))
        for each in root.all("link")
    ]
    joints = [joint for each in root.all("joint") if (joint := _joint(each, findings)) is not None]
    return assembled(root, packages, links, joints, findings, before)


def _leave_first_parts(owner: Element, findings: Findings) -> None:
    """Remove repeated child elements of a link or joint, and keep the first, where only one is legal (`_SINGLE`), as in ROS."""
    for element in owner.walk():
        for tag in _SINGLE.get(element.tag, ()):
            first, *more = element.all(tag) or [element]
            if more:
                where = f" in <{element.tag}>" if element is not owner else ""
                text = f"{owner.tag} {owner.get('name')!r}: only the first of {1 + len(more)} <{tag}>{where} counts"
                related = [(first.span, "first here")]
                findings.add("N103", text, more[0].span, f"delete the other <{tag}>", related=related)
                element.children = [child for child in element.children if child not in more]


def _leave_one_shape(link: Element, findings: Findings) -> None:
    """Remove all shapes but the first from each `geometry` of a link, as ROS does."""
    for part in link.all("collision") + link.all("visual"):
        for geometry in part.all("geometry")[:1]:
            shapes, more = len(geometry.children), geometry.children[1:]
            if more:
                text = f"link {link.get('name')!r}: only the first of {shapes} shapes in a <geometry> counts"
                findings.add("N103", text, more[0].span, f"write a <{part.tag}> for each shape")
                del geometry.children[1:]


def _joint(element: Element, findings: Findings) -> Joint | None:
    name, kind = element.get("name"), element.get("type")
    if kind not in (*LEGAL, "floating", "planar"):
        near = did_you_mean(kind, LEGAL) or listing(LEGAL)
        findings.add("S103", f"joint {name!r}: unknown type {kind!r}", element.place("type"), near)
        return None
    parent, child = (element.at(tag, "link") for tag in ("parent", "child"))
    pose, axis = origin_of(element), triple(element.at("axis", "xyz", "1 0 0"))
    length = math.hypot(*axis) if axis is not None else 0.0
    if pose is None or (not length and kind in MOVING):
        return None  # check_numbers has added an error
    stated = axis if axis is not None and length else (1.0, 0.0, 0.0)
    ends = ("lower", "upper", "effort", "velocity")
    lower, upper, effort, velocity = (number(element.at("limit", end)) for end in ends)
    bounds = Bounds(lower, upper, effort, velocity, element.first("limit"))
    damping, friction = (number(element.at("dynamics", name)) or 0.0 for name in ("damping", "friction"))
    mimic = _mimic(element) if kind in MOVING else None
    return Joint(name, kind, parent, child, pose, element, stated, bounds, (damping, friction), mimic)


def _mimic(joint: Element) -> Mimic | None:
    """Return the mimic law of a joint, with NaN for texts that are not numbers; None if the joint has no `mimic`."""
    element = joint.first("mimic")
    if element is None:
        return None
    law = number(element.get("multiplier", "1")), number(element.get("offset", "0"))
    multiplier, offset = (value if value is not None else math.nan for value in law)
    return Mimic(element.get("joint"), multiplier, offset, element)


def check_numbers(owner: Element, findings: Findings) -> None:
    """Add an error for each numeric attribute below a link, joint or material whose text is not legal."""
    for part in owner.walk():
        for attribute, count in _COUNTS.get(part.tag, {}).items():
            text = part.get(attribute)
            values, wanted = numbers(text, count), _IN_WORDS[count]
            if part.tag == "axis" and values is not None and not any(values) and owner.get("type") in MOVING:
                values, wanted = None, f"{wanted}, not all of them zero"
            elif part.tag == "color" and values is not None and max(map(abs, values)) > MAX_COLOUR:
                values = None
            elif part.tag == "dynamics" and values is not None and values[0] < 0:
                values, wanted = None, f"{wanted} of at least 0"
            if attribute in part.attributes and values is None:
                what = f"{owner.tag} {owner.get('name')!r}: {part.tag} {attribute} must be {wanted}, not {text[:60]!r}"
                findings.add("S103", what, part.place(attribute))
