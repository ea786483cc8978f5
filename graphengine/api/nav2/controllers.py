"""Computes the parameters of Nav2's controllers: DWB behind the rotation shim, and regulated pure pursuit."""

from __future__ import annotations

from typing import Any

from graphengine.api.nav2.choices import Choices
from graphengine.api.nav2.mppi import mppi, path_ahead
from graphengine.api.nav2.parameter_text import Parameters
from graphengine.api.nav2.planning import FORWARD, SIMULATED, tolerance
from graphengine.api.nav2.robot_facts import RobotFacts
from graphengine.api.nav2.sourced import Sourced, nav2

CHOSEN = "--controller"


def follow_path(robot: RobotFacts, choices: Choices) -> Parameters:
    """Return the parameters of the controller plugin `FollowPath`."""
    makers = {"dwb": _turning, "mppi": mppi, "rpp": _pursuit}
    return makers[choices.controller_for(robot.limits)](robot, choices)


def pruned(robot: RobotFacts, choices: Choices) -> Sourced[float]:
    """Return the length of the path ahead of the robot that a path handler of Nav2 keeps, m."""
    if choices.controller_for(robot.limits) != "mppi":
        return nav2(2.0)
    return path_ahead(robot)


def _turning(robot: RobotFacts, choices: Choices) -> Parameters:
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
        **_dwb(robot, choices),
    }


def _dwb(robot: RobotFacts, choices: Choices) -> Parameters:
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
        "min_vel_x": FORWARD,
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
        "vx_samples": choices.patient(20, 15),
        "vy_samples": Sourced(5 if omni else 1, limits.kinematics.source),
        "vtheta_samples": Sourced(20, example),
        "sim_time": Sourced(SIMULATED, example),
        "linear_granularity": Sourced(0.05, example),
        "angular_granularity": choices.patient(0.025, 0.05),
        **tolerance(choices),
        "xy_goal_tolerance": Sourced(choices.reached().value, "as in the goal checker"),
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


def _pursuit(robot: RobotFacts, choices: Choices) -> Parameters:
    """Return the parameters of the controller regulated pure pursuit."""
    limits = robot.limits
    radius, car = limits.turning_radius, limits.turning_radius.value > 0.0
    turning: Parameters = {
        "use_rotate_to_heading": Sourced(False, limits.kinematics.source),
        "allow_reversing": Sourced(True, "the planner's paths go backward where that is shorter"),
    }
    if not car:
        turning = {
            "use_rotate_to_heading": Sourced(True, radius.source),
            "rotate_to_heading_angular_vel": limits.turn,
            "rotate_to_heading_min_angle": nav2(0.785),
            "max_angular_accel": limits.turn_acceleration,
            "allow_reversing": Sourced(False, radius.source),
        }
    speeds: Parameters = {"desired_linear_vel": limits.speed}
    if choices.distribution.path_handlers:
        speeds = {"max_linear_vel": limits.speed, "max_angular_vel": limits.turn}
    ahead = max(0.6, round(1.2 * radius.value, 2))
    by_radius = f"1.2 times the turning radius ({radius.source}), at least 0.6 m" if car else "RPP's default"
    return {
        "plugin": Sourced(
            "nav2_regulated_pure_pursuit_controller::RegulatedPurePursuitController",
            "follows paths with car-like steering" if car else CHOSEN,
        ),
        **speeds,
        **tolerance(choices),
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
        **turning,
    }
