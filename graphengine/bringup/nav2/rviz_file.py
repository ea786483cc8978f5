"""Generates the RViz configuration for a robot that Nav2 drives: displays for map, robot, scans, costmaps and plan."""

from __future__ import annotations

import json
from string import Template

import yaml

from graphengine.bringup.nav2.robot_facts import RobotFacts
from graphengine.bringup.nav2.templates import filled

_SCAN = Template(
    """\
  - Class: rviz_default_plugins/LaserScan
    Name: Scan$number
    Enabled: true
    Color Transformer: FlatColor
    Color: 255; 80; 80
    Size (Pixels): 3
    Style: Points
    Topic: {<<: *topic, Reliability Policy: Best Effort, Value: $topic}"""
)


def rviz_file(robot: RobotFacts) -> str:
    """Return the content of view.rviz."""
    x, y, _ = robot.pose
    scans = [
        _SCAN.substitute(number=f" {number}" if number else "", topic=json.dumps(scan.topic))
        for number, scan in enumerate(robot.scans)
    ]
    text = filled(
        "view_rviz.txt",
        namespace=robot.topic("").removesuffix("/"),
        odometry=json.dumps(robot.odometry_topic),
        scans="\n".join(scans),
        x=f"{x:.3f}",
        y=f"{y:.3f}",
    )
    return yaml.safe_dump(yaml.safe_load(text), sort_keys=False, allow_unicode=True)
