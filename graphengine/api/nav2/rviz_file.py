"""Generates the RViz configuration for a robot that Nav2 drives: displays for map, robot, scans, costmaps and plan."""

from __future__ import annotations

from typing import Any

import yaml

from graphengine.api.nav2.robot_facts import MAP_FRAME, RobotFacts

_RVIZ = "rviz_default_plugins"


DESCRIPTION = "robot_description"
"""Topic of the robot description, in the namespace of the robot."""


def rviz_file(robot: RobotFacts) -> str:
    """Return the content of view.rviz."""
    topic = robot.topic
    x, y, _ = robot.pose
    displays: list[dict[str, Any]] = [
        {"Class": f"{_RVIZ}/Grid", "Name": "Grid", "Enabled": True, "Plane Cell Count": 20, "Alpha": 0.3},
        _map("Map", topic("map"), "map", 1.0),
        _map("Global costmap", topic("global_costmap/costmap"), "costmap", 0.3),
        _map("Local costmap", topic("local_costmap/costmap"), "costmap", 0.6),
        *(_scan(scan.topic, number) for number, scan in enumerate(robot.scans)),
        _path("Plan", topic("plan"), "255; 0; 0"),
        _path("Local plan", topic("local_plan"), "0; 12; 255"),
        {
            "Class": f"{_RVIZ}/Polygon",
            "Name": "Footprint",
            "Enabled": True,
            "Color": "25; 255; 0",
            "Topic": _topic(topic("local_costmap/published_footprint")),
        },
        {
            "Class": "nav2_rviz_plugins/ParticleCloud",
            "Name": "AMCL particles",
            "Enabled": True,
            "Color": "0; 180; 0",
            "Topic": _topic(topic("particle_cloud"), reliability="Best Effort"),
        },
        {
            "Class": f"{_RVIZ}/Odometry",
            "Name": "Odometry",
            "Enabled": False,
            "Keep": 1,
            "Topic": _topic(robot.odometry_topic),
        },
        {"Class": f"{_RVIZ}/TF", "Name": "TF", "Enabled": True, "Show Names": False, "Marker Scale": 0.5},
        {
            "Class": f"{_RVIZ}/RobotModel",
            "Name": "Robot",
            "Enabled": True,
            "Description Source": "Topic",
            "Description Topic": _topic(topic(DESCRIPTION), durability="Transient Local"),
        },
    ]
    tools = [
        {"Class": f"{_RVIZ}/MoveCamera"},
        {"Class": f"{_RVIZ}/Select"},
        {"Class": f"{_RVIZ}/Measure"},
        {"Class": f"{_RVIZ}/SetInitialPose", "Topic": _topic(topic("initialpose"))},
        {"Class": f"{_RVIZ}/SetGoal", "Topic": _topic(topic("goal_pose"))},
    ]
    content = {
        "Panels": [
            {"Class": "rviz_common/Displays", "Name": "Displays"},
            {"Class": "rviz_common/Views", "Name": "Views"},
            {"Class": "nav2_rviz_plugins/Navigation 2", "Name": "Navigation 2"},
        ],
        "Visualization Manager": {
            "Class": "",
            "Displays": displays,
            "Enabled": True,
            "Global Options": {"Background Color": "48; 48; 48", "Fixed Frame": MAP_FRAME, "Frame Rate": 30},
            "Name": "root",
            "Tools": tools,
            "Value": True,
            "Views": {
                "Current": {
                    "Class": f"{_RVIZ}/TopDownOrtho",
                    "Name": "Current View",
                    "Scale": 40,
                    "X": round(x, 3),
                    "Y": round(y, 3),
                }
            },
        },
        "Window Geometry": {"Width": 1400, "Height": 900},
    }
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True)


def _topic(name: str, *, reliability: str = "Reliable", durability: str = "Volatile") -> dict[str, Any]:
    return {
        "Depth": 5,
        "Durability Policy": durability,
        "History Policy": "Keep Last",
        "Reliability Policy": reliability,
        "Value": name,
    }


def _map(name: str, topic: str, colours: str, alpha: float) -> dict[str, Any]:
    return {
        "Class": f"{_RVIZ}/Map",
        "Name": name,
        "Enabled": True,
        "Alpha": alpha,
        "Color Scheme": colours,
        "Draw Behind": colours == "map",
        "Topic": _topic(topic, durability="Transient Local"),
        "Update Topic": _topic(f"{topic}_updates"),
    }


def _scan(topic: str, number: int) -> dict[str, Any]:
    return {
        "Class": f"{_RVIZ}/LaserScan",
        "Name": f"Scan {number or ''}".strip(),
        "Enabled": True,
        "Color Transformer": "FlatColor",
        "Color": "255; 80; 80",
        "Size (Pixels)": 3,
        "Style": "Points",
        "Topic": _topic(topic, reliability="Best Effort"),
    }


def _path(name: str, topic: str, colour: str) -> dict[str, Any]:
    return {"Class": f"{_RVIZ}/Path", "Name": name, "Enabled": True, "Color": colour, "Topic": _topic(topic)}
