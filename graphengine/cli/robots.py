"""`graphrun robots`: list the robots of a scene with their robot_state_publisher topics, or print the URDF of a robot."""

from __future__ import annotations

import argparse
import dataclasses
import json

from graphengine.cli.common import add_file_arguments, clean, fitted_table, load, print_findings
from graphengine.cli.live import show
from graphengine.cli.options import add_value
from graphengine.format.errors import UsageError
from graphengine.format.wording import unknown


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun robots` to its parser."""
    add_file_arguments(parser)
    output = parser.add_mutually_exclusive_group()
    add_value(output, "--urdf", "ROBOT", "print the URDF of this robot, for robot_state_publisher")
    form = "output format (default text); json also has the URDF of each robot"
    output.add_argument("--format", choices=("text", "json"), default="text", help=form)


def execute(arguments: argparse.Namespace) -> int:
    """Print the robots or the URDF of one; return 0, or 1 if the scene has errors."""
    from graphengine.api.robot_states import robot_states

    arguments.robot_state = True  # its nodes have the topics of robot_state_publisher
    scene = load(arguments)
    print_findings(scene.findings, notes=False)
    if scene.findings.errors:
        return 1
    robots = {robot.name: robot for robot in robot_states(scene)}
    if arguments.urdf is not None:
        if arguments.urdf not in robots:
            raise UsageError(unknown("robot", arguments.urdf, robots))
        show(robots[arguments.urdf].urdf)
    elif arguments.format == "json":
        print(json.dumps([dataclasses.asdict(robot) for robot in robots.values()], indent=2))
    else:
        rows = [("ROBOT", "NAMESPACE", "JOINT STATES", "TF")]
        rows += [(robot.name, robot.namespace, robot.joint_states, robot.tf) for robot in robots.values()]
        print(clean(fitted_table(rows, 3)))
    return 0
