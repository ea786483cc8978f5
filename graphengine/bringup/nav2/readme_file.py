"""The README in the folder that `graphrun nav2 files` writes."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.bringup.nav2.robot_facts import RobotFacts
from graphengine.bringup.nav2.templates import filled


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
        "readme.txt",
        {"slam": slam, "fleet": len(robots) > 1, "described": described},
        robots=", ".join(robot.name for robot in robots),
        scene=scene,
        run=f"graphrun run SCENE{' --robot-state' if robot_state else ''}",
        goal=robots[0].topic("goal_pose"),
        map=robots[0].topic("map"),
    )
