"""Finds the robots of a stage: bodies that joints connect, as trees."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from graphengine.descriptions.usd_model import PhysicsContents, StageBody, StageJoint
from graphengine.format.prim_paths import at_or_below

MOVING = ("revolute", "prismatic")
_LIGHT = 0.01
"""Fraction of the mass of all bodies up to which a body at a disabled joint stays where it is."""


@dataclass(frozen=True, slots=True, eq=False)
class TreeJoint:
    """A joint of a tree; `turned` is whether its body 1 carries its body 0."""

    joint: StageJoint
    turned: bool

    @property
    def ends(self) -> tuple[str, str]:
        """Paths of the parent and the child."""
        one, other = self.joint.bodies
        return (other, one) if self.turned else (one, other)


@dataclass(slots=True, eq=False)
class Articulation:
    """Bodies that joints connect.

    Attributes:
        root: path of the root body; empty for the world, if a moving joint fastens a body to it.
        bodies: paths of all bodies, parents before their children.
        joints: joints between them, in the order of the children.
        loops: joints that would close a loop.
        prim: path of the prim that stands for the whole: that with ArticulationRootAPI, else the common ancestor.
        marked: whether a prim of it has ArticulationRootAPI.
        holder: joint that fixes the root to the world; None if it is free or the world itself.
    """

    root: str
    bodies: list[str] = field(default_factory=list)
    joints: list[TreeJoint] = field(default_factory=list)
    loops: list[StageJoint] = field(default_factory=list)
    prim: str = ""
    marked: bool = False
    holder: StageJoint | None = None

    @property
    def moves(self) -> bool:
        """Whether one of its joints moves."""
        return any(each.joint.kind in MOVING for each in self.joints)


def articulations(contents: PhysicsContents) -> list[Articulation]:
    """Return the groups of connected bodies of a stage, in stage order; a body without joints is a group alone."""
    holding = [joint for joint in contents.joints.values() if _holds(joint, contents)]
    beside: dict[str, list[StageJoint]] = {path: [] for path in contents.bodies}
    for joint in holding:
        for path in {*joint.bodies} - {""}:
            beside[path].append(joint)
    found: list[Articulation] = []
    taken: set[str] = set()
    for path in contents.bodies:
        if path not in taken:
            group = list(_connected(path, beside))
            taken.update(group)
            found.append(_tree(group, beside, contents))
    return found


def _holds(joint: StageJoint, contents: PhysicsContents) -> bool:
    """Return whether a joint holds bodies together.

    A disabled fixed joint to a light body counts too: users disable such joints of links that are only frames.
    """
    if joint.bodies[0] == joint.bodies[1]:
        return False
    light = _LIGHT * sum(body.mass for body in contents.bodies.values())
    ends = [contents.bodies[path] for path in joint.bodies if path]
    return joint.enabled or (joint.kind == "fixed" and any(is_light(body, light) for body in ends))


def is_light(body: StageBody, light: float) -> bool:
    """Return whether a body has at most a given mass, kg, also by its shapes."""
    return body.mass <= light if body.mass else not (body.density or any(shape.solid for shape in body.shapes))


def _connected(start: str, beside: dict[str, list[StageJoint]]) -> Iterator[str]:
    pending, seen = deque([start]), {start}
    while pending:
        path = pending.popleft()
        yield path
        for joint in beside[path]:
            for other in joint.bodies:
                if other and other not in seen:
                    seen.add(other)
                    pending.append(other)


def _tree(group: list[str], beside: dict[str, list[StageJoint]], contents: PhysicsContents) -> Articulation:
    """Return the tree of a group of bodies; joints that would close a loop are left out."""
    joints = list({joint.path: joint for path in group for joint in beside[path]}.values())
    order = {path: index for index, path in enumerate(contents.joints)}
    joints.sort(key=lambda joint: order[joint.path])
    holders = [joint for joint in joints if "" in joint.bodies and joint.enabled]
    marks = [
        root for root in contents.roots if any(at_or_below(path, root) for path in group) or root in _paths(joints)
    ]
    tree = Articulation(_root(group, joints, holders, marks), marked=bool(marks))
    tree.prim = marks[0] if marks and marks[0] not in _paths(joints) else common_ancestor(group)
    tree.holder = next((joint for joint in holders if tree.root in joint.bodies), None) if tree.root else None
    seen = {tree.root}
    for loose in (False, True):  # joints outside of articulations only where nothing else connects
        level = list(seen)
        for path in level:
            for joint in joints:
                if path not in joint.bodies or ("" in joint.bodies and tree.root) or (not joint.in_tree and not loose):
                    continue
                other = joint.bodies[joint.bodies[0] == path]
                if other not in seen:
                    seen.add(other)
                    level.append(other)
                    tree.joints.append(TreeJoint(joint, turned=joint.bodies[1] == path))
    used = {each.joint.path for each in tree.joints}
    tree.loops = [joint for joint in joints if joint.path not in used and joint is not tree.holder]
    tree.bodies = [tree.root, *(each.ends[1] for each in tree.joints)]
    return tree


def _root(group: list[str], joints: list[StageJoint], holders: list[StageJoint], marks: list[str]) -> str:
    """Return the root: a body on the world, the world, a marked body, the only one that is no child, or one of most joints."""
    for joint in holders:
        if joint.kind not in MOVING:
            return joint.bodies[0] or joint.bodies[1]
    if holders:
        return ""
    for path in group:
        if path in marks:
            return path
    children = {joint.bodies[1] for joint in joints}
    tops = [path for path in group if path not in children]
    return tops[0] if len(tops) == 1 else max(group, key=lambda path: sum(path in joint.bodies for joint in joints))


def _paths(joints: Iterable[StageJoint]) -> set[str]:
    return {joint.path for joint in joints}


def common_ancestor(paths: Iterable[str]) -> str:
    """Return the path of the nearest prim that contains all prims with the given paths; one of them if it contains the others."""
    parts = [path.split("/") for path in paths]
    shared = []
    for level in zip(*parts, strict=False):
        if len(set(level)) > 1:
            break
        shared.append(level[0])
    return "/".join(shared)
