"""Fills in the templates beside this module to make the launch files that start Nav2."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib.resources import files
from string import Template

from graphengine.api.nav2.robot_facts import RobotFacts

_AMCL = """\
        node("nav2_map_server", "map_server", {"yaml_filename": LaunchConfiguration("map")}),
        node("nav2_amcl", "amcl", condition=by_amcl),
        node(
            "nav2_lifecycle_manager",
            "lifecycle_manager",
            autostart,
            name="lifecycle_manager_localization",
            condition=by_amcl,
        ),
        node(  # `graphrun run --localization truth` publishes map -> odom
            "nav2_lifecycle_manager",
            "lifecycle_manager",
            autostart,
            {"node_names": ["map_server"]},
            name="lifecycle_manager_localization",
            condition=by_truth,
        ),
"""
_CONDITIONS = """\
    by_amcl = IfCondition(EqualsSubstitution(LaunchConfiguration("localization"), "amcl"))
    by_truth = UnlessCondition(EqualsSubstitution(LaunchConfiguration("localization"), "amcl"))
"""
_SLAM = """\
        node(
            "slam_toolbox",
            "async_slam_toolbox_node",
            name="slam_toolbox",
            remappings=[("/map", "map"), ("/map_metadata", "map_metadata")],
        ),
        node("nav2_lifecycle_manager", "lifecycle_manager", autostart, name="lifecycle_manager_localization"),
"""
_MAP_ARGUMENT = """\
        DeclareLaunchArgument("map", default_value=str($folder / "map.yaml"), description="map to load"),
        DeclareLaunchArgument(
            "localization",
            default_value="amcl",
            choices=["amcl", "truth"],
            description="truth: no AMCL; `graphrun run --localization truth` publishes the true pose of the robot",
        ),
"""


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
        robot=robot.name,
        scene=_plain(scene),
        namespace=json.dumps(robot.namespace),
        tf=json.dumps(robot.tf_topic),
        tf_static=json.dumps(robot.tf_static_topic),
        map_argument="" if slam else _MAP_ARGUMENT.replace("$folder", "HERE.parent" if in_fleet else "HERE"),
        conditions="" if slam else _CONDITIONS,
        localization=_SLAM if slam else _AMCL,
    )


def fleet_launch(robots: Sequence[RobotFacts], scene: str, *, slam: bool) -> str:
    """Return the content of the launch file that starts Nav2 for several robots; each robot has a folder with its name."""
    defaults = {"use_sim_time": '"true"'}
    defaults |= {"autostart": '"true"', "use_respawn": '"false"', "log_level": '"info"'}
    if not slam:
        defaults |= {"map": 'str(HERE / "map.yaml")', "localization": '"amcl"'}
    pairs = ", ".join(f'"{name}": {value}' for name, value in defaults.items())
    names = json.dumps([robot.name for robot in robots])
    return filled("fleet_launch.txt", scene=_plain(scene), robots=names, defaults=f"{{{pairs}}}")


def _plain(name: str) -> str:
    """Return the name of a scene file with unusual characters, such as quotes, replaced; it is put into a docstring."""
    return "".join(character if character.isalnum() or character in "_-. " else "_" for character in name)


def filled(template: str, **values: str) -> str:
    """Return the text of a template beside this module with its placeholders replaced."""
    text = files(__package__).joinpath(template).read_text(encoding="utf-8")
    return Template(text).substitute(values)
