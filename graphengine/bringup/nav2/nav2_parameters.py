"""Generates Nav2's parameter file for a robot, from the properties of the robot and the choices of the user."""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any, get_args

from graphengine.bringup.nav2.choices import CONTROLLERS, Choices
from graphengine.bringup.nav2.motion_limits import Kinematics
from graphengine.bringup.nav2.parameter_text import parameter_lines
from graphengine.bringup.nav2.robot_facts import RobotFacts
from graphengine.bringup.nav2.sourced import Sourced
from graphengine.bringup.nav2.text_files import TEMPLATES
from graphengine.format.templates import Facts
from graphengine.format.yaml_text import comment
from graphengine.messages.distros import DISTROS

Alphas = tuple[float, float, float, float, float]
CIRCULAR = 0.95
"""Minimum ratio of the inscribed to the circumscribed radius of a circular footprint."""
PADDING = 0.02
"""Distance by which the footprint is enlarged, m."""
CLEARANCE = 0.5
"""Distance by which the inflation radius of obstacles exceeds the robot's circumscribed radius, m."""
GLOBAL_REACH = 3.0
"""Distance up to which lidars add obstacles to the global costmap, m."""
SIMULATED = 1.7
"""Duration of the trajectories that DWB simulates, s."""
HORIZON = 2.8
"""Duration of the trajectories that MPPI simulates, s."""

Values = dict[str, Any]
"""A dict from names in the template to values, as `Sourced` if the template does not name the source."""


def nav2_parameters(robot: RobotFacts, choices: Choices, alphas: Sourced[Alphas] | None, scene: str) -> str:
    """Return the content of nav2_params.yaml.

    Args:
        robot: properties of the robot.
        choices: choices of the user.
        alphas: motion noise of AMCL; None configures slam_toolbox instead of AMCL.
        scene: name of the scene, for the comment in the first line.
    """
    text = (TEMPLATES / "nav2_params.txt").read_text(encoding="utf-8")
    template = [line for line in text.splitlines() if not line.startswith("#")]
    for name in reversed(list(filter(None, robot.namespace.split("/")))):
        template = [f"{name}:", *(f"  {line}" for line in template)]
    values = _values(robot, choices)
    if alphas is not None:
        values |= {f"alpha{number}": Sourced(alpha, alphas.source) for number, alpha in enumerate(alphas.value, 1)}
    lines = parameter_lines(template, values, _facts(robot, choices, slam=alphas is None))
    name = f"Nav2 ({choices.distribution}) for {robot.name} of {scene}"
    head = f"{name}, by `graphrun nav2 files`; comments: sources of values"
    return "\n".join([comment(head), *lines, ""])


def _facts(robot: RobotFacts, choices: Choices, *, slam: bool) -> Facts:
    """Return the facts for the conditions of the template."""
    limits, (inner, outer) = robot.limits, robot.radii
    chosen = {choices.distribution, choices.controller_for(limits), limits.kinematics.value}
    return {
        **{name: name in chosen for name in (*DISTROS, *CONTROLLERS, *get_args(Kinematics))},
        "busy": choices.busy,
        "car": limits.car,
        "circular": inner >= CIRCULAR * outer,
        "round": robot.radius is not None,
        "slam": slam,
    }


def _values(robot: RobotFacts, choices: Choices) -> Values:
    """Return the values of the template, except those that depend on the map."""
    return {
        **_topics(robot),
        **_localization(robot),
        **_costmaps(robot, choices),
        **_motion(robot),
        **_mppi(robot, choices),
        **_pursuit(robot),
        "xy_tolerance": choices.reached(),
        "yaw_tolerance": choices.facing(robot.limits),
    }


def _topics(robot: RobotFacts) -> Values:
    kind = "TwistStamped" if robot.stamped else "Twist"
    return {
        "base_frame": Sourced(robot.base_frame, "child frame of the odometry"),
        "odometry_frame": Sourced(robot.odometry_frame, f"frame of {robot.odometry_topic}"),
        "odometry_topic": Sourced(robot.odometry_topic, "topic that the robot's graph publishes"),
        "command_topic": robot.command_topic,
        "map_topic": robot.topic("map"),
        "stamped": Sourced(robot.stamped, f"{robot.command_topic} takes {kind}"),
    }


def _localization(robot: RobotFacts) -> Values:
    scan, (x, y, yaw) = robot.scans[0], robot.pose
    lidar = f"lidar of {scan.topic}"
    return {
        "scan_topic": Sourced(scan.topic, "LaserScan with the widest field of view"),
        "nearest": Sourced(scan.ranges[0], lidar),
        "farthest": Sourced(scan.ranges[1], lidar),
        "mapped_range": Sourced(min(scan.ranges[1], 40.0), f"{lidar}, at most 40 m"),
        "x": x,
        "y": y,
        "yaw": yaw,
    }


def _costmaps(robot: RobotFacts, choices: Choices) -> Values:
    inner, outer = robot.radii
    corners = ", ".join(f"[{x:.3f}, {y:.3f}]" for x, y in robot.footprint)
    hull = f"convex hull of all colliders on the floor; inscribed {inner:.3f} m, circumscribed {outer:.3f} m"
    simulated = HORIZON if choices.controller_for(robot.limits) == "mppi" else SIMULATED
    side = max(3, math.ceil(2.0 * (simulated * robot.limits.speed.value + outer + 0.3)))
    reach = f"twice the sum of the way driven in {simulated:g} s, the circumscribed radius and 0.3 m; at least 3 m"
    inflation = f"circumscribed radius, padding, and {CLEARANCE:g} m of clearance"
    scans: dict[str, Values] = {}
    for number, scan in enumerate(robot.scans):
        nearest, farthest = scan.ranges
        values = {"topic": Sourced(scan.topic, "topic that the robot's graph publishes"), "min_range": nearest}
        for costmap, distance in (("global", GLOBAL_REACH), ("local", side / 2.0)):
            values[f"{costmap}_obstacles"] = min(distance, farthest)
            values[f"{costmap}_rays"] = min(distance + 0.5, farthest)
        scans[f"scan{number or ''}"] = values
    return {
        "radius": round(outer, 3),
        "footprint": Sourced(f"[{corners}]", hull),
        "padding": PADDING,
        "inflation_radius": Sourced(round(outer + PADDING + CLEARANCE, 2), inflation),
        "local_side": Sourced(side, reach),
        "top": max(2.0, *(math.ceil(scan.height) + 0.0 for scan in robot.scans)),
        "scans": scans,
        "scan_names": list(scans),
        "observed": " ".join(scans),
    }


def _motion(robot: RobotFacts) -> Values:
    """Return the motion limits, also as lists of x, y and yaw, with 0 for y unless the base is omnidirectional."""
    limits = robot.limits
    speed, push, brake, turn_push = limits.speed, limits.acceleration, limits.deceleration, limits.turn_acceleration
    lists = {
        name: Sourced([limit.value, limit.value * limits.omni, turn.value], f"{limit.source}; {turn.source}")
        for name, limit, turn in (
            ("velocities", speed, limits.turn),
            ("accelerations", push, turn_push),
            ("decelerations", brake, turn_push),
        )
    }
    return {
        **{field.name: getattr(limits, field.name) for field in fields(limits)},
        **lists,
        "slowest_turn": 0.2 * limits.turn.value,
        "simulated": SIMULATED,
    }


def _mppi(robot: RobotFacts, choices: Choices) -> Values:
    limits, period = robot.limits, 1.0 / choices.frequency
    ahead = f"way driven in {HORIZON:g} s, and 0.3 m; at least 1.7 m, as in Nav2's parameter file"
    return {
        "time_steps": Sourced(round(HORIZON / period), f"{HORIZON:g} s divided by model_dt"),
        "period": period,
        "backward": -0.5 * limits.speed.value,
        "path_ahead": Sourced(max(1.7, round(HORIZON * limits.speed.value + 0.3, 2)), ahead),
    }


def _pursuit(robot: RobotFacts) -> Values:
    radius = robot.limits.turning_radius
    ahead = max(0.6, round(1.2 * radius.value, 2))
    by_radius = f"1.2 times the turning radius ({radius.source}), at least 0.6 m"
    return {
        "lookahead": Sourced(ahead, by_radius if robot.limits.car else "RPP's default"),
        "farthest_lookahead": 2.0 * ahead,
        "regulated_radius": max(0.9, 1.5 * radius.value),
    }
