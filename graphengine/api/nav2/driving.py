"""Computes the Nav2 parameters for driving: controller, behaviors, velocity smoother and collision monitor."""

from __future__ import annotations

from typing import Any

from graphengine.api.nav2.distributions import Distribution
from graphengine.api.nav2.parameter_text import Parameters, node
from graphengine.api.nav2.planning import BUSY, SIMULATED, TOLERANCE
from graphengine.api.nav2.robot_facts import MAP_FRAME, RobotFacts
from graphengine.api.nav2.sourced import Sourced, nav2

REACHED, FACING = 0.15, 0.2
"""Distance (m) and angle (rad) from a goal within which the robot has reached it."""
NEAR = "smaller than 0.25 in Nav2's parameter file, because the localization error adds to it"
CONTROL_RATE = 10.0
"""Rate at which the controller sends velocity commands, Hz."""


def driving(robot: RobotFacts, distribution: Distribution) -> Parameters:
    """Return the parameters of controller_server, behavior_server, velocity_smoother and collision_monitor."""
    return {
        "controller_server": node(_controller(robot, distribution)),
        "behavior_server": node(_behaviors(robot, distribution)),
        "velocity_smoother": node(_smoother(robot)),
        "collision_monitor": node(_monitor(robot)),
    }


def _stamped(robot: RobotFacts) -> Parameters:
    kind = "TwistStamped" if robot.stamped else "Twist"
    return {"enable_stamped_cmd_vel": Sourced(robot.stamped, f"{robot.command_topic} takes {kind}")}


def _controller(robot: RobotFacts, distribution: Distribution) -> Parameters:
    car = robot.limits.turning_radius.value > 0.0
    handler: Parameters = {}
    if distribution.path_handlers:
        handler = {
            "path_handler_plugins": nav2(["PathHandler"]),
            "PathHandler": {
                "plugin": nav2("nav2_controller::FeasiblePathHandler"),
                "prune_distance": nav2(2.0),
                "enforce_path_inversion": Sourced(
                    car, "a car stops where its path changes direction" if car else "not needed: the robot is no car"
                ),
            },
        }
    return {
        **_stamped(robot),
        "controller_frequency": Sourced(CONTROL_RATE, f"half of the rate in Nav2's parameter file, {BUSY}"),
        "costmap_update_timeout": Sourced(2.0, BUSY),
        "failure_tolerance": Sourced(2.0, BUSY),
        "min_x_velocity_threshold": nav2(0.001),
        "min_y_velocity_threshold": _sideways_threshold(robot),
        "min_theta_velocity_threshold": nav2(0.001),
        "progress_checker_plugins": nav2(["progress_checker"]),
        "progress_checker": {
            "plugin": Sourced("nav2_controller::PoseProgressChecker", "counts turning on the spot as progress, too"),
            "required_movement_radius": nav2(0.5),
            "required_movement_angle": nav2(0.5),
            "movement_time_allowance": Sourced(15.0, BUSY),
        },
        "goal_checker_plugins": nav2(["general_goal_checker"]),
        "general_goal_checker": {
            "plugin": nav2("nav2_controller::SimpleGoalChecker"),
            "xy_goal_tolerance": Sourced(REACHED, NEAR),
            "yaw_goal_tolerance": Sourced(FACING, NEAR),
            "stateful": nav2(True),
        },
        **handler,
        "controller_plugins": nav2(["FollowPath"]),
        "FollowPath": _pursuit(robot, distribution) if car else _turning(robot, distribution),
    }


def _sideways_threshold(robot: RobotFacts) -> Sourced[float]:
    """Return the sideways velocity in the odometry below which Nav2's controller assumes zero, m/s."""
    omni = robot.limits.kinematics.value == "omni"
    return Sourced(0.001, robot.limits.kinematics.source) if omni else nav2(0.5)


def _tolerance(distribution: Distribution) -> Parameters:
    return {} if distribution.path_handlers else {"transform_tolerance": Sourced(TOLERANCE, BUSY)}


def _turning(robot: RobotFacts, distribution: Distribution) -> Parameters:
    """Return the parameters of the rotation shim and of DWB, for robots that can turn on the spot."""
    limits = robot.limits
    return {
        "plugin": Sourced(
            "nav2_rotation_shim_controller::RotationShimController",
            "turns on the spot to the heading of a new path; DWB alone turns on an arc and can hit obstacles beside the robot",
        ),
        "primary_controller": Sourced(
            "dwb_core::DWBLocalPlanner", "respects all limits below, and needs little CPU time"
        ),
        "angular_dist_threshold": nav2(0.785),
        "forward_sampling_distance": nav2(0.5),
        "rotate_to_heading_angular_vel": limits.turn,
        "max_angular_accel": limits.turn_acceleration,
        "simulate_ahead_time": nav2(1.0),
        **_dwb(robot, distribution),
    }


def _dwb(robot: RobotFacts, distribution: Distribution) -> Parameters:
    """Return the parameters of the controller DWB: velocity limits, sampled velocities and critics."""
    limits = robot.limits
    omni = limits.kinematics.value == "omni"
    sideways = limits.speed if omni else Sourced(0.0, limits.kinematics.source)
    braking = Sourced(-limits.deceleration.value, limits.deceleration.source)
    turn_braking = Sourced(-limits.turn_acceleration.value, limits.turn_acceleration.source)
    example = "DWB example in Nav2's documentation"

    def scaled(scale: float, **more: Any) -> Parameters:
        return {name: Sourced(value, example) for name, value in {"scale": scale, **more}.items()}

    return {
        "min_vel_x": Sourced(0.0, "lidars seldom see backward; only the behavior backup drives backward"),
        "max_vel_x": limits.speed,
        "min_vel_y": Sourced(-sideways.value, sideways.source),
        "max_vel_y": sideways,
        "max_vel_theta": limits.turn,
        "min_speed_xy": nav2(0.0),
        "max_speed_xy": limits.speed,
        "min_speed_theta": nav2(0.0),
        "acc_lim_x": limits.acceleration,
        "acc_lim_y": limits.acceleration if omni else sideways,
        "acc_lim_theta": limits.turn_acceleration,
        "decel_lim_x": braking,
        "decel_lim_y": braking if omni else sideways,
        "decel_lim_theta": turn_braking,
        "vx_samples": Sourced(15, f"less than 20, {BUSY}"),
        "vy_samples": Sourced(5 if omni else 1, limits.kinematics.source),
        "vtheta_samples": Sourced(20, example),
        "sim_time": Sourced(SIMULATED, example),
        "linear_granularity": Sourced(0.05, example),
        "angular_granularity": Sourced(0.05, f"twice the default, {BUSY}"),
        **_tolerance(distribution),
        "xy_goal_tolerance": Sourced(REACHED, "as in the goal checker"),
        "trans_stopped_velocity": Sourced(0.25, example),
        "short_circuit_trajectory_evaluation": Sourced(True, example),
        "critics": Sourced(
            ["RotateToGoal", "Oscillation", "ObstacleFootprint", "GoalAlign", "PathAlign", "PathDist", "GoalDist"],
            f"{example}; ObstacleFootprint checks the whole footprint, not only its inscribed circle",
        ),
        "RotateToGoal": scaled(32.0, slowing_factor=5.0, lookahead_time=-1.0),
        "ObstacleFootprint": scaled(0.02),
        "GoalAlign": scaled(24.0, forward_point_distance=0.1),
        "PathAlign": scaled(32.0, forward_point_distance=0.1),
        "PathDist": scaled(32.0),
        "GoalDist": scaled(24.0),
    }


def _pursuit(robot: RobotFacts, distribution: Distribution) -> Parameters:
    """Return the parameters of the controller regulated pure pursuit, for robots with car-like steering."""
    limits = robot.limits
    radius = limits.turning_radius
    speeds: Parameters = {"desired_linear_vel": limits.speed}
    if distribution.path_handlers:
        speeds = {"max_linear_vel": limits.speed, "max_angular_vel": limits.turn}
    ahead = max(0.6, round(1.2 * radius.value, 2))
    by_radius = f"1.2 times the turning radius ({radius.source})"
    return {
        "plugin": Sourced(
            "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController",
            "follows paths with car-like steering",
        ),
        **speeds,
        **_tolerance(distribution),
        "lookahead_dist": Sourced(ahead, by_radius),
        "min_lookahead_dist": Sourced(ahead, by_radius),
        "max_lookahead_dist": Sourced(2.0 * ahead, "twice lookahead_dist"),
        "lookahead_time": nav2(1.5),
        "use_velocity_scaled_lookahead_dist": Sourced(True, "the lookahead distance grows with the speed"),
        "min_approach_linear_velocity": nav2(0.05),
        "approach_velocity_scaling_dist": nav2(0.6),
        "use_collision_detection": nav2(True),
        "max_allowed_time_to_collision_up_to_carrot": nav2(1.0),
        "use_regulated_linear_velocity_scaling": nav2(True),
        "use_cost_regulated_linear_velocity_scaling": nav2(False),
        "regulated_linear_scaling_min_radius": Sourced(max(0.9, 1.5 * radius.value), "1.5 times the turning radius"),
        "regulated_linear_scaling_min_speed": nav2(0.25),
        "use_rotate_to_heading": Sourced(False, limits.kinematics.source),
        "allow_reversing": Sourced(True, "the planner's paths go backward where that is shorter"),
    }


def _behaviors(robot: RobotFacts, distribution: Distribution) -> Parameters:
    limits = robot.limits
    accelerations: Parameters = {}
    if distribution.limited_behaviors:
        accelerations = {
            "acceleration_limit": limits.acceleration,
            "deceleration_limit": Sourced(-limits.deceleration.value, limits.deceleration.source),
            "minimum_speed": nav2(0.10),
        }
    return {
        **_stamped(robot),
        "local_frame": Sourced(robot.odometry_frame, f"frame of {robot.odometry_topic}"),
        "global_frame": Sourced(MAP_FRAME, "frame of the map"),
        "robot_base_frame": Sourced(robot.base_frame, "child frame of the odometry"),
        "local_costmap_topic": nav2("local_costmap/costmap_raw"),
        "global_costmap_topic": nav2("global_costmap/costmap_raw"),
        "local_footprint_topic": nav2("local_costmap/published_footprint"),
        "global_footprint_topic": nav2("global_costmap/published_footprint"),
        "cycle_frequency": nav2(10.0),
        "transform_tolerance": Sourced(TOLERANCE, BUSY),
        "simulate_ahead_time": nav2(2.0),
        "max_rotational_vel": limits.turn,
        "min_rotational_vel": Sourced(0.2 * limits.turn.value, "a fifth of the turn rate"),
        "rotational_acc_lim": limits.turn_acceleration,
        "behavior_plugins": Sourced(
            ["spin", "backup", "drive_on_heading", "wait"],
            "all behaviors of the default behavior trees; a car cannot spin, so its spin ends at the time limit",
        ),
        "spin": {"plugin": nav2("nav2_behaviors::Spin")},
        "backup": {"plugin": nav2("nav2_behaviors::BackUp"), **accelerations},
        "drive_on_heading": {"plugin": nav2("nav2_behaviors::DriveOnHeading"), **accelerations},
        "wait": {"plugin": nav2("nav2_behaviors::Wait")},
    }


def _smoother(robot: RobotFacts) -> Parameters:
    limits = robot.limits
    speed, turn, push, brake = (
        one.value for one in (limits.speed, limits.turn, limits.acceleration, limits.deceleration)
    )
    turn_push = limits.turn_acceleration
    omni = limits.kinematics.value == "omni"
    speeds = f"{limits.speed.source}; {limits.turn.source}"
    pushes = f"{limits.acceleration.source}; {turn_push.source}"
    brakes = f"{limits.deceleration.source}; {turn_push.source}"
    return {
        **_stamped(robot),
        "smoothing_frequency": nav2(20.0),
        "scale_velocities": Sourced(True, "a limited command keeps its curvature"),
        "feedback": nav2("OPEN_LOOP"),
        "max_velocity": Sourced([speed, speed * omni, turn], speeds),
        "min_velocity": Sourced([-speed, -speed * omni, -turn], speeds),
        "max_accel": Sourced([push, push * omni, turn_push.value], pushes),
        "max_decel": Sourced([-brake, -brake * omni, -turn_push.value], brakes),
        "odom_topic": Sourced(robot.odometry_topic, "topic that the robot's graph publishes"),
        "odom_duration": nav2(0.1),
        "deadband_velocity": nav2([0.0, 0.0, 0.0]),
        "velocity_timeout": nav2(1.0),
    }


def _monitor(robot: RobotFacts) -> Parameters:
    sources = {f"scan{number or ''}": scan for number, scan in enumerate(robot.scans)}
    return {
        **_stamped(robot),
        "base_frame_id": Sourced(robot.base_frame, "child frame of the odometry"),
        "odom_frame_id": Sourced(robot.odometry_frame, f"frame of {robot.odometry_topic}"),
        "cmd_vel_in_topic": Sourced("cmd_vel_smoothed", "output of velocity_smoother"),
        "cmd_vel_out_topic": Sourced(robot.command_topic, "topic to which the robot's graph subscribes"),
        "state_topic": nav2("collision_monitor_state"),
        "transform_tolerance": Sourced(TOLERANCE, BUSY),
        "source_timeout": Sourced(5.0, BUSY),
        "base_shift_correction": nav2(True),
        "stop_pub_timeout": nav2(2.0),
        "polygons": nav2(["FootprintApproach"]),
        "FootprintApproach": {
            "type": nav2("polygon"),
            "action_type": nav2("approach"),
            "footprint_topic": Sourced("local_costmap/published_footprint", "in the namespace of the robot"),
            "time_before_collision": nav2(1.2),
            "simulation_time_step": nav2(0.1),
            "min_points": nav2(6),
            "visualize": nav2(False),
            "enabled": nav2(True),
        },
        "observation_sources": Sourced(list(sources), "all LaserScan topics of the robot"),
        **{
            name: {
                "type": Sourced("scan", "type of the topic"),
                "topic": Sourced(scan.topic, "topic that the robot's graph publishes"),
                "enabled": nav2(True),
            }
            for name, scan in sources.items()
        },
    }
