"""Chooses how a robot is driven: the drives of its joints, and the graphs of its base, arms and grippers."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from graphengine.bringup.robots.base import Base, Drivetrain
from graphengine.bringup.robots.base_graph import add_base_graph
from graphengine.bringup.robots.base_measures import measured
from graphengine.bringup.robots.base_sources import base_of_controllers, base_of_plugins, topics_of_plugins
from graphengine.bringup.robots.base_wheels import base_of_wheels, is_diagonal, wheels_on_floor
from graphengine.bringup.robots.controllers_file import Controller, controllers
from graphengine.bringup.robots.joint_commands import joint_commands
from graphengine.bringup.robots.joint_drives import add_drives
from graphengine.bringup.robots.joint_graphs import add_joint_graphs
from graphengine.descriptions.robot_description import WORLD
from graphengine.descriptions.robot_files.default_drives import stated_kind
from graphengine.descriptions.robot_files.draft import Draft, RobotWheel
from graphengine.format.wording import printable

_ACROSS = 0.7
"""Maximum cosine of the angle between the y axis of the root link and the axle of a wheel that rolls across the x axis."""
_SLIPPERY = 0.1
"""Friction coefficient below which wheels cannot accelerate a base by 1 m/s2."""


def add_drivetrain(draft: Draft) -> None:
    """Add the drives and graphs of the joints, and the materials of a base's wheels, to the draft."""
    known = controllers(draft)
    commands = joint_commands(draft, known)
    commanded = {joint for joint, each in commands.items() if each.ranges} or _driven_in_stage(draft)
    wheels = wheels_on_floor(draft, commanded)
    drivetrain = None
    if not draft.fixed_base:
        bases = (base for base in _bases(draft, known, wheels, commanded) if not _rolls_aside(draft, base, wheels))
        tried = (measured(draft, base, _sliding(base, wheels)) for base in bases)
        drivetrain = next((found for found in tried if found is not None), None)
    if drivetrain is not None:
        _mark_dragging(draft, drivetrain)
        add_base_graph(draft, drivetrain)
    if draft.description.mjcf is None:  # the actuators of an MJCF are its drives
        add_drives(draft, commands, wheels, drivetrain)
    add_joint_graphs(draft, known, drivetrain)
    _tell_fixed(draft, wheels)
    if drivetrain is None and draft.description.mjcf is None:
        _tell_undriven(draft, efforts=[joint for joint, each in commands.items() if "effort" in each.ranges])


def _driven_in_stage(draft: Draft) -> set[str]:
    """Return the names of joints that drives of a USD stage move: those that take velocities, and those that may steer wheels.

    Importers give position drives to wheels too, so these say nothing.
    """
    usd, joints = draft.description.usd, draft.description.joints
    drives = usd.drives.items() if usd is not None else ()
    kinds = {name: told[0] for name, stated in drives if (told := stated_kind(joints[name], stated)) is not None}
    turning = {name for name, kind in kinds.items() if kind == "position" and "caster" not in name.lower()}
    return {name for name, kind in kinds.items() if kind == "velocity"} | (turning - draft.wheels.keys())


def _mark_dragging(draft: Draft, drivetrain: Drivetrain) -> None:
    """Mark wheels without a drive that roll across the driving direction of a base with fixed wheels, the root link's x axis."""
    if not all(wheel.sideways for wheel in drivetrain.wheels):
        return
    driven = {wheel.joint for wheel in drivetrain.wheels}
    for joint, shape in draft.wheels.items():
        if joint not in driven and not shape.swivels and not shape.rollers.links and abs(shape.axle[1]) < _ACROSS:
            draft.wheels[joint] = replace(shape, drags=True)


def _rolls_aside(draft: Draft, base: Base, wheels: Sequence[RobotWheel]) -> bool:
    """Return whether a differential base would slide aside on mecanum rollers; if so, add a remark."""
    rolling = [wheel for wheel in wheels if wheel.joint in base.driven and is_diagonal(wheel.rollers.axis)]
    if base.kinematics != "differential" or not rolling:
        return False
    text = "its wheels have diagonal rollers, on which a differential base would slide aside"
    draft.lose(f"{base.source}: {text}", base.span)
    return True


def _sliding(base: Base, wheels: Sequence[RobotWheel]) -> list[RobotWheel]:
    """Return the wheels that slide in sideways motion: the wheels of the base, and all other wheels without rollers."""
    return [wheel for wheel in wheels if wheel.joint in base.driven or not wheel.rollers.links]


def _tell_fixed(draft: Draft, wheels: Sequence[RobotWheel]) -> None:
    """Add a remark if fixed joints connect a base on wheels to the link `world`; its wheels then cannot move the base."""
    rolling = [wheel for wheel in wheels if not wheel.caster]
    if draft.description.root != WORLD or len(rolling) < 2:
        return
    above = list(draft.description.carriers(draft.description.joints[rolling[0].joint].parent))
    if above and all(carrier.type == "fixed" for carrier in above):
        first = above[-1]
        text = f"joint {first.name} fixes the base to the link {WORLD!r}, so its wheels do not move it"
        text += "; without this link it is free"
        draft.notice(text, first.element.span)


def _tell_undriven(draft: Draft, efforts: Sequence[str]) -> None:
    """Add a remark if no joint of a free robot, or of a fixed robot with moving joints, has a drive.

    Args:
        draft: receives the remark.
        efforts: names of the joints that take effort commands.
    """
    moving = draft.description.moving()
    if any("drive" in entry.value for entry in draft.joints.values()):
        return
    if not (draft.fixed_base or draft.description.root == WORLD):
        joints = "its joints have no drives" if moving else "none of its joints moves"
        text = f"nothing moves or holds the robot: {joints}, and no wheels that drive a base were found"
    elif moving:
        text = "nothing moves or holds the robot's joints: they have no drives"
    else:
        return
    if efforts:
        text += "; --position-drives holds joints that take efforts"
    draft.notice(text, draft.description.links[draft.description.root].element.span)


def _bases(
    draft: Draft, known: Sequence[Controller], wheels: Sequence[RobotWheel], commanded: Collection[str]
) -> Iterator[Base]:
    """Yield the bases that controllers, Gazebo plugins, and the wheels on the floor describe, in this order."""
    topics = topics_of_plugins(draft)
    if (base := base_of_controllers(draft, known)) is not None:
        yield base.with_parameters(topics)
    if (base := base_of_plugins(draft)) is not None:
        yield base
    if (base := base_of_wheels(draft, wheels, commanded)) is not None:
        if draft.pushed:
            _drop_slippery(draft, {wheel.link for wheel in wheels if wheel.joint in base.driven})
        yield base.with_parameters(topics)


def _drop_slippery(draft: Draft, links: Collection[str]) -> None:
    """Unbind driven wheels from materials that are too slippery for driving, and add a remark."""
    dropped: dict[str, float] = {}
    for name, entry in [*draft.materials.items()]:
        friction, bound = entry.value["dynamic_friction"], entry.value["bind"]
        slippery = [link for link in bound if link in links]
        if friction >= _SLIPPERY or not slippery:
            continue
        dropped |= dict.fromkeys(slippery, friction)
        draft.unbind(name, links)
    for friction in sorted(set(dropped.values())):
        names = ", ".join(printable(link) for link, each in dropped.items() if each == friction)
        text = f"friction {friction:g} of {names}: a plugin drags these wheels over the floor, but wheels that drive need grip"
        draft.lose(text)
