"""Differences between Nav2's parameters in ROS 2 distributions.

Sources: nav2_bringup/params/nav2_params.yaml, and the calls that declare parameters, in the branches `jazzy`
(f4108e5), `kilted` (71a1d84) and `lyrical` (aa3dab8) of github.com/ros-navigation/navigation2:

| parameter | jazzy | kilted | lyrical |
|---|---|---|---|
| bt_navigator error codes | error_code_names | error_code_name_prefixes | error_code_name_prefixes |
| bt_navigator filter_duration | - | yes | yes |
| enable_stamped_cmd_vel, default | false | true | true |
| lifecycle_manager service_timeout | - | yes | yes |
| behaviors backup, drive_on_heading: acceleration_limit, … | - | yes | yes |
| smoother refinement_num, enforce_path_inversion | first | both | both |
| controller_server path_handler_plugins | - | - | yes |
| DWB, RPP transform_tolerance | yes | yes | - (of the costmap) |
| RPP speed | desired_linear_vel | desired_linear_vel | max_linear_vel, max_angular_vel |
| MPPI motion model | DiffDrive, Omni, Ackermann | as in Jazzy | plugin below diff_drive, omni, ackermann |
| MPPI prune_distance | yes | yes | - (of the path handler) |
| waypoint_follower action_server_result_timeout | yes | - | - |
| planner_server expected_planner_frequency | yes | yes | yes |

Names of plugins have `::` in all three.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Distribution:
    """A ROS 2 distribution, with the Nav2 parameters that differ between distributions.

    Attributes:
        name: name of the ROS 2 distribution.
        error_code_prefixes: whether bt_navigator has the parameter `error_code_name_prefixes` instead of `error_code_names`.
        service_timeout: whether lifecycle managers have the parameter `service_timeout`.
        limited_behaviors: whether the behaviors backup and drive_on_heading have acceleration limits.
        path_inversion: whether smoothers have the parameter `enforce_path_inversion`.
        path_handlers: whether the controller server has path handler plugins; controllers then have no
            `transform_tolerance`.
    """

    name: str
    error_code_prefixes: bool = True
    service_timeout: bool = True
    limited_behaviors: bool = True
    path_inversion: bool = True
    path_handlers: bool = True


DISTRIBUTIONS = {
    one.name: one
    for one in (
        Distribution("jazzy", False, False, False, False, False),
        Distribution("kilted", path_handlers=False),
        Distribution("lyrical"),
    )
}
DEFAULT = "jazzy"
