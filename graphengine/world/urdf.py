"""URDF as plain data: links, joints and the tree they form.

Read are `link`, `joint` and `material`; what other programs keep in a description (gazebo, ros2_control, transmission) stays
in the text for robot_state_publisher and goes no further.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.context import Vector3
from graphengine.diagnostics import Findings, did_you_mean, listing
from graphengine.rotation import Pose, compose, from_rpy, rotate
from graphengine.world.poses import NOWHERE
from graphengine.world.xmlfile import Element, numbers, read

MOVING = ("revolute", "continuous", "prismatic")
MAX_LINKS = 2000


@dataclass(slots=True, eq=False)
class Link:
    """A link; mass in kg."""

    name: str
    element: Element
    mass: float
    carrier: Joint | None = None
    """The joint that fastens it to its parent; None for the root."""
    below: list[Joint] = field(default_factory=list)
    """The joints that fasten its children, in order of the file."""

    @property
    def colliders(self) -> list[Element]:
        """Its `collision` elements."""
        return self.element.all("collision")


@dataclass(slots=True, eq=False)
class Joint:
    """A joint. Its pose is that of the child link in the parent link while the joint is at zero."""

    name: str
    type: str
    parent: str
    child: str
    pose: Pose
    axis: Vector3
    element: Element

    @property
    def moves(self) -> bool:
        """Whether it has a degree of freedom."""
        return self.type in MOVING

    def put(self, position: Vector3) -> None:
        """Give the joint another origin, m, in the element too."""
        self.pose = (position, self.pose[1])
        origin = self.element.first("origin")
        if origin is None:
            origin = Element("origin", {}, self.element.span)
            self.element.children.insert(0, origin)
        origin.attributes["xyz"] = " ".join(map(repr, position))


@dataclass(slots=True, eq=False)
class Urdf:
    """A robot description whose links form one tree."""

    path: Path
    element: Element
    links: dict[str, Link]
    joints: dict[str, Joint]
    root: str

    @property
    def mass(self) -> float:
        """Of all links, kg."""
        return sum(link.mass for link in self.links.values())

    def depth_first(self, start: str = "") -> Iterator[Link]:
        """A link, the root unless told, and all below it, parents first."""
        pending = [self.links[start or self.root]]
        while pending:
            link = pending.pop()
            yield link
            pending.extend(self.links[joint.child] for joint in reversed(link.below))

    def moving(self) -> list[Joint]:
        """The joints with a degree of freedom, breadth first from the root: PhysX's order of an articulation."""
        links = [self.links[self.root]]
        for link in links:
            links.extend(self.links[joint.child] for joint in link.below)
        return [link.carrier for link in links if link.carrier is not None and link.carrier.moves]

    def pose_in_root(self, link: str) -> Pose:
        """Pose of a link in the root link, all joints at zero."""
        pose, carrier = NOWHERE, self.links[link].carrier
        while carrier is not None:
            pose = compose(carrier.pose, pose)
            carrier = self.links[carrier.parent].carrier
        return pose

    def wheel(self, joint: Joint) -> tuple[float, Vector3] | None:
        """Radius (m) and centre in the root link of what rolls: a sphere, or a cylinder about the joint's axis."""
        if joint.type != "continuous":
            return None
        for collider in self.links[joint.child].colliders:
            shape, pose = shape_of(collider), origin_of(collider) or NOWHERE
            radius = numbers(shape.get("radius"), 1) if shape is not None else None
            if shape is None or radius is None:
                continue
            cosine = sum(a * b for a, b in zip(rotate(pose[1], (0.0, 0.0, 1.0)), joint.axis, strict=True))
            if shape.tag == "sphere" or (shape.tag == "cylinder" and abs(cosine) > 0.99):
                return radius[0], compose(self.pose_in_root(joint.child), pose)[0]
        return None


def shape_of(element: Element) -> Element | None:
    """The `box`, `cylinder`, `sphere` or `mesh` of a collision or visual."""
    geometry = element.first("geometry")
    return geometry.children[0] if geometry is not None and geometry.children else None


def origin_of(element: Element) -> Pose | None:
    """The pose in an element's `origin`; None if it is not made of numbers."""
    origin = element.first("origin")
    if origin is None:
        return NOWHERE
    position, angles = numbers(origin.get("xyz", "0 0 0"), 3), numbers(origin.get("rpy", "0 0 0"), 3)
    if position is None or angles is None:
        return None
    return (position[0], position[1], position[2]), from_rpy(*angles)


def load(path: Path, findings: Findings) -> Urdf | None:
    """Read a description; what is wrong with it goes to `findings`."""
    root = read(path, findings, "S103")
    if root is None:
        return None
    if root.tag != "robot":
        findings.add("S103", f"a robot description begins with <robot>, not <{root.tag[:40]}>", root.span)
        return None
    foreign = next((element for element in root.walk() if element.tag.startswith("xacro:")), None)
    if foreign is not None:
        findings.add("S103", "this is xacro, not yet URDF", foreign.span, "run: xacro robot.urdf.xacro > robot.urdf")
        return None
    before = len(findings.errors)
    links: dict[str, Link] = {}
    for element in _named(root, "link", findings):
        links[element.get("name")] = _link(element, findings)
    joints: dict[str, Joint] = {}
    for element in _named(root, "joint", findings):
        joint = _joint(element, links, findings)
        if joint is not None:
            joints[joint.name] = joint
    top = _tree(root, links, findings) if len(findings.errors) == before else ""
    return Urdf(path, root, links, joints, top) if top else None


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


def _link(element: Element, findings: Findings) -> Link:
    inertial = element.first("inertial")
    weight = inertial.first("mass") if inertial is not None else None
    mass = numbers(weight.get("value"), 1) if weight is not None else (0.0,)
    if mass is None or mass[0] < 0:
        assert weight is not None
        findings.add("S103", f"mass {weight.get('value')!r} is not a number of kg", weight.place("value"))
    return Link(element.get("name"), element, mass[0] if mass else 0.0)


def _joint(element: Element, links: dict[str, Link], findings: Findings) -> Joint | None:
    name, kind = element.get("name"), element.get("type")
    if kind not in (*MOVING, "fixed"):
        near = did_you_mean(kind, MOVING) or listing((*MOVING, "fixed"))
        findings.add("S103", f"joint {name!r}: type {kind!r} cannot be simulated", element.place("type"), near)
        return None
    ends: list[Link] = []
    for tag in ("parent", "child"):
        end = element.first(tag)
        link = end.get("link") if end is not None else ""
        if end is None or link not in links:
            span = end.place("link") if end is not None else element.span
            near = did_you_mean(link, links) or listing(links, "links")
            findings.add("S103", f"joint {name!r}: no {tag} link {link!r}", span, near)
            return None
        ends.append(links[link])
    axis_element = element.first("axis")
    axis = numbers(axis_element.get("xyz", "1 0 0") if axis_element is not None else "1 0 0", 3)
    pose, length = origin_of(element), math.hypot(*axis) if axis else 0.0
    if pose is None or axis is None or (length == 0 and kind != "fixed"):
        findings.add("S103", f"joint {name!r}: origin and axis must be made of three numbers each", element.span)
        return None
    direction = (axis[0] / length, axis[1] / length, axis[2] / length) if length else (1.0, 0.0, 0.0)
    parent, child = ends
    if child.carrier is not None:
        first = (child.carrier.element.span, "first here")
        findings.add("S103", f"link {child.name!r} has two parents", element.span, related=[first])
        return None
    joint = Joint(name, kind, parent.name, child.name, pose, direction, element)
    parent.below.append(joint)
    child.carrier = joint
    return joint


def _tree(root: Element, links: dict[str, Link], findings: Findings) -> str:
    """Name of the root link, if all links hang together."""
    tops = [link for link in links.values() if link.carrier is None]
    if len(tops) != 1:
        what = listing([link.name for link in tops], "links without a parent") if links else ""
        findings.add("S103", "the links do not form one tree", root.span, what, "fasten them with joints")
        return ""
    reached = [tops[0]]
    for link in reached:
        reached.extend(links[joint.child] for joint in link.below)
    if len(reached) != len(links):
        lost = listing(links.keys() - {link.name for link in reached}, "in a ring of joints")
        findings.add("S103", "the links do not form one tree", root.span, lost)
        return ""
    return tops[0].name
