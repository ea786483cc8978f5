"""Adds the drives, materials, sensors and names of a robot in a stage to its model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict, replace

import numpy as np

from graphengine.descriptions.usd.articulations import TreeJoint, is_light
from graphengine.descriptions.usd.usd_links import UsdLinks
from graphengine.descriptions.usd_model import (
    PhysicsContents,
    StageCommand,
    StageDrive,
    StageMaterial,
    StatedDrive,
    UsdModel,
)
from graphengine.devices.rotation import compose, relative, rotate, unrotate
from graphengine.format.prim_paths import at_or_below, prim_name


def add_settings(model: UsdModel, contents: PhysicsContents, made: UsdLinks) -> None:
    """Add what a stage says about a robot beyond its links and joints.

    Args:
        model: model of the robot; changed in place.
        contents: physics of the stage.
        made: links and joints of the robot.
    """
    tree = made.tree
    moving = {joint.name for joint in made.joints if joint.moves}
    for each in tree.joints:
        name = made.names[each.joint.path]
        if name in moving:
            model.drives[name] = _drive(each, name, contents, made)
    model.self_collision = any(contents.roots[root] for root in contents.roots if at_or_below(tree.root, root))
    paths = [path for path in tree.bodies if path]
    model.articulation_root = _articulation_root(contents, made)
    model.weightless = [made.names[path] for path in paths if not contents.bodies[path].gravity]
    _materials(model, contents, made)
    _sensors(model, contents, made)
    for path, text in contents.names.items():
        if path in made.frames:
            model.overrides[made.names[path]] = text
    for path, text in contents.namespaces.items():
        if path in made.frames or path == tree.prim:
            model.namespaces[made.names.get(path, "")] = text
    model.remarks = [(lost, path, text, made.spans.of(path)) for lost, path, text in made.remarks]


def _articulation_root(contents: PhysicsContents, made: UsdLinks) -> str:
    """Return the name of the first link that is more than a frame, below disabled joints; empty if it is the root itself."""
    root = made.tree.root
    while root and is_light(contents.bodies[root], 0.0):
        loose = [each.ends[1] for each in made.tree.joints if each.ends[0] == root and not each.joint.enabled]
        if len(loose) != 1:
            break
        root = loose[0]
    return made.names[root] if root != made.tree.root else ""


def _drive(each: TreeJoint, name: str, contents: PhysicsContents, made: UsdLinks) -> StatedDrive:
    """Return what a stage says about the drive of a joint, including the commands of its graphs."""
    joint, drive = each.joint, each.joint.drive or StageDrive()
    inertia = _inertia(each, made) if drive.acceleration else 1.0
    stated = StatedDrive(**asdict(drive), armature=joint.armature, start=made.starts.get(name, 0.0))
    stated.stiffness, stated.damping = drive.stiffness * inertia, drive.damping * inertia
    for command in contents.commands:
        if _commands(command, joint.path, name, made):
            stated.controllers.append(command.path)
            stated.commands += [kind for kind in command.kinds if kind not in stated.commands]
    return stated


def _commands(command: StageCommand, path: str, name: str, made: UsdLinks) -> bool:
    """Return whether a controller commands a joint: it names the joint, or no joints at all, and its target is of this robot."""
    override = made.contents.names.get(path, "")
    if command.joints and not {name, path.rpartition("/")[2], override} & set(command.joints):
        return False
    target, bodies = command.target, made.tree.bodies
    return not target or any(at_or_below(each, target) or at_or_below(target, each) for each in (*bodies, path))


def _inertia(each: TreeJoint, made: UsdLinks) -> float:
    """Return the inertia (kg m2 or kg) of the links beyond a joint about or along its axis, in the positions of the stage."""
    beyond = {each.ends[1]}
    for other in made.tree.joints:
        if other.ends[0] in beyond:
            beyond.add(other.ends[1])
    origin, turn = each.joint.frames[0]
    axis, total = rotate(turn, each.joint.axis), 0.0
    for path, link in zip(made.tree.bodies, made.links, strict=True):
        if path not in beyond or link.inertial is None:
            continue
        place, spin = compose(made.frame_in_world(path), link.inertial.pose)
        arm, along = np.cross(axis, np.subtract(place, origin)), np.square(unrotate(spin, axis))
        turning = link.mass * arm @ arm + np.array((link.inertial.moments or (0.0,) * 6)[:3]) @ along
        total += link.mass if each.joint.kind == "prismatic" else float(turning)
    return total or 1.0


def _materials(model: UsdModel, contents: PhysicsContents, made: UsdLinks) -> None:
    """Add the physics materials of links; a link has that of its first collider with one."""
    bound: dict[str, list[str]] = {}
    for path in filter(None, made.tree.bodies):
        solid = [shape for shape in contents.bodies[path].shapes if shape.solid]
        found = list(dict.fromkeys(shape.material for shape in solid if shape.material))
        if found:
            bound.setdefault(found[0], []).append(made.names[path])
        if len(found) > 1:
            made.remarks.append((True, path, f"of its {len(found)} physics materials only {found[0]} is used"))
    for name, path in _unique(bound):
        model.materials[name] = contents.materials[path], [link for link in bound[path] if link not in made.balls]
    if made.balls:
        model.materials["balls"] = StageMaterial(combine="min"), made.balls


def _sensors(model: UsdModel, contents: PhysicsContents, made: UsdLinks) -> None:
    """Add the sensors of links; one that is alone below a prim of a link has the name of that prim, which graphs address."""
    ours = {sensor.path: sensor for sensor in contents.sensors if sensor.body in made.frames and sensor.body}
    mounts = Counter(sensor.mount for sensor in ours.values())
    named = {sensor.mount if mounts[sensor.mount] == 1 else path: sensor for path, sensor in ours.items()}
    for name, path in _unique(named):
        sensor = named[path]
        pose = relative(made.frame_in_world(sensor.body), sensor.pose)
        model.sensors[name] = replace(sensor, body=made.names[sensor.body], pose=pose)


def _unique(paths: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield a legal name for each path, and the path."""
    taken: set[str] = set()
    for path in paths:
        name = prim_name(path.rpartition("/")[2])
        while name in taken:
            name += "_"
        taken.add(name)
        yield name, path
