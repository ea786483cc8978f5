"""Generates the launch files, the RViz configuration and the README from their templates."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import yaml

from graphengine.bringup.nav2.robot_facts import RobotFacts
from graphengine.format.templates import filled

TEMPLATES = Path(__file__).with_name("templates")


def robot_launch(robot: RobotFacts, scene: str, *, slam: bool, in_fleet: bool) -> str:
    """Return the content of the launch file that starts Nav2 for one robot.

    Args:
        robot: properties of the robot.
        scene: name of the scene.
        slam: whether slam_toolbox builds the map; otherwise, map_server loads a map file.
        in_fleet: whether the map file is in the parent folder, because several robots share it.
    """
    return filled(
        TEMPLATES / "robot_launch.txt",
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
    return filled(TEMPLATES / "fleet_launch.txt", {"slam": slam}, scene=_plain(scene), robots=names)


def rviz_file(robot: RobotFacts) -> str:
    """Return the content of view.rviz, with displays for map, robot, scans, costmaps and plan."""
    x, y, _ = robot.pose
    scans = [
        filled(TEMPLATES / "scan_display.txt", number=f" {number}" if number else "", topic=json.dumps(scan.topic))
        for number, scan in enumerate(robot.scans)
    ]
    text = filled(
        TEMPLATES / "view_rviz.txt",
        namespace=robot.topic("").removesuffix("/"),
        odometry=json.dumps(robot.odometry_topic),
        scans="".join(scans),
        x=f"{x:.3f}",
        y=f"{y:.3f}",
    )
    return yaml.safe_dump(yaml.safe_load(text), sort_keys=False, allow_unicode=True)


def readme_file(scene: str, robots: Sequence[RobotFacts], *, slam: bool, robot_state: bool, described: bool) -> str:
    """Return the text of the README of a folder with Nav2 files.

    Args:
        scene: name of the scene.
        robots: properties of the robots for which the folder has files.
        slam: whether slam_toolbox builds the map.
        robot_state: whether the simulation has to run with `--robot-state`.
        described: whether the run publishes the descriptions of all robots.
    """
    return filled(
        TEMPLATES / "readme.txt",
        {"slam": slam, "fleet": len(robots) > 1, "described": described},
        robots=", ".join(robot.name for robot in robots),
        scene=scene,
        run=f"graphrun run SCENE{' --robot-state' if robot_state else ''}",
        goal=robots[0].topic("goal_pose"),
        map=robots[0].topic("map"),
    )


def _plain(name: str) -> str:
    """Return the name of a scene for a docstring, with `_` in place of unusual characters such as quotes."""
    return "".join(character if character.isalnum() or character in "_-. " else "_" for character in name)
