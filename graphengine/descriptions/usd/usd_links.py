"""Makes links and joints of the bodies and joints of an articulation.

As in URDF, the origin of a link is at its joint. The axes of a link stay those of its prim.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.robot_description import WORLD, Bounds, Joint, Link, Mimic
from graphengine.descriptions.shapes import Box, Capsule, Cylinder, Geometry, Mesh, Shape, Sphere
from graphengine.descriptions.usd.articulations import MOVING, Articulation, TreeJoint
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.descriptions.usd_model import PhysicsContents, StageBody, StageShape
from graphengine.devices.rotation import IDENTITY, NOWHERE, Pose, compose, relative, rotate, tilt_of
from graphengine.format.diagnostics import Span
from graphengine.format.wording import printable

_SIDEWAYS = math.radians(30.0)
"""Tilt of a root body above which its axes are not those of a robot, rad."""
_NEAR = 1e-9
"""Distance of a joint from the origin of a body below which they are at the same place, m."""
_CENTRED = 1e-3
"""Distance of a ball's centre from its joint up to which it turns in place, m."""
_STILL = 1e-3
"""Position of a joint in the stage below which it counts as zero, rad or m."""


@dataclass(slots=True, eq=False)
class UsdLinks:
    """The links and joints of one articulation.

    Attributes:
        contents: physics of the stage.
        tree: articulation.
        spans: places of the prims.
        links: links in order of the tree.
        joints: joints in the same order.
        bodies: bodies by path; an empty path stands for the world.
        meshes: reference to each mesh of the stage.
        names: names of links and joints, by path of their prim.
        frames: pose of each link's frame in the frame of its body, by path of the body.
        starts: position of each moving joint in the stage, rad or m, by name.
        balls: names of links that are balls at spherical joints, which become fixed.
        remarks: remarks on parts that are changed or not simulated: whether lost, path of the prim, and text.
    """

    contents: PhysicsContents
    tree: Articulation
    spans: PrimSpans
    meshes: list[str]
    links: list[Link] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    bodies: dict[str, StageBody] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    frames: dict[str, Pose] = field(default_factory=dict)
    starts: dict[str, float] = field(default_factory=dict)
    balls: list[str] = field(default_factory=list)
    remarks: list[tuple[bool, str, str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        tree = self.tree
        bodies = self.bodies = {**self.contents.bodies, "": StageBody("", NOWHERE)}
        self.names = named(tree.bodies) | named(each.joint.path for each in tree.joints)
        root = bodies[tree.root]
        self.frames[tree.root] = NOWHERE
        if not tree.root:
            holder = tree.joints[0]
            self.frames[""] = holder.joint.frames[holder.turned][0], IDENTITY
        elif tilt_of(root.pose[1]) > _SIDEWAYS:
            self.frames[tree.root] = relative(root.pose, (root.pose[0], IDENTITY))
            self.remarks.append((False, tree.root, "its axes are turned, so that its z axis points up"))
        for each in tree.joints:
            self.frames[each.ends[1]] = self._at_joint(each)
        for path in tree.bodies:
            self.links.append(self._link(bodies[path]))
        for each in tree.joints:
            self.joints.append(self._joint(each))
        if tree.holder is not None and tree.holder.kind != "fixed":
            text = f"{tree.holder.kind} joints are not simulated; it fixes the root link to the world"
            self.remarks.append((True, tree.holder.path, text))
        for joint in tree.loops:
            self.remarks.append((True, joint.path, "it would close a loop, and is left out"))

    def frame_in_world(self, path: str) -> Pose:
        """Return the pose in the stage of the frame of a body's link."""
        return compose(self.bodies[path].pose, self.frames[path])

    def _at_joint(self, each: TreeJoint) -> Pose:
        """Return the frame of the child link in the frame of its body: at the joint, with the axes of the body."""
        body = self.bodies[each.ends[1]]
        anchor = relative(body.pose, each.joint.frames[not each.turned])
        if each.joint.kind not in MOVING or math.hypot(*anchor[0]) < _NEAR:
            return NOWHERE
        self.remarks.append((False, body.path, "its origin is at its joint"))
        return anchor[0], IDENTITY

    def _link(self, body: StageBody) -> Link:
        name, frame = self.names[body.path], self.frame_in_world(body.path)
        element = Element("link", {"name": name}, self.spans.of(body.path))
        shapes: list[Shape] = []
        link = Link(name, element, None, shapes)
        for shape in body.shapes:
            tag = "collision" if shape.solid else "visual"
            span = self.spans.of(shape.path)
            geometry = geometry_of(shape, self.meshes, span)
            if geometry is None:
                self.remarks.append((True, shape.path, "a link cannot have an endless plane"))
                continue
            if shape.approximation in ("convexDecomposition", "sdf", "meshSimplification", "none"):
                self.remarks.append((False, shape.path, f"{shape.approximation}: the convex hull replaces it"))
            part = Element(tag, {"name": shape.path.rpartition("/")[2]}, span)
            pose = relative(frame, shape.pose)
            number = f"{name}.{len(shapes) + 1}"
            colour = None if shape.solid else shape.colour
            shapes.append(Shape(number, not shape.solid, geometry, pose, colour, part, span))
        return link

    def _joint(self, each: TreeJoint) -> Joint:
        """Return a joint of the tree; one of a type that is not simulated becomes fixed."""
        joint, bodies = each.joint, self.bodies
        parent, child = (bodies[path] for path in each.ends)
        at_parent, at_child = (
            relative(body.pose, joint.frames[end]) for body, end in ((parent, each.turned), (child, not each.turned))
        )
        zero = compose(at_parent, relative(at_child, NOWHERE))  # of the child's body on the parent's body
        kind = joint.kind
        if kind not in (*MOVING, "fixed"):
            kind, zero = "fixed", relative(parent.pose, child.pose)
            text = f"{joint.kind} joints are not simulated; it becomes fixed"
            if joint.kind == "spherical" and _is_ball(child, joint.frames[not each.turned]):
                self.balls.append(self.names[child.path])
                text += ", and its ball slides without friction"
            self.remarks.append((True, joint.path, text))
        if not joint.enabled:
            zero = relative(parent.pose, child.pose)
        pose = compose(compose(relative(self.frames[parent.path], NOWHERE), zero), self.frames[child.path])
        limited = joint.lower is not None
        kind = "continuous" if kind == "revolute" and not limited else kind
        name = self.names[joint.path]
        element = Element("joint", {"name": name, "type": kind}, self.spans.of(joint.path))
        made = Joint(name, kind, self.names[parent.path], self.names[child.path], pose, element)
        self.remarks += [(True, joint.path, text) for text in joint.remarks]
        if not made.moves:
            return made
        axis = rotate(at_child[1], joint.axis)
        made.stated_axis = (-axis[0], -axis[1], -axis[2]) if each.turned else axis
        if limited and joint.lower == joint.upper:
            made.type = element.attributes["type"] = "fixed"
            self.remarks.append((False, joint.path, "its limits lock it: it becomes fixed"))
            return made
        effort = joint.drive.max_force if joint.drive is not None else None
        made.bounds = Bounds(joint.lower, joint.upper, effort or 0.0, joint.max_velocity or 0.0, element)
        made.losses = joint.damping, joint.friction
        if (leader := self.contents.joints.get(joint.leader)) is not None and leader.path in self.names:
            made.mimic = Mimic(self.names[leader.path], joint.multiplier, joint.offset, element)
        start = joint.position if joint.position is not None else self._position(each, at_parent, at_child, made.type)
        self.starts[name] = 0.0 if abs(start) < _STILL or not limited else start
        return made

    def _position(self, each: TreeJoint, at_parent: Pose, at_child: Pose, kind: str) -> float:
        """Return the position of a joint in the stage, rad or m."""
        parent, child = (self.bodies[path] for path in each.ends)
        moved = compose(relative(at_parent, relative(parent.pose, child.pose)), at_child)
        x, y, z = each.joint.axis
        sign = -1.0 if each.turned else 1.0
        along = moved[0] if kind == "prismatic" else moved[1][:3]
        amount = sign * (along[0] * x + along[1] * y + along[2] * z)
        if kind == "prismatic":
            return amount
        angle = 2.0 * math.atan2(amount, moved[1][3])
        return math.remainder(angle, math.tau)


def geometry_of(shape: StageShape, meshes: Sequence[str], span: Span) -> Geometry | None:
    """Return the geometry of a shape; None for an endless plane.

    Args:
        shape: shape of the stage.
        meshes: reference to each mesh of the stage.
        span: place of the shape.
    """
    match shape.kind, shape.sizes:
        case "box", [x, y, z]:
            return Box((x, y, z))
        case "sphere", [radius]:
            return Sphere(radius)
        case "cylinder", [radius, length]:
            return Cylinder(radius, length)
        case "capsule", [radius, length]:
            return Capsule(radius, length)
        case "mesh", _:
            name = meshes[shape.mesh]
            return Mesh(name, (1.0, 1.0, 1.0), Element("mesh", {"filename": name}, span))
    return None


def _is_ball(body: StageBody, joint: Pose) -> bool:
    """Return whether all colliders of a body are spheres about a joint, as of a ball caster."""
    solid = [shape for shape in body.shapes if shape.solid]
    return bool(solid) and all(s.kind == "sphere" and math.dist(s.pose[0], joint[0]) < _CENTRED for s in solid)


def named(paths: Iterable[str]) -> dict[str, str]:
    """Return a name for each path: that of the prim, with the names of the prims above it where two would be equal."""
    paths = list(paths)
    found = {"": WORLD} if "" in paths else {}
    taken = set(found.values())
    for path in filter(None, paths):
        parts, count = path.strip("/").split("/"), 1
        while (name := printable("_".join(parts[-count:]))) in taken and count < len(parts):
            count += 1
        while name in taken:
            name += "_"
        taken.add(name)
        found[path] = name
    return found
