"""Computes the parameters of slam_toolbox, which replaces map_server and AMCL and builds the map while the robot drives."""

from __future__ import annotations

from graphengine.api.nav2.choices import Choices
from graphengine.api.nav2.parameter_text import Parameters, node
from graphengine.api.nav2.robot_facts import MAP_FRAME, RobotFacts
from graphengine.api.nav2.sourced import Sourced

_OWN = "slam_toolbox's own mapper_params_online_async.yaml"


def slam_toolbox(robot: RobotFacts, choices: Choices) -> Parameters:
    """Return the parameters of slam_toolbox for a robot; slam_toolbox uses the robot's first LaserScan topic."""
    scan = robot.scans[0]
    own = {
        "solver_plugin": "solver_plugins::CeresSolver",
        "ceres_linear_solver": "SPARSE_NORMAL_CHOLESKY",
        "ceres_preconditioner": "SCHUR_JACOBI",
        "ceres_trust_strategy": "LEVENBERG_MARQUARDT",
        "ceres_dogleg_type": "TRADITIONAL_DOGLEG",
        "ceres_loss_function": "None",
        "throttle_scans": 1,
        "transform_publish_period": 0.02,
        "map_update_interval": 5.0,
        "minimum_time_interval": 0.5,
        "tf_buffer_duration": 30.0,
        "stack_size_to_use": 40000000,
        "enable_interactive_mode": True,
        "use_scan_matching": True,
        "use_scan_barycenter": True,
        "minimum_travel_distance": 0.5,
        "minimum_travel_heading": 0.5,
        "scan_buffer_size": 10,
        "scan_buffer_maximum_scan_distance": 10.0,
        "do_loop_closing": True,
    }
    return {
        "slam_toolbox": node(
            {
                "use_lifecycle_manager": Sourced(True, "lifecycle_manager_localization starts it"),
                "mode": Sourced("mapping", "there is no map yet"),
                "odom_frame": Sourced(robot.odometry_frame, f"frame of {robot.odometry_topic}"),
                "map_frame": Sourced(MAP_FRAME, "frame of the map"),
                "base_frame": Sourced(robot.base_frame, "child frame of the odometry"),
                "scan_topic": Sourced(scan.topic, "LaserScan with the widest field of view"),
                "resolution": Sourced(0.05, "as in the costmaps"),
                "min_laser_range": Sourced(scan.ranges[0], f"lidar of {scan.topic}"),
                "max_laser_range": Sourced(min(scan.ranges[1], 40.0), f"lidar of {scan.topic}, at most 40 m"),
                "transform_timeout": choices.patient(0.2, 1.0),
                **{name: Sourced(value, _OWN) for name, value in own.items()},
            }
        )
    }
