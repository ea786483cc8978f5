"""Generates the launch files that start Nav2."""

from __future__ import annotations

import json
from collections.abc import Sequence

from graphengine.bringup.nav2.robot_facts import RobotFacts
from graphengine.bringup.nav2.templates import filled


def robot_launch(robot: RobotFacts, scene: str, *, slam: bool, in_fleet: bool) -> str:
    """Return the content of the launch file that starts Nav2 for one robot.

    Args:
        robot: properties of the robot.
        scene: name of the scene.
        slam: whether slam_toolbox builds the map; otherwise, map_server loads a map file.
        in_fleet: whether the robot is one of several, which share a map file in the parent folder.
    """
    return filled(
        "robot_launch.txt",
        {"slam": slam},
        robot=robot.name,
        scene=_plain(scene),
        namespace=json.dumps(robot.namespace),
        tf=json.dumps(robot.tf_topic),
        tf_static=json.dumps(robot.tf_static_topic),
        map_folder="HERE.parent" if in_fleet else "HERE",
    )


def fleet_launch(robots: Sequence[RobotFacts], scene: str, *, slam: bool) -> str:
    """Return the content of the launch file that starts Nav2 for several robots; each robot has a folder with its name."""
    names = json.dumps([robot.name for robot in robots])
    return filled("fleet_launch.txt", {"slam": slam}, scene=_plain(scene), robots=names)


def _plain(name: str) -> str:
    """Return the name of a scene file with unusual characters, such as quotes, replaced; it is put into a docstring."""
    return "".join(character if character.isalnum() or character in "_-. " else "_" for character in name)
