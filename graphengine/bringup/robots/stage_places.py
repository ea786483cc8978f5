"""Finds the places of a USD stage's robots in a scene, and the prim paths that differ there from those of the stage."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from graphengine.bringup.robots.import_robot import Imported
from graphengine.descriptions.usd.articulations import Articulation, common_ancestor
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.prim_paths import at_or_below, prim_name
from graphengine.physics.model.robot_prims import add_robot

_WORLD = "/World"


def robot_path(tree: Articulation, trees: Sequence[Articulation], name: str) -> str:
    """Return the path of the prim for a robot in a scene: the prim around its bodies, which is no body itself.

    Args:
        tree: bodies of the robot.
        trees: all robots of the stage.
        name: name of the robot, for a robot around which no prim is of its own.
    """
    bodies = [path for path in tree.bodies if path]
    path = common_ancestor([tree.prim, *bodies])
    others = [body for each in trees if each is not tree for body in each.bodies if body]
    above = path.rpartition("/")[0]
    if path in bodies and above and above != _WORLD and not any(at_or_below(body, above) for body in others):
        path = above
    crowded = any(at_or_below(body, path) for body in others)
    return f"{_WORLD}/{name}" if path in ("", _WORLD) or crowded else path


def moved_paths(imported: Imported, tree: Articulation, at: str) -> dict[str, str]:
    """Return the prim paths of a robot in its scene by their paths in the stage, if the scene does not find it by the latter.

    Args:
        imported: imported robot.
        tree: bodies of the robot in the stage.
        at: path of the robot's prim in the scene.
    """
    stage, robot = Stage(), imported.robot
    placed = replace(robot, placement=replace(robot.placement, prim_path=at))
    add_robot(stage, placed, (), Findings())
    found = dict.fromkeys(_around(tree), at)
    found |= dict(_prims(stage, imported, at))
    return {path: place for path, place in found.items() if path != place and path not in stage}


def _around(tree: Articulation) -> Iterator[str]:
    """Yield the paths of the prims around the root body that belong to the robot."""
    path = tree.root.rpartition("/")[0]
    while at_or_below(path, tree.prim) and path not in ("", _WORLD):
        yield path
        path = path.rpartition("/")[0]


def _prims(stage: Stage, imported: Imported, at: str) -> Iterator[tuple[str, str]]:
    """Yield pairs of the path in the stage and in the scene for links, joints and sensors."""
    usd = imported.robot.description.usd
    assert usd is not None
    links = {str(prim.facts["link"]): prim.path for prim in stage.prims("link")}
    for name, path in usd.paths.items():
        joint = f"{at}/Physics/{prim_name(name)}"
        if name in links or joint in stage:
            yield path, links.get(name, joint)
    for name, sensor in usd.sensors.items():
        mounts = [child for child in stage.find(links[sensor.body]).children.values() if child.name.startswith(name)]
        devices = [prim for mount in mounts[:1] for prim in mount.descendants() if prim.kind == sensor.type]
        if devices:
            yield sensor.path, devices[0].path
