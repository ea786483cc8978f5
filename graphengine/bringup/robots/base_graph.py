"""Adds the graph that drives a mobile base to the robot file, and materials with the friction of its wheels."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from graphengine.bringup.robots.base import Drivetrain
from graphengine.bringup.robots.skid_steering import NAME, guess_limits
from graphengine.descriptions.robot_files.draft import Claim, Draft, RobotWheel, graph_defaults, rounded
from graphengine.descriptions.robot_files.entries import Entry, MaterialKeys, material
from graphengine.devices.rotation import Vector3
from graphengine.physics.dynamics.command_limits import FASTEST_WHEEL

GRAPH = "base"
"""Name of the base's graph in the robot file."""
_USUAL = (
    *("cmd_vel", "odom", "odom_frame", "joint_states", "center", "wheels_per_side", "axles", "rollers"),
    *("left_multiplier", "right_multiplier", "steering_multiplier"),
    *("rear_steering", "steered_wheels", "first_wheel", "end_wheel"),
)
"""Parameters that are not written to the robot file if they have the default value of the graph."""
_LIMITS = (("speed", "m/s"), ("turn", "rad/s"), ("acceleration", "m/s2"), ("turn_acceleration", "rad/s2"))
_SLIP = 0.01
"""Standard deviation of the distance that a wheel rolls in 1 m, as a fraction of the track."""
_ROLLER_ALONG = 1.0
"""Friction of a roller along its axis."""


def add_base_graph(draft: Draft, drivetrain: Drivetrain) -> None:
    """Add the graph that drives the base, and materials for wheels that slide in one direction."""
    base = drivetrain.base
    use = f"graphs/base/{base.kinematics}.yaml"
    defaults = graph_defaults(use)
    parameters = drivetrain.parameters | _odometry(drivetrain)
    guessed: dict[str, float] = {}
    if drivetrain.skid is not None:
        slowest, fastest = _slowest_wheel(draft, drivetrain)
        guessed = guess_limits(draft, drivetrain.skid, drivetrain.parameters, fastest * slowest.radius)
    parameters |= guessed | _limits_of_wheels(draft, drivetrain, defaults | guessed)
    usual = {name: defaults.get(name) for name in _USUAL}
    parameters = {name: value for name, value in parameters.items() if usual.get(name) != value}
    draft.add_graph(GRAPH, use, parameters, f"{base.kinematics}, from {base.source}")
    claim: Claim = {("graphs", GRAPH): draft.graphs[GRAPH].value}
    draft.remark(f"base: {_summary(drivetrain)}, from {base.source}", base.span, claim, guessed=base.guessed)
    _remark_on_defaults(draft, defaults, parameters)
    _grip(draft, drivetrain)


def _odometry(drivetrain: Drivetrain) -> dict[str, float]:
    """Return the graph's parameter for wheel slip, because no description gives one; empty for omni bases.

    The slip is proportional to the track: on robots of any size, the heading drifts by 0.8 degrees per metre. The covariances
    that the graph publishes include this drift.
    """
    track = drivetrain.parameters.get("track")
    if not isinstance(track, float) or drivetrain.base.kinematics == "omni":
        return {}
    return {"slip": round(_SLIP * track, 5)}


def _limits_of_wheels(draft: Draft, drivetrain: Drivetrain, defaults: Mapping[str, Any]) -> dict[str, float]:
    """Return lower limits for the graph if the velocity limits of the wheels' joints require them, and add a remark.

    Only defaults of the graph are lowered, not limits of the base's source. The result is empty if the wheels are fast enough,
    and for cars, because their graph has no such limits.

    Args:
        draft: receives the remark.
        drivetrain: drivetrain of the base.
        defaults: default values of the graph's parameters.
    """
    if not {"speed", "turn"} <= defaults.keys():
        return {}
    known, lever = drivetrain.parameters, _lever(drivetrain)
    slowest, fastest = _slowest_wheel(draft, drivetrain)
    rim = fastest * slowest.radius
    speed, turn = (known.get(name, defaults[name]) or math.inf for name in ("speed", "turn"))
    if speed + turn * lever <= rim:
        return {}
    found = {"wheel_speed": rim / known["radius"], "speed": min(speed, rim), "turn": min(turn, rim / lever)}
    text = f"wheels that turn at {fastest:g} rad/s at most: the base drives straight at up to {rim:.3g} m/s, "
    text += f"or turns on the spot at up to {rim / lever:.3g} rad/s; the graph scales faster commands down"
    limits = {name: rounded(value) for name, value in found.items() if name not in known}
    claim: Claim = {("graphs", GRAPH, "parameters", name): value for name, value in limits.items()}
    draft.carry(text, draft.description.joints[slowest.joint].element.span, claim)
    return limits


def _slowest_wheel(draft: Draft, drivetrain: Drivetrain) -> tuple[RobotWheel, float]:
    """Return the driven wheel with the slowest rim at the velocity limit of its joint, and this limit, rad/s."""
    joints = draft.description.joints
    speeds = {each: min(joints[each.joint].velocity or FASTEST_WHEEL, FASTEST_WHEEL) for each in drivetrain.wheels}
    slowest = min(speeds, key=lambda wheel: speeds[wheel] * wheel.radius)
    return slowest, speeds[slowest]


def _lever(drivetrain: Drivetrain) -> float:
    """Return the ratio of a wheel's rim speed to the turn rate while the base turns on the spot, m."""
    known = drivetrain.parameters
    if "track" in known:
        return float(known["track"] + known.get("wheelbase", 0.0)) / 2
    x, y = (sum(wheel.centre[axis] for wheel in drivetrain.wheels) / len(drivetrain.wheels) for axis in (0, 1))
    return max(math.hypot(wheel.centre[0] - x, wheel.centre[1] - y) for wheel in drivetrain.wheels)


def _remark_on_defaults(draft: Draft, defaults: Mapping[str, Any], parameters: Mapping[str, Any]) -> None:
    """Add remarks on speed limits and odometry errors with default values, because the description gives none."""
    left = [f"{name} {defaults[name]:g} {unit}" for name, unit in _LIMITS if name in {*defaults} - {*parameters}]
    if left:
        draft.guess(f"limits of the base: {', '.join(left)}")
    if "slip" in parameters:
        ticks = f"encoders of {defaults['ticks']:g} ticks a turn"
        draft.guess(f"odometry: {ticks}, and a slip of {parameters['slip']:g} m after 1 m")


def _summary(drivetrain: Drivetrain) -> str:
    """Return a one-line summary of the kinematics and dimensions of a base."""
    known = drivetrain.parameters
    names = ("radius", "track", "wheelbase")
    measures = [f"{name} {known[name]:g} m" for name in names if isinstance(known.get(name), float)]
    kind = drivetrain.base.kinematics
    told = "skid-steered" if drivetrain.skid is not None else kind
    return ", ".join([f"{told} with {len(drivetrain.wheels)} driven wheels", *measures])


def _grip(draft: Draft, drivetrain: Drivetrain) -> None:
    """Bind wheels that slide in one direction to materials with directed friction, instead of materials without direction."""
    groups: dict[Vector3, list[str]] = {}
    for link, direction in drivetrain.grip.items():
        groups.setdefault(direction, []).append(link)
    materials, skid = draft.materials, drivetrain.skid
    for name, entry in [*materials.items()]:
        if skid is not None or "direction" not in entry.value:
            draft.unbind(name, drivetrain.grip)
    bound = draft.bound()
    for number, (direction, group) in enumerate(groups.items()):
        if not bound.keys().isdisjoint(group):
            continue
        along, across, rule = _ROLLER_ALONG, 0.0, "min"
        name, comment = f"rollers_{number + 1}", "they grip along the axes of their rollers"
        if skid is not None:
            along, across, rule = skid.along, skid.across, "min" if skid.described else "max"
            name, comment = NAME, f"they slide sideways in a turn; friction {skid.reason}"
        elif drivetrain.base.kinematics == "differential":
            name, comment = "casters", "they slide sideways, as casters do"
        directed: MaterialKeys = {
            "across": across,
            "direction": [rounded(part, 6) for part in direction],
            "expressed_in": draft.description.root,
        }
        if skid is not None:
            directed["steady_sliding"] = True
        materials[name] = Entry(material(along, rule, group, directed), [comment])
