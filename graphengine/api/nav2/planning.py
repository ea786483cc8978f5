"""Computes the Nav2 parameters for planning: costmaps, planner and smoother."""

from __future__ import annotations

import math

from graphengine.api.nav2.choices import Choices
from graphengine.api.nav2.distributions import Distribution
from graphengine.api.nav2.parameter_text import Parameters, node
from graphengine.api.nav2.robot_facts import MAP_FRAME, RobotFacts
from graphengine.api.nav2.sourced import Sourced, nav2

PADDING = 0.02
"""Distance by which the footprint is enlarged, m."""
CLEARANCE = 0.5
"""Distance by which the inflation radius of obstacles exceeds the robot's circumscribed radius, m."""
SIMULATED = 1.7
"""Duration of the trajectories that DWB simulates, s."""
HORIZON = 2.8
"""Duration of the trajectories that MPPI simulates, s."""
RESOLUTION = 0.05
"""Side of a cell of the costmaps, m; the map has cells of the same size."""
TOLERANCE = 0.5
"""Maximum age of transforms that Nav2 accepts on a busy machine, s."""
FORWARD = Sourced(0.0, "lidars seldom see backward; only the behavior backup drives backward")
"""Lowest speed that a controller commands to a robot that can turn on the spot, m/s."""


def planning(robot: RobotFacts, choices: Choices, *, known_map: bool) -> Parameters:
    """Return the parameters of the costmaps, planner_server and smoother_server.

    Args:
        robot: properties of the robot.
        choices: choices of the user.
        known_map: whether the map is complete; if True, the planner avoids unknown cells.
    """
    return {
        "global_costmap": {"global_costmap": node(_global_costmap(robot, choices))},
        "local_costmap": {"local_costmap": node(_local_costmap(robot, choices))},
        "planner_server": node(_planner(robot, choices, known_map=known_map)),
        "smoother_server": node(_smoother(choices.distribution)),
    }


def _global_costmap(robot: RobotFacts, choices: Choices) -> Parameters:
    return {
        "global_frame": Sourced(MAP_FRAME, "frame of the map"),
        **_costmap(robot, choices),
        "update_frequency": nav2(1.0),
        "publish_frequency": nav2(1.0),
        "track_unknown_space": nav2(True),
        "plugins": nav2(["static_layer", "obstacle_layer", "inflation_layer"]),
        "static_layer": {
            "plugin": nav2("nav2_costmap_2d::StaticLayer"),
            "map_topic": Sourced(robot.topic("map"), "topic `map` in the namespace of the robot"),
            "map_subscribe_transient_local": nav2(True),
        },
        "obstacle_layer": _obstacles(robot, 3.0),
        "inflation_layer": _inflation(robot),
    }


def _local_costmap(robot: RobotFacts, choices: Choices) -> Parameters:
    side, simulated = local_size(robot, choices), simulated_time(robot, choices)
    reach = f"twice the sum of the way driven in {simulated:g} s, the circumscribed radius and 0.3 m; at least 3 m"
    return {
        "global_frame": Sourced(robot.odometry_frame, f"frame of {robot.odometry_topic}"),
        **_costmap(robot, choices),
        "update_frequency": nav2(5.0),
        "publish_frequency": nav2(2.0),
        "rolling_window": nav2(True),
        "width": Sourced(side, reach),
        "height": Sourced(side, reach),
        "plugins": Sourced(["obstacle_layer", "inflation_layer"], "no voxel layer, because scans are planar"),
        "obstacle_layer": _obstacles(robot, side / 2.0),
        "inflation_layer": _inflation(robot),
    }


def simulated_time(robot: RobotFacts, choices: Choices) -> float:
    """Return the duration of the trajectories that the controller simulates, s."""
    return HORIZON if choices.controller_for(robot.limits) == "mppi" else SIMULATED


def local_size(robot: RobotFacts, choices: Choices) -> int:
    """Return the side length of the square local costmap, m."""
    _, outer = robot.radii
    return max(3, math.ceil(2.0 * (simulated_time(robot, choices) * robot.limits.speed.value + outer + 0.3)))


def tolerance(choices: Choices) -> Parameters:
    """Return the maximum age of transforms of a controller plugin; since Lyrical, that of the costmap holds."""
    return {} if choices.distribution.path_handlers else {"transform_tolerance": choices.patient(0.1, TOLERANCE)}


def _costmap(robot: RobotFacts, choices: Choices) -> Parameters:
    return {
        "robot_base_frame": Sourced(robot.base_frame, "child frame of the odometry"),
        "resolution": Sourced(RESOLUTION, "as in the map"),
        **_outline(robot),
        "footprint_padding": Sourced(PADDING, "more than the simplification of the footprint cuts off"),
        "transform_tolerance": choices.patient(0.3, TOLERANCE),
        "always_send_full_costmap": nav2(True),
    }


def _outline(robot: RobotFacts) -> Parameters:
    """Return the radius of a round robot, else the corners of its footprint; Nav2 ignores a radius beside a footprint."""
    if robot.radius is not None:
        return {"robot_radius": Sourced(round(robot.radius, 3), "its colliders form a circle on the floor")}
    corners = ", ".join(f"[{x:.3f}, {y:.3f}]" for x, y in robot.footprint)
    inner, outer = robot.radii
    source = f"convex hull of all colliders on the floor; inscribed {inner:.3f} m, circumscribed {outer:.3f} m"
    return {"footprint": Sourced(f"[{corners}]", source)}


def _obstacles(robot: RobotFacts, reach: float) -> Parameters:
    sources = {f"scan{number or ''}": scan for number, scan in enumerate(robot.scans)}
    top = max(2.0, *(math.ceil(scan.height) + 0.0 for scan in robot.scans))
    heights: Parameters = {
        "min_obstacle_height": Sourced(
            -1.0, "below all scan planes; with 0, rounding errors would hide a scan plane at height 0"
        ),
        "max_obstacle_height": Sourced(top, "above the planes of all scans"),
    }
    return {
        "plugin": nav2("nav2_costmap_2d::ObstacleLayer"),
        "enabled": nav2(True),
        **heights,
        "observation_sources": Sourced(" ".join(sources), "all LaserScan topics of the robot"),
        **{
            name: {
                "topic": Sourced(scan.topic, "topic that the robot's graph publishes"),
                "data_type": Sourced("LaserScan", "type of the topic"),
                "marking": nav2(True),
                "clearing": nav2(True),
                "inf_is_valid": Sourced(True, "a beam without a hit clears the cells that it crosses"),
                **heights,
                "obstacle_min_range": Sourced(scan.ranges[0], "minimum range of the lidar"),
                "obstacle_max_range": Sourced(
                    min(reach, scan.ranges[1]), "reach of this costmap layer, at most the range of the lidar"
                ),
                "raytrace_min_range": Sourced(scan.ranges[0], "minimum range of the lidar"),
                "raytrace_max_range": Sourced(
                    min(reach + 0.5, scan.ranges[1]),
                    "0.5 m beyond obstacle_max_range, to clear obstacles that moved away",
                ),
            }
            for name, scan in sources.items()
        },
    }


def _inflation(robot: RobotFacts) -> Parameters:
    _, outer = robot.radii
    return {
        "plugin": nav2("nav2_costmap_2d::InflationLayer"),
        "cost_scaling_factor": nav2(3.0),
        "inflation_radius": Sourced(
            round(outer + PADDING + CLEARANCE, 2), f"circumscribed radius, padding, and {CLEARANCE:g} m of clearance"
        ),
    }


def _planner(robot: RobotFacts, choices: Choices, *, known_map: bool) -> Parameters:
    radius = robot.limits.turning_radius
    unknown = Sourced(not known_map, "the map is complete" if known_map else "slam_toolbox is still building the map")
    plugin: Parameters = {
        "plugin": nav2("nav2_navfn_planner::NavfnPlanner"),
        "tolerance": nav2(0.5),
        "use_astar": nav2(False),
        "allow_unknown": unknown,
    }
    if radius.value:
        car = "a car that can drive backward"
        plugin = {
            "plugin": Sourced("nav2_smac_planner::SmacPlannerHybrid", "plans paths that a car can follow"),
            "minimum_turning_radius": radius,
            "motion_model_for_search": Sourced("REEDS_SHEPP", car),
            "tolerance": nav2(0.25),
            "allow_unknown": unknown,
            "max_iterations": nav2(1000000),
            "max_planning_time": nav2(5.0),
            "angle_quantization_bins": nav2(72),
            "analytic_expansion_ratio": nav2(3.5),
            "reverse_penalty": nav2(2.0),
            "change_penalty": nav2(0.0),
            "non_straight_penalty": nav2(1.2),
            "cost_penalty": nav2(2.0),
            "smooth_path": nav2(True),
        }
    return {
        "expected_planner_frequency": Sourced(
            1.0, "rate at which the behavior tree requests plans; slower planning causes a warning"
        ),
        "costmap_update_timeout": choices.patient(1.0, 5.0),
        "planner_plugins": nav2(["GridBased"]),
        "GridBased": plugin,
    }


def _smoother(distribution: Distribution) -> Parameters:
    inversion: Parameters = {"enforce_path_inversion": nav2(True)} if distribution.path_inversion else {}
    return {
        "smoother_plugins": nav2(["simple_smoother"]),
        "simple_smoother": {
            "plugin": nav2("nav2_smoother::SimpleSmoother"),
            "tolerance": nav2(1.0e-10),
            "max_its": nav2(1000),
            "do_refinement": nav2(True),
            **inversion,
        },
    }
