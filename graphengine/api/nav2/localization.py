"""Computes the Nav2 parameters for localization: map_server and AMCL."""

from __future__ import annotations

from graphengine.api.nav2.parameter_text import Parameters, node
from graphengine.api.nav2.robot_facts import MAP_FRAME, RobotFacts
from graphengine.api.nav2.sourced import Sourced, nav2

Alphas = tuple[float, float, float, float, float]


def localization(robot: RobotFacts, alphas: Sourced[Alphas]) -> Parameters:
    """Return the parameters of map_server, AMCL and their lifecycle manager."""
    return {"map_server": node(_map_server()), "amcl": node(_amcl(robot, alphas))}


def _map_server() -> Parameters:
    return {
        "frame_id": Sourced(MAP_FRAME, "frame of the map: the world frame of the scene"),
        "topic_name": Sourced("map", "in the namespace of the robot"),
    }


def _amcl(robot: RobotFacts, alphas: Sourced[Alphas]) -> Parameters:
    scan = robot.scans[0]
    lidar = f"lidar of {scan.topic}"
    omni = robot.limits.kinematics.value == "omni"
    start = "pose of the robot in the scene"
    x, y, yaw = robot.pose
    return {
        "base_frame_id": Sourced(robot.base_frame, "child frame of the odometry"),
        "odom_frame_id": Sourced(robot.odometry_frame, f"frame of {robot.odometry_topic}"),
        "global_frame_id": Sourced(MAP_FRAME, "frame of the map"),
        "scan_topic": Sourced(scan.topic, "LaserScan with the widest field of view"),
        "robot_model_type": Sourced(
            f"nav2_amcl::{'Omni' if omni else 'Differential'}MotionModel", robot.limits.kinematics.source
        ),
        **{f"alpha{number}": Sourced(alpha, alphas.source) for number, alpha in enumerate(alphas.value, 1)},
        "laser_min_range": Sourced(scan.ranges[0], lidar),
        "laser_max_range": Sourced(scan.ranges[1], lidar),
        "laser_model_type": nav2("likelihood_field"),
        "laser_likelihood_max_dist": nav2(2.0),
        "max_beams": nav2(60),
        "sigma_hit": nav2(0.2),
        "z_hit": nav2(0.5),
        "z_max": nav2(0.05),
        "z_rand": nav2(0.5),
        "z_short": nav2(0.05),
        "lambda_short": nav2(0.1),
        "do_beamskip": nav2(False),
        "min_particles": nav2(500),
        "max_particles": nav2(2000),
        "pf_err": nav2(0.05),
        "pf_z": nav2(0.99),
        "recovery_alpha_fast": nav2(0.0),
        "recovery_alpha_slow": nav2(0.0),
        "resample_interval": nav2(1),
        "save_pose_rate": nav2(0.5),
        "tf_broadcast": nav2(True),
        "transform_tolerance": nav2(1.0),
        "update_min_a": nav2(0.2),
        "update_min_d": nav2(0.25),
        "set_initial_pose": Sourced(True, start),
        "initial_pose": {
            "x": Sourced(x, start),
            "y": Sourced(y, start),
            "z": Sourced(0.0, "on the floor"),
            "yaw": Sourced(yaw, start),
        },
    }
