"""The launch description of a simulation: the run, robot_state_publisher, RViz and Nav2.

The run starts at once. In parallel, `graphrun robots` lists the parameters of robot_state_publisher; then `graphrun nav2 files`
writes the files for RViz and Nav2.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch.actions import (
    DeclareLaunchArgument,
    ExecuteProcess,
    IncludeLaunchDescription,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launch.event_handlers import OnProcessExit, OnShutdown
from launch.events.process import ProcessExited
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from graphengine_ros.engine import EngineNotFoundError, graphrun_command
from launch import LaunchContext, LaunchDescription

Actions = list[Any]
"""Launch actions; Any, because the package `launch` has no type hints."""

_YES_NO = ["true", "false"]
ARGUMENTS = (
    ("scene", "dd100_warehouse", "scene: a path, an included scene, or package://PACKAGE/PATH", None),
    ("robot", "", "robot for robot_state_publisher, RViz and Nav2 (default: all; RViz shows the first)", None),
    ("rviz", "false", "start RViz, configured for the scene", _YES_NO),
    ("view", "false", "serve graphengine's own page with the run", _YES_NO),
    ("nav2", "false", "start Nav2, configured for the scene", _YES_NO),
    (
        "nav2_dir",
        "",
        "folder for the files of RViz and Nav2; existing files are used (default: a temporary folder)",
        None,
    ),
    ("localization", "amcl", "truth: the simulation publishes the true pose of the robot", ["amcl", "truth"]),
    (
        "robot_state",
        "auto",
        "publisher of the robot's description and frames (auto: robot_state_publisher if installed)",
        ["auto", "robot_state_publisher", "graphrun", "false"],
    ),
    ("rate", "realtime", "real-time factor, realtime or max", None),
    ("transport", "auto", "auto, rclpy or dds; auto is rclpy if graphengine's Python can import it, else dds", None),
    ("args", "", "further arguments of `graphrun run`", None),
    (
        "scene_args",
        "",
        "arguments with which the scene is loaded for the run, RViz and Nav2: --set, --import, --allow",
        None,
    ),
    (
        "python",
        "",
        "Python that has graphengine (default: GRAPHENGINE_PYTHON, VIRTUAL_ENV, or graphrun on the PATH)",
        None,
    ),
)
"""Name, default, description and choices of the launch arguments."""


def generate_launch_description() -> Any:
    """Return the launch description of `sim.launch.py`."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=description, choices=choices)
        for name, default, description, choices in ARGUMENTS
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=_start)])


def _start(context: LaunchContext) -> Actions:
    given = {name: LaunchConfiguration(name).perform(context) for name, *_ in ARGUMENTS}
    given |= {name: os.path.expanduser(given[name]) for name in ("scene", "nav2_dir")}  # shells leave `scene:=~/…`
    try:
        graphrun = graphrun_command(given["python"])
    except EngineNotFoundError as error:
        raise RuntimeError(str(error)) from None
    for argument, package, debian in (("rviz", "rviz2", "rviz2"), ("nav2", "nav2_bt_navigator", "navigation2")):
        if given[argument] == "true" and not _is_installed(package):
            remedy = f"sudo apt install ros-{os.environ.get('ROS_DISTRO', 'jazzy')}-{debian}"
            raise RuntimeError(f"{argument}:=true needs the package {package}, which is not installed\n  {remedy}")
    robot_state = given["robot_state"]
    if robot_state == "auto":
        robot_state = "robot_state_publisher" if _is_installed("robot_state_publisher") else "graphrun"
    return _Simulation(graphrun, given, robot_state).actions()


def _is_installed(package: str) -> bool:
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        return False
    return True


@dataclass
class _Simulation:
    """The actions of one launch.

    Args:
        graphrun: first arguments of a command line that runs graphrun.
        given: values of the launch arguments.
        robot_state: publisher of the frames: `robot_state_publisher`, `graphrun` or `false`.
    """

    graphrun: list[str]
    given: dict[str, str]
    robot_state: str

    def wants(self, name: str) -> bool:
        """Return whether a launch argument is true."""
        return self.given[name] == "true"

    def scene_options(self) -> list[str]:
        """Return the options with which all commands load the scene."""
        return shlex.split(self.given["scene_args"])

    def actions(self) -> Actions:
        """Return the actions that start the run and list the robots."""
        options = {
            "--view": self.wants("view"),
            "--robot-state": self.robot_state == "graphrun",
            "--localization=truth": self.given["localization"] == "truth",
        }
        run = ExecuteProcess(
            cmd=[
                *self.graphrun,
                *("run", self.given["scene"], "--rate", self.given["rate"], "--transport", self.given["transport"]),
                *(option for option, wanted in options.items() if wanted),
                *self.scene_options(),
                *shlex.split(self.given["args"]),
            ],
            name="graphrun",
            output="screen",
            on_exit=Shutdown(reason="the run has ended"),
        )
        if self.robot_state != "robot_state_publisher" and not (self.wants("rviz") or self.wants("nav2")):
            return [run]
        describe = ExecuteProcess(
            cmd=[*self.graphrun, "robots", self.given["scene"], "--format", "json", *self.scene_options()],
            name="graphrun_robots",
            output="log",  # the run prints errors in the scene
            cached_output=True,
        )

        def described(event: ProcessExited, context: LaunchContext) -> Actions:
            if event.returncode == 0:
                return self.for_robots(json.loads(describe.get_stdout()))
            return [
                LogInfo(msg="graphrun robots failed: robot_state_publisher, RViz and Nav2 are not started; see the log")
            ]

        return [run, RegisterEventHandler(OnProcessExit(target_action=describe, on_exit=described)), describe]

    def for_robots(self, robots: list[dict[str, Any]]) -> Actions:
        """Return the actions for the robots of the scene, as `graphrun robots` describes them."""
        chosen = [robot for robot in robots if self.given["robot"] in ("", robot["name"])]
        if not chosen:
            known = ", ".join(robot["name"] for robot in robots) or "none"
            reason = f"no robot {self.given['robot']!r} in the scene; robots: {known}"
            return [LogInfo(msg=reason), Shutdown(reason=reason)]
        actions: Actions = []
        if self.robot_state == "robot_state_publisher":
            actions += [_robot_state_publisher(robot) for robot in chosen if not robot["published"]]
        if self.wants("rviz") or self.wants("nav2"):
            actions += self.navigation_files(chosen)
        return actions

    def navigation_files(self, robots: list[dict[str, Any]]) -> Actions:
        """Return the actions that write the files of RViz and Nav2, and then start Nav2 or RViz; existing files are used."""
        if self.given["nav2_dir"]:
            folder, ended = Path(self.given["nav2_dir"]), []
        else:
            folder = Path(tempfile.mkdtemp(prefix="graphengine_nav2_"))
            ended = [RegisterEventHandler(OnShutdown(on_shutdown=lambda *_: shutil.rmtree(folder, ignore_errors=True)))]
        if (folder / "nav2.launch.py").exists():
            return self.navigation(folder, robots)
        measured = [] if self.wants("nav2") else ["--no-calibrate"]
        one = ["--robot", self.given["robot"]] if self.given["robot"] else []
        state = [] if self.robot_state == "false" else ["--robot-state"]
        options = [*one, *measured, *state, *self.scene_options()]
        write = ExecuteProcess(
            cmd=[*self.graphrun, "nav2", "files", self.given["scene"], "-o", str(folder), *options],
            name="graphrun_nav2_files",
            output="screen",
        )

        def written(event: ProcessExited, context: LaunchContext) -> Actions:
            if event.returncode == 0:
                return self.navigation(folder, robots)
            return [Shutdown(reason="graphrun nav2 files could not write the files of RViz and Nav2")]

        return [*ended, RegisterEventHandler(OnProcessExit(target_action=write, on_exit=written)), write]

    def navigation(self, folder: Path, robots: list[dict[str, Any]]) -> Actions:
        """Return the actions that start Nav2, with RViz if requested, or only RViz, with the files in a folder."""
        if self.wants("nav2"):
            passed = {"localization": self.given["localization"], "rviz": self.given["rviz"]}
            source = PythonLaunchDescriptionSource(str(folder / "nav2.launch.py"))
            return [IncludeLaunchDescription(source, launch_arguments=passed.items())]
        return [_rviz(folder, robots[0])]


def _robot_state_publisher(robot: dict[str, Any]) -> Any:
    topics = {"joint_states": robot["joint_states"] or "joint_states", "robot_description": robot["robot_description"]}
    return Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        namespace=robot["namespace"],
        output="screen",
        parameters=[
            {
                "robot_description": ParameterValue(robot["urdf"], value_type=str),
                "frame_prefix": robot["frame_prefix"],
                "use_sim_time": True,
            }
        ],
        remappings=[*topics.items(), ("/tf", robot["tf"]), ("/tf_static", robot["tf_static"])],
    )


def _rviz(folder: Path, robot: dict[str, Any]) -> Any:
    """Return the RViz node for one robot; in a fleet, its configuration is in the folder with the robot's name."""
    of_robot = folder / robot["name"] / "view.rviz"
    return Node(
        package="rviz2",
        executable="rviz2",
        namespace=robot["namespace"],
        output="screen",
        arguments=["-d", str(of_robot if of_robot.exists() else folder / "view.rviz")],
        parameters=[{"use_sim_time": True}],
        remappings=[("/tf", robot["tf"]), ("/tf_static", robot["tf_static"])],
    )
