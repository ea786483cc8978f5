"""Parses the XML of a URDF description into links and joints.

Only `link`, `joint` and `material` elements are parsed. Elements for other programs (gazebo, ros2_control, transmission) are
kept in the text that robot_state_publisher publishes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element, numbers
from graphengine.descriptions.urdf.joint_units import check_degrees, swapped_limits
from graphengine.descriptions.urdf.link_parts import MADE, colours_by_name, inertial_of, number_at, origin_of, shapes_of
from graphengine.descriptions.urdf.shapes import MAX_COLOUR
from graphengine.descriptions.urdf.urdf import MOVING, Bounds, Mimic, Urdf, UrdfJoint, UrdfLink
from graphengine.devices.rotation import Vector3
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import did_you_mean, listing

LEGAL = (*MOVING, "fixed")
MAX_LINKS = 2000
"""Maximum number of links of a URDF, and maximum number of its joints."""

_COUNTS = {
    "origin": {"xyz": 3, "rpy": 3},
    "axis": {"xyz": 3},
    "limit": {"lower": 1, "upper": 1, "effort": 1, "velocity": 1},
    "dynamics": {"damping": 1, "friction": 1},
    "mesh": {"scale": 3},
    "color": {"rgba": 4},
} | {tag: counts for tag, (counts, _) in MADE.items()}
"""Required number of numbers in numeric attributes, by element tag and attribute name."""
_SINGLE = {
    "link": ("inertial",),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
    "inertial": ("origin", "mass", "inertia"),
    "collision": ("origin", "geometry"),
    "visual": ("origin", "geometry"),
}
"""Tags of the child elements that an element can have only once, by its own tag; ROS reads the first of several."""
_IN_WORDS = {1: "a number", 3: "three numbers", 4: "four numbers"}


def read_urdf(root: Element, packages: Packages, findings: Findings) -> Urdf | None:
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
    links: dict[str, UrdfLink] = {}
    colours = colours_by_name(root)
    for element in _named(root, "link", findings):
        name, inertial = element.get("name"), inertial_of(element, findings)
        links[name] = UrdfLink(name, element, inertial, list(shapes_of(element, colours, findings)))
    joints: dict[str, UrdfJoint] = {}
    for element in _named(root, "joint", findings):
        joint = _joint(element, links, findings)
        if joint is not None:
            joints[joint.name] = joint
    top = _tree(root, links, findings) if len(findings.errors) == before else ""
    if not top:
        return None
    top = _release(top, links, joints, findings)
    for joint in joints.values():
        if joint.type not in LEGAL:
            _not_simulated(joint, findings)
        joint.mimic = _mimic(joint, joints, findings)
    check_limits(joints.values(), findings)
    return Urdf(root, packages, links, joints, top) if len(findings.errors) == before else None


def check_limits(joints: Iterable[UrdfJoint], findings: Findings) -> None:
    """Add warnings on limits that are probably swapped or in degrees, and a note on joints without limits."""
    joints = list(joints)
    for joint in joints:
        check_degrees(joint, findings)
    boundless = [joint for joint in joints if joint.type in ("revolute", "prismatic") and joint.limits is None]
    boundless = [joint for joint in boundless if not swapped_limits(joint, findings)]
    if boundless:
        names = listing((joint.name for joint in boundless), "joints")
        findings.add(
            "N103", "joints without limits, or with equal limits, move freely", boundless[0].element.span, names
        )


def _named(root: Element, tag: str, findings: Findings) -> Iterator[Element]:
    seen: dict[str, Element] = {}
    for element in root.all(tag):
        name = element.get("name")
        if not name:
            findings.add("S103", f"a {tag} without a name", element.span)
        elif name in seen:
            findings.add(
                "S105", f"two {tag}s named {name!r}", element.place("name"), related=[(seen[name].span, "first here")]
            )
        elif len(seen) == MAX_LINKS:
            findings.add("S103", f"more than {MAX_LINKS} {tag}s", element.span)
            return
        else:
            seen[name] = element
            yield element


def _leave_first_parts(owner: Element, findings: Findings) -> None:
    """Remove repeated child elements of a link or joint that can have only one of them, as ROS does; keep the first."""
    for element in owner.walk():
        for tag in _SINGLE.get(element.tag, ()):
            first, *more = element.all(tag) or [element]
            if more:
                where = f" in <{element.tag}>" if element is not owner else ""
                text = f"{owner.tag} {owner.get('name')!r}: only the first of {1 + len(more)} <{tag}>{where} counts"
                findings.add(
                    "N103", text, more[0].span, f"delete the other <{tag}>", related=[(first.span, "first here")]
                )
                element.children = [child for child in element.children if child not in more]


def _leave_one_shape(link: Element, findings: Findings) -> None:
    """Remove all shapes but the first from each `geometry` of a link, as ROS does."""
    for part in link.all("collision") + link.all("visual"):
        geometry = part.first("geometry")
        if geometry is not None and len(geometry.children) > 1:
            text = (
                f"link {link.get('name')!r}: only the first of {len(geometry.children)} shapes in a <geometry> counts"
            )
            findings.add("N103", text, geometry.children[1].span, f"write a <{part.tag}> for each shape")
            del geometry.children[1:]


def _joint(element: Element, links: dict[str, UrdfLink], findings: Findings) -> UrdfJoint | None:
    name, kind = element.get("name"), element.get("type")
    if kind not in (*LEGAL, "floating", "planar"):
        near = did_you_mean(kind, LEGAL) or listing(LEGAL)
        findings.add("S103", f"joint {name!r}: unknown type {kind!r}", element.place("type"), near)
        return None
    ends: list[UrdfLink] = []
    for tag in ("parent", "child"):
        end = element.first(tag)
        link = end.get("link") if end is not None else ""
        if end is None or link not in links:
            span = end.place("link") if end is not None else element.span
            near = did_you_mean(link, links) or listing(links, "links")
            findings.add("S103", f"joint {name!r}: no {tag} link {link!r}", span, near)
            return None
        ends.append(links[link])
    pose, axis = origin_of(element), _axis(element)
    length = math.hypot(*axis) if axis is not None else 0.0
    if pose is None or (not length and kind in MOVING):
        return None  # check_numbers has added an error
    parent, child = ends
    if child.carrier is not None:
        first = (child.carrier.element.span, "first here")
        findings.add("S103", f"link {child.name!r} has two parents", element.span, related=[first])
        return None
    stated = axis if axis is not None and length else (1.0, 0.0, 0.0)
    x, y, z = (part / (length or 1.0) for part in stated)
    limit, dynamics = element.first("limit"), element.first("dynamics")
    bounds = Bounds(*(number_at(limit, name) for name in ("lower", "upper", "effort", "velocity")))
    losses = number_at(dynamics, "damping") or 0.0, number_at(dynamics, "friction") or 0.0
    joint = UrdfJoint(name, kind, parent.name, child.name, pose, (x, y, z), element, stated, bounds, losses)
    parent.below.append(joint)
    child.carrier = joint
    return joint


def _axis(joint: Element) -> Vector3 | None:
    """Return the axis of a joint as it is stated, x by default; None if it is not three numbers."""
    axis = joint.first("axis")
    values = numbers(axis.get("xyz", "1 0 0"), 3) if axis is not None else (1.0, 0.0, 0.0)
    return (values[0], values[1], values[2]) if values is not None else None


def check_numbers(owner: Element, findings: Findings) -> None:
    """Add an error for each attribute below a link, joint or material that must be numeric and is not."""
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


def _tree(root: Element, links: dict[str, UrdfLink], findings: Findings) -> str:
    """Return the name of the root link; empty if the links do not form a single tree, after adding an error."""
    if not links:
        findings.add("S103", "the description has no link", root.span)
        return ""
    tops = [link for link in links.values() if link.carrier is None]
    if len(tops) != 1:
        what = listing([link.name for link in tops], "links without a parent")
        findings.add("S103", "the links do not form one tree", root.span, what, "connect them with joints")
        return ""
    reached = [tops[0]]
    for link in reached:
        reached.extend(links[joint.child] for joint in link.below)
    if len(reached) != len(links):
        lost = listing(links.keys() - {link.name for link in reached}, "links in a closed loop of joints")
        findings.add("S103", "the links do not form one tree", root.span, lost)
        return ""
    return tops[0].name


def _release(top: str, links: dict[str, UrdfLink], joints: dict[str, UrdfJoint], findings: Findings) -> str:
    """Remove a floating joint below an empty root link, together with that link, and return the name of the new root link.

    Such a joint is superfluous, because the simulator lets every robot move freely. Otherwise nothing changes.
    """
    joint = links[top].below[0] if len(links[top].below) == 1 else None
    if joint is None or joint.type != "floating" or not links[top].empty:
        return top
    text = f"joint {joint.name!r} and link {top!r} are left out: the robot moves freely without them"
    findings.add("N103", text, joint.element.span)
    del links[top], joints[joint.name]
    links[joint.child].carrier = None
    return joint.child


def _not_simulated(joint: UrdfJoint, findings: Findings) -> None:
    remedies = {
        "planar": "write two prismatic joints and a continuous one, with an empty link between each",
        "floating": "only the joint between an empty root link and the rest of the robot can be floating",
    }
    text = f"joint {joint.name!r}: type {joint.type!r} is not supported"
    findings.add("S103", text, joint.element.place("type"), remedies[joint.type])


def _mimic(joint: UrdfJoint, joints: Mapping[str, UrdfJoint], findings: Findings) -> Mimic | None:
    """Return the mimic law of a joint; None if it has none, or after an error.

    It is an error if the leader is not a moving joint, if the leader mimics this joint, or if the law is not numeric.
    """
    element = joint.element.first("mimic")
    if element is None or not joint.moves:
        return None
    leader, span = element.get("joint"), element.place("joint")
    multiplier, offset = numbers(element.get("multiplier", "1"), 1), numbers(element.get("offset", "0"), 1)
    if leader not in joints or not joints[leader].moves:
        near = did_you_mean(leader, joints) or listing((j.name for j in joints.values() if j.moves), "moving joints")
        findings.add("S103", f"joint {joint.name!r} mimics {leader!r}, which is not a moving joint", span, near)
    elif multiplier is None or offset is None:
        findings.add("S103", f"joint {joint.name!r}: multiplier and offset of <mimic> must be numbers", element.span)
    elif _follows(leader, joint.name, joints):
        findings.add("S103", f"joint {joint.name!r} mimics itself", span)
    else:
        return Mimic(leader, multiplier[0], offset[0], element)
    return None


def _follows(follower: str, leader: str, joints: Mapping[str, UrdfJoint]) -> bool:
    """Return whether joint `follower` mimics joint `leader`, directly or through further joints."""
    seen: set[str] = set()
    while follower not in seen:
        if follower == leader:
            return True
        seen.add(follower)
        element = joints[follower].element.first("mimic") if follower in joints else None
        follower = element.get("joint") if element is not None else follower
    return False
