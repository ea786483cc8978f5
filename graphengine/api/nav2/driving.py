"""Computes the Nav2 parameters for driving: controller server, behaviors, velocity smoother and collision monitor."""

from __future__ import annotations

from graphengine.api.nav2.choices import Choices
from graphengine.api.nav2.controllers import follow_path, pruned
from graphengine.api.nav2.parameter_text import Parameters, node
from graphengine.api.nav2.planning import TOLERANCE
from graphengine.api.nav2.robot_facts import MAP_FRAME, RobotFacts
from graphengine.api.nav2.sourced import Sourced, nav2


def driving(robot: RobotFacts, choices: Choices) -> Parameters:
    """Return the parameters of controller_server, behavior_server, velocity_smoother and collision_monitor."""
    return {
        "controller_server": node(_controller(robot, choices)),
        "behavior_server": node(_behaviors(robot, choices)),
        "velocity_smoother": node(_smoother(robot)),
        "collision_monitor": node(_monitor(robot, choices)),
    }


def _stamped(robot: RobotFacts) -> Parameters:
    kind = "TwistStamped" if robot.stamped else "Twist"
    return {"enable_stamped_cmd_vel": Sourced(robot.stamped, f"{robot.command_topic} takes {kind}")}


def _controller(robot: RobotFacts, choices: Choices) -> Parameters:
    car = robot.limits.turning_radius.value > 0.0
    handler: Parameters = {}
    if choices.distribution.path_handlers:
        handler = {
            "path_handler_plugins": nav2(["PathHandler"]),
            "PathHandler": {
                "plugin": nav2("nav2_controller::FeasiblePathHandler"),
                "prune_distance": pruned(robot, choices),
                "enforce_path_inversion": Sourced(
                    car, "a car stops where its path changes direction" if car else "not needed: the robot is no car"
                ),
            },
        }
    return {
        **_stamped(robot),
        "odom_topic": Sourced(robot.odometry_topic, "topic that the robot's graph publishes"),
        "controller_frequency": choices.patient(20.0, choices.frequency),
        "costmap_update_timeout": choices.patient(0.3, 2.0),
        "failure_tolerance": choices.patient(0.3, 2.0),
        "min_x_velocity_threshold": nav2(0.001),
        "min_y_velocity_threshold": _sideways_threshold(robot),
        "min_theta_velocity_threshold": nav2(0.001),
        "progress_checker_plugins": nav2(["progress_checker"]),
        "progress_checker": {
            "plugin": Sourced("nav2_controller::PoseProgressChecker", "counts turning on the spot as progress, too"),
            "required_movement_radius": nav2(0.5),
            "required_movement_angle": nav2(0.5),
            "movement_time_allowance": choices.patient(10.0, 15.0),
        },
        "goal_checker_plugins": nav2(["general_goal_checker"]),
        "general_goal_checker": {
            "plugin": nav2("nav2_controller::SimpleGoalChecker"),
            "xy_goal_tolerance": choices.reached(),
            "yaw_goal_tolerance": choices.facing(robot.limits),
            "stateful": nav2(True),
        },
        **handler,
        "controller_plugins": nav2(["FollowPath"]),
        "FollowPath": follow_path(robot, choices),
    }


def _sideways_threshold(robot: RobotFacts) -> Sourced[float]:
    """Return the sideways velocity in the odometry below which Nav2's controller assumes zero, m/s."""
    omni = robot.limits.kinematics.value == "omni"
    return Sourced(0.001, robot.limits.kinematics.source) if omni else nav2(0.5)


def _behaviors(robot: RobotFacts, choices: Choices) -> Parameters:
    limits = robot.limits
    accelerations: Parameters = {}
    if choices.distribution.limited_behaviors:
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
        "transform_tolerance": choices.patient(0.1, TOLERANCE),
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


def _monitor(robot: RobotFacts, choices: Choices) -> Parameters:
    sources = {f"scan{number or ''}": scan for number, scan in enumerate(robot.scans)}
    return {
        **_stamped(robot),
        "base_frame_id": Sourced(robot.base_frame, "child frame of the odometry"),
        "odom_frame_id": Sourced(robot.odometry_frame, f"frame of {robot.odometry_topic}"),
        "cmd_vel_in_topic": Sourced("cmd_vel_smoothed", "output of velocity_smoother"),
        "cmd_vel_out_topic": Sourced(robot.command_topic, "topic to which the robot's graph subscribes"),
        "state_topic": nav2("collision_monitor_state"),
        "transform_tolerance": choices.patient(0.2, TOLERANCE),
        "source_timeout": choices.patient(1.0, 5.0),
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
