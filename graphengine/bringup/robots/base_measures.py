"""Measures the dimensions of a mobile base on its description, for the parameters of the graph that drives it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from statistics import fmean
from typing import Any

from graphengine.bringup.robots.base import Base, Drivetrain
from graphengine.bringup.robots.base_wheels import friction_direction
from graphengine.bringup.robots.skid_steering import casters, choose_grip, controller_track, effective_track
from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.draft import Draft, Remark, RobotWheel, rounded
from graphengine.devices.rotation import Vector3, rotate

_SAME = 0.005
"""Maximum relative difference of two lengths that count as equal."""
_BESIDE = 1e-3
"""Minimum lateral distance of a left or right wheel from the centre of all wheels, m."""
_LEAST_STEERING = 0.1
"""Minimum steering angle limit of a base, rad; smaller limits of joints are raised to it."""


def measured(draft: Draft, base: Base, wheels: Sequence[RobotWheel]) -> Drivetrain | None:
    """Return the drivetrain of a base; None if no graph can drive it.

    Args:
        draft: receives remarks, among them the reason if no graph can drive the base.
        base: base as its source describes it.
        wheels: wheels on the floor.
    """
    found = {wheel.joint: wheel for wheel in wheels}
    if base.kinematics == "ackermann":
        base = _without_virtual_wheels(draft, base, wheels)
    joints = [joint for joint in dict.fromkeys(base.driven) if draft.description.joints[joint].mimic is None]
    driven = [found.get(joint) or _declared(draft, base, joint) for joint in joints]
    if not driven:
        return _undriven(draft, base, "its wheels only follow other joints")
    if any(wheel.radius <= 0 for wheel in driven):
        return _undriven(draft, base, "the wheels have no round collider that gives their radius")
    driven.sort(key=lambda wheel: (-round(wheel.centre[0], 3), -wheel.centre[1]))
    radius = fmean(wheel.radius for wheel in driven)
    _compare(draft, base, "radius of the wheels", base.radius, radius)
    if base.kinematics == "ackermann":
        return _ackermann(draft, base, driven, wheels)
    if base.kinematics == "differential":
        return _differential(draft, base, driven, wheels, radius)
    if base.kinematics == "mecanum":
        return _mecanum(draft, base, driven)
    if len(driven) >= 3 and not all(wheel.sideways for wheel in driven):
        return _holonomic(draft, base, driven)
    return _undriven(draft, base, "it has fewer than three wheels, or all of them are parallel")


def _undriven(draft: Draft, base: Base, reason: str) -> Drivetrain | None:
    """Add a remark with the reason why no graph can drive a base; return None, as it has no drivetrain."""
    draft.lose(f"{base.source}: {reason}: no graph drives them", base.span)
    return None


def _declared(draft: Draft, base: Base, joint: str) -> RobotWheel:
    """Return the wheel on a joint if this wheel does not stand on the floor.

    A wheel without a round collider gets the radius of the base's source, and the origin of the joint as its centre.
    """
    description = draft.description
    about = description.joints[joint]
    if (known := draft.wheels.get(joint)) is not None:
        return known
    pose = description.pose_in_root(about.child)
    centre, axle = pose[0], rotate(pose[1], about.axis)
    return RobotWheel(joint, about.child, base.radius or 0.0, 0.0, 0.0, axle, centre, "", on_floor=False)


def _compare(draft: Draft, base: Base, what: str, said: float | None, true: float) -> None:
    """Add a remark if the dimension `said` of the source differs from the dimension `true` of the description, both m."""
    if said is not None and abs(said - true) > _SAME * true:
        draft.notice(f"the {what} is {true:.4g} m as in the description; {base.source} has {said:.4g} m", base.span)


def _differential(
    draft: Draft, base: Base, driven: Sequence[RobotWheel], wheels: Sequence[RobotWheel], radius: float
) -> Drivetrain | None:
    left, right = _by_side(driven)
    if not (left and right) or not all(wheel.sideways for wheel in driven):
        return _undriven(draft, base, "its wheels do not stand left and right of the root link's x axis")
    if len(left) != len(right) or not _alike(left) or not _alike(right):
        return _undriven(draft, base, "its wheels on one side differ in number or direction from each other")
    track = fmean(wheel.centre[1] for wheel in left) - fmean(wheel.centre[1] for wheel in right)
    _compare(draft, base, "track", base.track, track)
    parallel = [wheel for wheel in wheels if wheel.sideways and not wheel.swivel and not wheel.caster]
    loose = casters(driven, parallel)
    standing = [*driven, *(wheel for wheel in parallel if wheel not in loose)]
    skids = len({wheel.link for wheel in standing}) > 2  # also if only two of them are driven
    parameters = _sides(left, right, radius) | {
        "wheels_per_side": len(left),
        "radius": rounded(radius),
        "track": rounded(track),
        "center": _centre(driven),
    }
    found = Drivetrain(base, (*left, *right), (), parameters | base.parameters)
    if skids:
        return _skidding(draft, found, standing)
    if base.multiplier != 1.0:
        text = f"{base.source}: the multiplier {base.multiplier:g} of the track is not used: the plain track makes turns exact"
        draft.guess(text, base.span)
    return replace(found, grip={wheel.link: (1.0, 0.0, 0.0) for wheel in loose}) if loose else found


def _skidding(draft: Draft, found: Drivetrain, wheels: Sequence[RobotWheel]) -> Drivetrain:
    """Return the drivetrain of a skid-steered base: `found` with friction of the wheels and with the track of its controller.

    If the source of the base gives its controller a larger track that compensates for skidding, that track is kept. If it does
    not, or if the friction replaces that track, the track is computed with `effective_track`.

    Args:
        draft: receives remarks on the friction and on the track.
        found: drivetrain whose parameter `track` is the distance between left and right wheels, m.
        wheels: all wheels on the floor that do not swivel.
    """
    base, track, ends = found.base, found.parameters["track"], [wheel.centre[0] for wheel in wheels]
    length = max(max(ends) - min(ends), _BESIDE)
    links = list(dict.fromkeys(wheel.link for wheel in wheels))
    middle = (min(wheel.centre[1] for wheel in wheels) + max(wheel.centre[1] for wheel in wheels)) / 2.0
    skid = choose_grip(draft, base, links, track, length, abs(draft.description.centre_of_mass()[1] - middle))
    told = None if skid.replaces_track else controller_track(base, track)
    draft.controller_track = told is not None
    if told is not None:
        product = f"{base.track or track:g} m x {base.multiplier:g}"
        draft.carry(f"track for turns: {told:.4g} m, {product} of {base.source}", base.span)
    turning = effective_track(track, length, skid.across / skid.along) if told is None else told
    text = f"friction of the skid-steered wheels: {skid.along:g} along and {skid.across:g} across them, {skid.reason}"
    (draft.carried if skid.described else draft.guessed).append(Remark(text, base.span))
    grip: dict[str, Vector3] = dict.fromkeys(links, (1.0, 0.0, 0.0))
    parameters = found.parameters | {"track": rounded(turning, 4)}
    return replace(found, parameters=parameters, grip=grip, skid=skid)


def _by_side(wheels: Sequence[RobotWheel]) -> tuple[list[RobotWheel], list[RobotWheel]]:
    """Return the wheels left and right of their common centre, each list in the given order."""
    middle = _centre(wheels)[1]
    left = [wheel for wheel in wheels if wheel.centre[1] > middle + _BESIDE]
    return left, [wheel for wheel in wheels if wheel.centre[1] < middle - _BESIDE]


def _mecanum(draft: Draft, base: Base, driven: Sequence[RobotWheel]) -> Drivetrain | None:
    left, right = _by_side(driven)
    if (len(left), len(right)) != (2, 2) or not (_alike(left) and _alike(right)):
        return _undriven(draft, base, "it does not have two wheels that turn in the same direction on each side")
    found = _holonomic(draft, base, driven)
    ends = [wheel.centre[0] for wheel in driven]
    more = {"track": rounded(_spread(driven)), "wheelbase": rounded(max(ends) - min(ends)), "center": _centre(driven)}
    return replace(found, parameters=found.parameters | more | _sides(left, right, found.parameters["radius"]))


def _holonomic(draft: Draft, base: Base, driven: Sequence[RobotWheel]) -> Drivetrain:
    """Return the drivetrain of a base with mecanum or omni wheels, which grip only along the axes of their rollers."""
    grips = [_grip(draft, wheel, base) for wheel in driven]
    axles = [math.atan2(-wheel.axle[0], wheel.axle[1]) for wheel in driven]  # from the y axis, about z
    rollers = [math.degrees(math.atan2(-g[0], g[1]) - axle) for g, axle in zip(grips, axles, strict=True)]
    parameters = {
        "wheels": [wheel.joint for wheel in driven],
        "positions": [[rounded(value) for value in (*wheel.centre[:2], 0.0)] for wheel in driven],
        "axles": [[rounded(math.cos(axle / 2)), 0, 0, rounded(math.sin(axle / 2))] for axle in axles],
        "rollers": [rounded((angle + 90.0 - 1e-9) % 180.0 - 90.0, 6) for angle in rollers],  # a line has no sign
        "radius": rounded(fmean(wheel.radius for wheel in driven)),
    }
    given = base.parameters.items()
    known = {key: value for key, value in given if "acceleration" not in key and key != "deceleration"}
    grip = {wheel.link: grip for wheel, grip in zip(driven, grips, strict=True) if not wheel.rollers.links}
    return Drivetrain(base, tuple(driven), (), parameters | known, grip)


def _grip(draft: Draft, wheel: RobotWheel, base: Base) -> Vector3:
    """Return the direction along which a mecanum or omni wheel grips: the axis of the roller on the floor, in the root's frame.

    Without rollers in the description, this is the direction in Gazebo's `fdir1`, else a diagonal for a mecanum wheel, and the
    rolling direction for an omni wheel.
    """
    told = wheel.rollers.axis or friction_direction(draft.description, wheel)
    if told is not None:
        return told
    if base.kinematics == "omni":
        return wheel.axle[1], -wheel.axle[0], 0.0
    return 1.0, -math.copysign(1.0, wheel.centre[0] * wheel.centre[1]), 0.0


def _without_virtual_wheels(draft: Draft, base: Base, wheels: Sequence[RobotWheel]) -> Base:
    """Return the base; if its source names joints without wheels, with the joints of wheels on the floor instead.

    Some controllers command virtual wheels in the middle of an axle.
    """
    rolling = [wheel for wheel in wheels if not wheel.caster]
    swivels = dict.fromkeys(wheel.swivel for wheel in rolling if wheel.swivel)
    fixed = [wheel.joint for wheel in rolling if not wheel.swivel]
    joints = {wheel.joint for wheel in rolling}
    if not swivels or not fixed or (set(base.driven) <= joints and set(base.steering) <= swivels.keys()):
        return base
    driven = [joint for joint in base.driven if joint in joints] or fixed
    steering = [joint for joint in base.steering if joint in swivels] or [*swivels]
    names = ", ".join((*driven, *steering))
    draft.guess(f"{base.source} commands joints without wheels: {names} are commanded instead", base.span)
    return replace(base, driven=tuple(driven), steering=tuple(steering))


def _ackermann(
    draft: Draft, base: Base, driven: Sequence[RobotWheel], wheels: Sequence[RobotWheel]
) -> Drivetrain | None:
    description, joints = draft.description, draft.description.joints
    rolling = {wheel.joint: wheel for wheel in (*wheels, *driven) if not wheel.caster}.values()
    steered = [wheel for wheel in rolling if wheel.swivel and wheel.swivel in base.steering]
    fixed = [wheel for wheel in rolling if not wheel.swivel]
    pivots = [joints[name] for name in dict.fromkeys(base.steering) if joints[name].mimic is None]
    pivots.sort(key=lambda joint: -description.pose_in_root(joint.child)[0][1])
    axes = description.axes_in_root()
    upward = {axes[joint.name][2] > 0 for joint in pivots}
    if not pivots or not steered or not fixed or not all(wheel.sideways for wheel in driven):
        return _undriven(draft, base, "no wheels are found on the steering joints, or none beside them")
    if len(upward) > 1:
        return _undriven(draft, base, "its steering joints turn about opposite axes")
    ahead = fmean(wheel.centre[0] for wheel in steered) - fmean(wheel.centre[0] for wheel in fixed)
    sides = [description.pose_in_root(joint.child)[0][1] for joint in pivots]
    _compare(draft, base, "wheelbase", base.wheelbase, abs(ahead))
    if track := _spread(fixed) or _spread(steered):
        _compare(draft, base, "track", base.track, track)
    front, back = (steered, fixed) if ahead > 0 else (fixed, steered)
    back_radius = fmean(wheel.radius for wheel in back)
    left, right = _by_side(fixed)
    first = 0 if any((wheel in steered) == (ahead > 0) for wheel in driven) else 2
    parameters = {
        "wheels": [wheel.joint for wheel in driven],
        "wheel_signs": [wheel.sign for wheel in driven],
        "first_wheel": first,
        "end_wheel": first + len(driven),
        "steering": [joint.name for joint in pivots],
        "steering_multiplier": 1.0 if upward == {True} else -1.0,
        "steered_wheels": len(pivots),
        "rear_steering": ahead < 0,
        "wheelbase": rounded(abs(ahead)),
        "track": rounded(_spread(driven)),
        "steering_track": rounded(max(sides) - min(sides)),
        "steered_axle": rounded(ahead),
        "fixed_track": rounded(max(_spread(fixed), _BESIDE)),
        "front_radius": rounded(fmean(wheel.radius for wheel in front)),
        "back_radius": rounded(back_radius),
        "steering_limit": rounded(_steering_limit(pivots)),
        "center": _centre(fixed),
        **_sides(left or fixed, right or fixed, back_radius),
    }
    return Drivetrain(base, tuple(driven), tuple(pivots), parameters | base.parameters)


def _steering_limit(pivots: Sequence[Joint]) -> float:
    """Return the largest angle that all steering joints reach on both sides, rad; 0 for no limit if no joint has limits."""
    ends = [min(-joint.limits[0], joint.limits[1]) for joint in pivots if joint.limits is not None]
    return max(min(ends), _LEAST_STEERING) if ends else 0.0


def _sides(left: Sequence[RobotWheel], right: Sequence[RobotWheel], radius: float) -> dict[str, Any]:
    """Return the graph parameters of both sides: joints, and multipliers of the wheel radius.

    A multiplier is the mean radius of the wheels divided by `radius`, and negative if their axes point to the right.
    """
    return {
        "left": [wheel.joint for wheel in left],
        "right": [wheel.joint for wheel in right],
        "left_multiplier": _multiplier(left, radius),
        "right_multiplier": _multiplier(right, radius),
    }


def _multiplier(wheels: Sequence[RobotWheel], radius: float) -> float:
    share = fmean(wheel.radius for wheel in wheels) / radius
    return wheels[0].sign * (1.0 if abs(share - 1.0) < _SAME else rounded(share))


def _alike(wheels: Sequence[RobotWheel]) -> bool:
    """Return whether all of these wheels roll in the same direction at positive joint speed."""
    return len({wheel.sign for wheel in wheels}) == 1


def _centre(wheels: Sequence[RobotWheel]) -> list[float]:
    """Return the mean (x, y) of the wheels' centres in the root link's frame, m."""
    return [round(fmean(places), 6) + 0.0 for places in zip(*(wheel.centre[:2] for wheel in wheels), strict=True)]


def _spread(wheels: Sequence[RobotWheel]) -> float:
    sides = [wheel.centre[1] for wheel in wheels]
    return max(sides) - min(sides)
