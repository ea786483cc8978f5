"""Expands the `robots` of a scene to single robots, each with name, pose and namespace."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from graphengine.devices.rotation import Pose, compose, from_orientation
from graphengine.format.diagnostics import Findings
from graphengine.format.legal_names import NAMESPACE_FIELD
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec import RobotUse
from graphengine.format.spec_reader import Loaded


@dataclass(frozen=True, slots=True)
class RobotPlacement:
    """A robot to add to a scene.

    Attributes:
        name: name of the robot in the scene.
        prim_path: path of the robot's prim.
        key: key in `robots` of the scene file; empty for robots that are added later.
        use: value of that key.
        pose: pose of the robot's base link in the world.
        namespace: namespace of the robot's base link; None if the namespace of the robot file applies.
    """

    name: str
    prim_path: str
    key: str
    use: RobotUse
    pose: Pose
    namespace: str | None


def placements(scene: Loaded[SceneSpec], findings: Findings) -> list[RobotPlacement]:
    """Return the robots of a scene in order of the file; errors for names and namespaces used twice are added to `findings`."""
    found: dict[str, RobotPlacement] = {}
    for key, use in scene.spec.robots.items():
        for placement in place(key, use):
            name, span = placement.name, scene.document.key_span("robots", key)
            if placement.prim_path == "/World":
                findings.add("S105", "a robot cannot be named 'World': that path is used by the world", span)
            elif name in found:
                other = (scene.document.key_span("robots", found[name].key), "the other one")
                findings.add("S105", f"two robots are named {name!r}", span, related=[other])
            else:
                found[name] = placement
        size, shared = use.count or len(use.places or ()), use.namespace
        if size > 1 and shared is not None and not NAMESPACE_FIELD.search(shared):
            text = f"{size} robots would share the namespace {shared!r}"
            span = scene.document.span("robots", key, "namespace")
            findings.add("S105", text, span, "write the namespace with {name} or {index:04}")
    return list(found.values())


def place(key: str, use: RobotUse) -> Iterator[RobotPlacement]:
    """Yield the robots of one entry in `robots` of a scene: one robot, or all robots of a fleet."""
    start: Pose = (use.position, from_orientation(use.orientation))
    at = use.at or f"/{key}"
    if use.count is None and use.places is None:
        yield RobotPlacement(key, at, key, use, start, _fill(use.namespace, key, 0))
        return
    for index, pose in enumerate(_poses(use, start)):
        name, path = f"{key}_{index:04}", f"{at}_{index:04}"
        namespace = _fill("{name}" if use.namespace is None else use.namespace, name, index)
        yield RobotPlacement(name, path, key, use, pose, namespace)


def _poses(use: RobotUse, start: Pose) -> Iterator[Pose]:
    if use.places is not None:
        yield from (compose(start, (one.position, from_orientation(one.orientation))) for one in use.places)
        return
    (x, y, z), orientation = start
    count = use.count or 1
    along, across = use.spacing or (0.0, 0.0)
    per_row = use.per_row or count
    for index in range(count):
        row, column = divmod(index, per_row)
        yield (x + column * along, y + row * across, z), orientation


def _fill(pattern: str | None, name: str, index: int) -> str | None:
    """Replace the fields of a namespace pattern by the robot's name or by the robot's index in the fleet."""
    if pattern is None:
        return None
    return NAMESPACE_FIELD.sub(lambda field: name if field[1] == "name" else f"{index:0{field[2] or 1}}", pattern)
