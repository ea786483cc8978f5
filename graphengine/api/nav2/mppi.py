"""Computes the parameters of Nav2's controller MPPI."""

from __future__ import annotations

from typing import Any

from graphengine.api.nav2.choices import Choices
from graphengine.api.nav2.parameter_text import Parameters
from graphengine.api.nav2.planning import FORWARD, HORIZON, tolerance
from graphengine.api.nav2.robot_facts import RobotFacts
from graphengine.api.nav2.sourced import Sourced, nav2

_MODELS = {
    "differential": ("DiffDrive", "diff_drive"),
    "omni": ("Omni", "omni"),
    "ackermann": ("Ackermann", "ackermann"),
}
"""Names of MPPI's motion models: up to Kilted, and since Lyrical."""
_CIRCULAR = 0.95
"""A footprint is a circle if its inscribed radius is at least this share of its circumscribed radius."""


def path_ahead(robot: RobotFacts) -> Sourced[float]:
    """Return the length of the path ahead of the robot that MPPI needs, m."""
    reach = round(HORIZON * robot.limits.speed.value + 0.3, 2)
    return Sourced(
        max(1.7, reach), f"way driven in {HORIZON:g} s, and 0.3 m; at least 1.7 m, as in Nav2's parameter file"
    )


def mppi(robot: RobotFacts, choices: Choices) -> Parameters:
    """Return the parameters of the controller: limits, sampling and critics."""
    limits = robot.limits
    car, omni = limits.turning_radius.value > 0.0, limits.kinematics.value == "omni"
    period = 1.0 / choices.frequency
    critics = {name: values for name, values in _critics(robot).items() if omni or name != "TwirlingCritic"}
    return {
        "plugin": Sourced("nav2_mppi_controller::MPPIController", "--controller"),
        "time_steps": Sourced(round(HORIZON / period), f"{HORIZON:g} s divided by model_dt"),
        "model_dt": Sourced(period, "period of the controller"),
        "batch_size": choices.patient(2000, 1000),
        "ax_max": limits.acceleration,
        "ax_min": Sourced(-limits.deceleration.value, limits.deceleration.source),
        "ay_max": limits.acceleration,
        "ay_min": Sourced(-limits.deceleration.value, limits.deceleration.source),
        "az_max": limits.turn_acceleration,
        "vx_std": nav2(0.2),
        "vy_std": nav2(0.2),
        "wz_std": nav2(0.4),
        "vx_max": limits.speed,
        "vx_min": Sourced(-0.5 * limits.speed.value, "half of the speed") if car else FORWARD,
        "vy_max": limits.speed if omni else Sourced(0.0, limits.kinematics.source),
        "wz_max": limits.turn,
        "iteration_count": nav2(1),
        "temperature": nav2(0.3),
        "gamma": nav2(0.015),
        **_motion_model(robot, choices),
        "visualize": Sourced(False, "saves processor time"),
        "regenerate_noises": nav2(True),
        "critics": nav2(list(critics)),
        **critics,
    }


def _motion_model(robot: RobotFacts, choices: Choices) -> Parameters:
    limits = robot.limits
    old, new = _MODELS[limits.kinematics.value]
    radius: Parameters = {"min_turning_r": limits.turning_radius} if limits.turning_radius.value > 0.0 else {}
    if choices.distribution.path_handlers:
        model: Parameters = {"plugin": nav2(f"mppi::{old}MotionModel"), **radius}
        return {"motion_model": Sourced(new, limits.kinematics.source), new: model}
    return {
        "motion_model": Sourced(old, limits.kinematics.source),
        **tolerance(choices),
        "prune_distance": path_ahead(robot),
        **({"AckermannConstraints": radius} if radius else {}),
    }


def _critics(robot: RobotFacts) -> dict[str, Parameters]:
    """Return the parameters of the critics, whose weights are those of Nav2's own parameter file."""

    def enabled(**values: Any) -> Parameters:
        return {name: nav2(value) for name, value in {"enabled": True, **values}.items()}

    def weighed(weight: float, **more: Any) -> Parameters:
        return enabled(cost_power=1, cost_weight=weight, **more)

    inner, outer = robot.radii
    circle = inner >= _CIRCULAR * outer
    return {
        "ConstraintCritic": weighed(4.0),
        "CostCritic": {
            **weighed(3.81, near_collision_cost=253, critical_cost=300.0, collision_cost=1000000.0),
            "consider_footprint": Sourced(
                not circle, "the footprint is a circle" if circle else "the footprint is no circle"
            ),
            "near_goal_distance": nav2(1.0),
            "trajectory_point_step": nav2(2),
        },
        "GoalCritic": weighed(5.0, threshold_to_consider=1.4),
        "GoalAngleCritic": weighed(3.0, threshold_to_consider=0.5),
        "PathAlignCritic": weighed(
            14.0,
            max_path_occupancy_ratio=0.05,
            trajectory_point_step=4,
            threshold_to_consider=0.5,
            offset_from_furthest=20,
            use_path_orientations=False,
        ),
        "PathFollowCritic": weighed(5.0, offset_from_furthest=5, threshold_to_consider=1.4),
        "PathAngleCritic": weighed(
            2.0, offset_from_furthest=4, threshold_to_consider=0.5, max_angle_to_furthest=1.0, mode=0
        ),
        "PreferForwardCritic": weighed(5.0, threshold_to_consider=0.5),
        "TwirlingCritic": enabled(twirling_cost_power=1, twirling_cost_weight=10.0),
    }
