"""Generates Nav2's parameter file for a robot."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.api.nav2.choices import Choices
from graphengine.api.nav2.distributions import Distribution
from graphengine.api.nav2.driving import driving
from graphengine.api.nav2.localization import Alphas, localization
from graphengine.api.nav2.parameter_text import Parameters, node, parameter_text
from graphengine.api.nav2.planning import TOLERANCE, planning
from graphengine.api.nav2.robot_facts import MAP_FRAME, RobotFacts
from graphengine.api.nav2.slam_toolbox import slam_toolbox
from graphengine.api.nav2.sourced import Sourced, nav2

NAVIGATION = (
    "controller_server",
    "smoother_server",
    "planner_server",
    "behavior_server",
    "velocity_smoother",
    "collision_monitor",
    "bt_navigator",
    "waypoint_follower",
)
"""Nodes that lifecycle_manager_navigation starts, in this order."""
LOCALIZATION = ("map_server", "amcl")
SLAM = ("slam_toolbox",)
"""Nodes that lifecycle_manager_localization starts if slam_toolbox builds the map."""
BOND_TIMEOUT = 20.0
"""Time without a heartbeat after which a lifecycle manager stops all its nodes, on a busy machine, s."""

_ERROR_CODES = ("compute_path_error_code", "follow_path_error_code")
_ERROR_PREFIXES = (
    "backup",
    "compute_path",
    "drive_on_heading",
    "follow_path",
    "nav_thru_poses",
    "nav_to_pose",
    "smoother",
    "spin",
    "wait",
)


def nav2_parameters(robot: RobotFacts, choices: Choices, alphas: Sourced[Alphas] | None, scene: str) -> str:
    """Return the content of nav2_params.yaml.

    Args:
        robot: properties of the robot.
        choices: choices of the user.
        alphas: motion noise of AMCL; None configures slam_toolbox instead of AMCL.
        scene: name of the scene, for the comment in the first line.
    """
    place = localization(robot, alphas) if alphas is not None else slam_toolbox(robot, choices)
    located_by = LOCALIZATION if alphas is not None else SLAM
    nodes: Parameters = {
        **place,
        "bt_navigator": node(_navigator(robot, choices)),
        **planning(robot, choices, known_map=alphas is not None),
        **driving(robot, choices),
        "waypoint_follower": node(_follower(choices.distribution)),
        "lifecycle_manager_localization": node(_manager(located_by, choices)),
        "lifecycle_manager_navigation": node(_manager(NAVIGATION, choices)),
    }
    name = choices.distribution.name
    head = f"Nav2 ({name}) for {robot.name} of {scene}, by `graphrun nav2 files`; comments: sources of values"
    return parameter_text(nodes, robot.namespace, head)


def _navigator(robot: RobotFacts, choices: Choices) -> Parameters:
    codes: Parameters = {"error_code_names": nav2(list(_ERROR_CODES))}
    if choices.distribution.error_code_prefixes:
        codes = {"error_code_name_prefixes": nav2(list(_ERROR_PREFIXES))}
    return {
        "global_frame": Sourced(MAP_FRAME, "frame of the map"),
        "robot_base_frame": Sourced(robot.base_frame, "child frame of the odometry"),
        "odom_topic": Sourced(robot.odometry_topic, "topic that the robot's graph publishes"),
        "transform_tolerance": choices.patient(0.1, TOLERANCE),
        "bt_loop_duration": nav2(10),
        "default_server_timeout": choices.patient(20, 5000),
        "default_cancel_timeout": choices.patient(50, 5000),
        "wait_for_service_timeout": choices.patient(1000, 20000),
        "navigators": nav2(["navigate_to_pose", "navigate_through_poses"]),
        "navigate_to_pose": {"plugin": nav2("nav2_bt_navigator::NavigateToPoseNavigator")},
        "navigate_through_poses": {"plugin": nav2("nav2_bt_navigator::NavigateThroughPosesNavigator")},
        **codes,
    }


def _follower(distribution: Distribution) -> Parameters:
    limit: Parameters = {"action_server_result_timeout": nav2(900.0)} if distribution.name == "jazzy" else {}
    return {
        "loop_rate": nav2(20),
        "stop_on_failure": nav2(False),
        **limit,
        "waypoint_task_executor_plugin": nav2("wait_at_waypoint"),
        "wait_at_waypoint": {
            "plugin": nav2("nav2_waypoint_follower::WaitAtWaypoint"),
            "enabled": nav2(True),
            "waypoint_pause_duration": nav2(200),
        },
    }


def _manager(nodes: Sequence[str], choices: Choices) -> Parameters:
    timed = choices.distribution.service_timeout
    service: Parameters = {"service_timeout": choices.patient(5.0, BOND_TIMEOUT)} if timed else {}
    return {
        "autostart": nav2(True),
        "node_names": Sourced(list(nodes), "nodes of nav2.launch.py, in start order"),
        "bond_timeout": choices.patient(4.0, BOND_TIMEOUT),
        **service,
    }
