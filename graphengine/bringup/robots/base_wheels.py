"""Finds the wheels on which a robot stands, detects casters, and guesses the base if no controller or plugin describes it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from graphengine.bringup.robots.base import Base
from graphengine.bringup.robots.skid_steering import SMALL
from graphengine.descriptions.files.xml import numbers
from graphengine.descriptions.robot_description import TURNING, Joint, RobotDescription
from graphengine.descriptions.robot_files.draft import ALIGNED, Draft, RobotWheel
from graphengine.devices.rotation import Vector3, rotate

_HOLONOMIC = ("mecanum", "omni_wheel", "omniwheel", "omni-wheel")
"""Parts of names of mecanum wheels; parallel wheels with the name of omni wheels can only be mecanum wheels."""
_DIAGONAL = 0.3
"""Minimum ratio of the smaller to the larger component (x, y) of a diagonal direction."""
_TRAIL = 0.1
"""Minimum distance of a caster's axle from the axis of its swivel, as a fraction of the wheel's radius."""
_MIRRORED = 0.1
"""Maximum deviation of a pair of wheels from mirrored positions, as a fraction of the wheel's radius."""


def wheels_on_floor(draft: Draft, commanded: Collection[str]) -> list[RobotWheel]:
    """Return the wheels on which a robot stands, in order of the joints.

    Args:
        draft: draft with the wheels found in the description.
        commanded: names of joints that take commands; such a joint cannot be the swivel of a caster.
    """
    description, axes = draft.description, draft.description.axes_in_root()
    shapes = [shape for shape in draft.wheels.values() if shape.on_floor]
    swivels = {shape.joint: _swivel(description, description.joints[shape.joint], axes) for shape in shapes}
    swivelling = [shape for shape in shapes if swivels[shape.joint] is not None]
    found = list(shapes)
    for number, shape in enumerate(shapes):
        if (swivel := swivels[shape.joint]) is not None:
            pivot = description.pose_in_root(swivel.child)[0]
            caster = swivel.name not in commanded and _is_caster(shape, pivot, swivelling)
            found[number] = replace(shape, swivel=swivel.name, caster=caster)
    return found


def _is_caster(wheel: RobotWheel, pivot: Vector3, others: Iterable[RobotWheel]) -> bool:
    """Return whether a swivelling wheel trails its pivot, or swivels freely without a counterpart among the others."""
    (x, y, _), (pivot_x, pivot_y, _) = wheel.centre, pivot
    trail = abs((x - pivot_x) * wheel.axle[1] - (y - pivot_y) * wheel.axle[0])  # across the axle
    return trail > _TRAIL * wheel.radius or (wheel.swivels and not any(_mirrors(wheel, each) for each in others))


def _mirrors(one: RobotWheel, other: RobotWheel) -> bool:
    """Return whether two wheels stand at mirrored positions left and right of the root link's x axis."""
    (x, y, _), (other_x, other_y, _) = one.centre, other.centre
    near = _MIRRORED * one.radius
    return abs(x - other_x) < near and abs(y + other_y) < near and abs(y) > near


def _swivel(description: RobotDescription, joint: Joint, axes: Mapping[str, Vector3]) -> Joint | None:
    """Return the nearest joint above a wheel's joint that rotates about a vertical axis, or None."""
    turning = (carrier for carrier in description.carriers(joint.parent) if carrier.type in TURNING)
    return next((carrier for carrier in turning if abs(axes[carrier.name][2]) > ALIGNED), None)


def base_of_wheels(draft: Draft, wheels: Sequence[RobotWheel], commanded: Collection[str]) -> Base | None:
    """Return the base that the arrangement of the wheels suggests; None if no graph can drive them.

    Args:
        draft: receives a remark with the reason if no graph can drive the wheels.
        wheels: wheels on the floor.
        commanded: names of joints that take commands; empty if the description does not list them.
    """
    rolling = [wheel for wheel in wheels if not wheel.caster]
    fixed = [wheel for wheel in rolling if not wheel.swivel]
    steered = [wheel for wheel in rolling if wheel.swivel]
    driven = [wheel for wheel in rolling if wheel.joint in commanded] or fixed
    if not driven:
        return None
    driven = driven if steered else _without_casters(driven, commanded)
    span = draft.description.joints[driven[0].joint].element.span
    names = tuple(wheel.joint for wheel in driven)
    if steered:
        pivots = tuple(dict.fromkeys(wheel.swivel for wheel in steered))
        if fixed and len(pivots) <= 2:
            return Base("ackermann", names, pivots, "the wheels, of which some are steered", span, guessed=True)
        count = len(steered)
        which = f"of whose {len(rolling)} wheels {count} are" if fixed else f"whose {count} wheels are all"
        draft.lose(f"a base {which} steered: no graph drives it", span)
        return None
    if all(wheel.sideways for wheel in driven):
        if max(wheel.centre[1] for wheel in driven) - min(wheel.centre[1] for wheel in driven) > driven[0].radius / 2:
            if len(driven) >= 4 and is_mecanum(draft.description, driven):
                return Base("mecanum", names, (), "the wheels, which are mecanum wheels", span, guessed=True)
            return Base("differential", names, (), "the wheels, which are parallel", span, guessed=True)
        draft.lose("wheels on one side only: no graph drives them", span)
        return None
    if len(driven) >= 3 and not all(_parallel(driven[0].axle, wheel.axle) for wheel in driven):
        return Base("omni", names, (), "the wheels, whose axles have several directions", span, guessed=True)
    text = "wheels that do not roll along the x axis of the root link: no graph drives them"
    draft.lose(f"{text}; turn the root link so that its x axis points forward", span)
    return None


def _parallel(one: Vector3, other: Vector3) -> bool:
    return abs(sum(a * b for a, b in zip(one, other, strict=True))) > ALIGNED


def _without_casters(wheels: Sequence[RobotWheel], commanded: Collection[str]) -> list[RobotWheel]:
    """Return the wheels without small uncommanded wheels that roll only sideways, such as balls of casters."""
    limit = SMALL * max(wheel.radius for wheel in wheels)
    return [each for each in wheels if each.sideways or each.joint in commanded or each.radius >= limit]


def is_mecanum(description: RobotDescription, wheels: Sequence[RobotWheel]) -> bool:
    """Return whether wheels are mecanum wheels.

    Mecanum wheels have rollers, or in Gazebo friction, with a diagonal direction; or the name of the robot, or of a wheel's
    joint, link or mesh, contains `mecanum` or `omni_wheel`.
    """
    if any(is_diagonal(wheel.rollers.axis) or friction_direction(description, wheel) is not None for wheel in wheels):
        return True
    return any(word in name.lower() for name in _names(description, wheels) for word in _HOLONOMIC)


def friction_direction(description: RobotDescription, wheel: RobotWheel) -> Vector3 | None:
    """Return the first diagonal friction direction `fdir1` of a wheel in Gazebo, in the root link's frame; None without one."""
    for gazebo in description.element.all("gazebo"):
        if gazebo.get("reference") != wheel.link:
            continue
        for element in (each for each in gazebo.walk() if each.tag == "fdir1"):
            frame = next((value for key, value in element.attributes.items() if key.endswith("expressed_in")), "")
            direction = numbers(element.text or element.get("value"), 3)
            if direction is None or frame not in description.links:
                continue
            turned = rotate(description.pose_in_root(frame)[1], (direction[0], direction[1], direction[2]))
            if is_diagonal(turned):
                return turned
    return None


def is_diagonal(direction: Vector3 | None) -> bool:
    """Return whether a direction is diagonal in the xy plane, like the axis of a mecanum roller."""
    x, y = (abs(part) for part in (direction or (0.0, 0.0))[:2])
    return min(x, y) > _DIAGONAL * max(x, y)


def _names(description: RobotDescription, wheels: Sequence[RobotWheel]) -> Iterator[str]:
    yield description.element.get("name")
    for wheel in wheels:
        meshes = (each.get("filename") for each in description.links[wheel.link].element.walk() if each.tag == "mesh")
        yield from (wheel.joint, wheel.link, *meshes)
