"""`graphrun nav2 files`: write Nav2's parameters, map, launch file and RViz configuration for a scene."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import add_file_arguments, chosen_distro, clean, open_scene, refuse_to_overwrite
from graphengine.cli.options import add_flag, add_repeatable, add_value
from graphengine.cli.progress import share_of
from graphengine.cli.quantities import angle, number
from graphengine.format.errors import UsageError
from graphengine.format.files import near

if TYPE_CHECKING:
    from graphengine.api.scene import Scene
    from graphengine.bringup.nav2.nav2_files import Nav2Files
    from graphengine.bringup.nav2.robot_facts import RobotFacts


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun nav2 files` to its parser."""
    add_file_arguments(parser)
    add_value(parser, "--output", "DIR", "folder to write the files to", short="-o", type=Path, required=True)
    add_repeatable(parser, "--robot", "NAME", "robot that Nav2 drives (default: all robots)", dest="robots")
    add_flag(parser, "--slam", "use slam_toolbox, which makes the map, instead of map_server and AMCL")
    controller = "controller of Nav2 (default: dwb; rpp for a car)"
    parser.add_argument("--controller", choices=("dwb", "mppi", "rpp"), help=controller)
    reached = "distance from a goal within which the goal is reached, m (default 0.15)"
    add_value(parser, "--xy-tolerance", "DISTANCE", reached, type=number)
    facing = "angle from a goal within which the goal is reached, rad or as 5deg (default 0.1 with dwb, otherwise 0.2)"
    add_value(parser, "--yaw-tolerance", "ANGLE", facing, type=angle)
    busy = "longer timeouts and lower rates, for a machine on which the simulation slows Nav2 down; not for real robots"
    add_flag(parser, "--busy", busy)
    skip = "do not measure the robot's odometry errors and speeds; AMCL's noise parameters then assume good odometry"
    add_flag(parser, "--no-calibrate", skip)
    add_flag(parser, "--force", "overwrite existing files")


def execute(arguments: argparse.Namespace) -> int:
    """Write the files; return 0 on success, 1 if the scene has errors."""
    for option in ("xy_tolerance", "yaw_tolerance"):
        if (value := getattr(arguments, option)) is not None and value <= 0.0:
            raise UsageError(f"--{option.replace('_', '-')}: expected a number above 0, got {value:g}")
    folder: Path = arguments.output
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"-o {folder}: this is not a folder")
    scene = open_scene(arguments)
    made = _make(scene, arguments)
    from graphengine.format.atomic_write import write_together

    contents = {folder / path: content for path, content in made.contents.items()}
    refuse_to_overwrite(contents, force=arguments.force)
    write_together(contents)
    for robot in made.robots:
        print(clean(_summary(robot)))
    for note in made.notes:
        print(clean(f"note: {note}"), file=sys.stderr)
    print(clean(f"{near(str(folder))}: {len(contents)} files"))
    run = shlex.join(["graphrun", "run", str(arguments.file), *(["--robot-state"] if arguments.robot_state else [])])
    launch = shlex.join(["ros2", "launch", str(folder / "nav2.launch.py"), "rviz:=true"])
    print(clean(f"next: {run}\nwith ROS 2: {launch}"))
    return 0


def _make(scene: Scene, arguments: argparse.Namespace) -> Nav2Files:
    from graphengine.bringup.nav2.choices import Choices
    from graphengine.bringup.nav2.nav2_files import nav2_files

    tolerances = arguments.xy_tolerance, arguments.yaw_tolerance
    choices = Choices(chosen_distro(arguments), arguments.busy, arguments.controller, *tolerances)
    with share_of("calibrating") as advance:
        return nav2_files(
            scene,
            robots=arguments.robots,
            choices=choices,
            slam=arguments.slam,
            calibrated=not arguments.no_calibrate,
            progress=lambda _, share: advance(share),
        )


def _summary(robot: RobotFacts) -> str:
    """Return a line for the user with the kinematics, limits and footprint of a robot."""
    limits, (inner, outer) = robot.limits, robot.radii
    turns = f"turning radius {limits.turning_radius.value:.2f} m" if limits.car else "turns on the spot"
    return (
        f"{robot.name}: {limits.kinematics.value}, {turns}, {limits.speed.value:.2f} m/s, {limits.turn.value:.2f} rad/s, "
        f"footprint of {len(robot.footprint)} corners, {inner:.2f} to {outer:.2f} m from {robot.base_frame}"
    )
