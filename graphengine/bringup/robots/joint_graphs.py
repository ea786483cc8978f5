"""Adds graphs for joints that do not belong to a base: joint states, commands, arms, grippers and legs."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from graphengine.bringup.robots import arm_graph, gripper_graph, legs_graph
from graphengine.bringup.robots.base import Drivetrain
from graphengine.bringup.robots.controllers_file import Controller
from graphengine.descriptions.robot_files.draft import Draft


def fill(draft: Draft, controllers: Sequence[Controller], drivetrain: Drivetrain | None) -> None:
    """Add graphs for all joints with drives that do not belong to the base.

    If there is a base, its graph publishes the states of all joints, so no graph for joint states is added.
    """
    base = {wheel.joint for wheel in drivetrain.wheels} if drivetrain is not None else set()
    base |= {joint.name for joint in drivetrain.steering} if drivetrain is not None else set()
    driven, held = ([name for name in names if name not in base] for names in _drives(draft))
    if not driven:
        return
    if drivetrain is None:
        draft.add_graph("joint_states", "graphs/joint_states.yaml", {})
        legs_graph.fill(draft)
    if legs_graph.GRAPH in draft.sections["graphs"]:  # which commands all joints itself
        return
    draft.commanded = list(driven)
    draft.add_graph("joint_commands", "graphs/joint_commands.yaml", {})
    bolted = draft.fixed_base or not draft.description.moves_freely
    moved = arm_graph.fill(draft, held, controllers, guess=bolted or drivetrain is not None)
    gripper_graph.fill(draft, held, controllers, guess=bool(moved))


def _drives(draft: Draft) -> tuple[Collection[str], Collection[str]]:
    """Return the names of the joints that take commands, and the names of those that take position commands."""
    model = draft.description.mjcf
    if model is not None:
        actuators = {actuator.joint: actuator.kind for actuator in model.actuators}
        driven = [joint.name for joint in draft.description.moving() if joint.name in actuators]
        return driven, [each.joint for each in model.actuators if each.kind == "position" and each.joint in driven]
    drives = {name: entry.value["drive"] for name, entry in draft.sections["joints"].items() if "drive" in entry.value}
    return drives, [name for name, drive in drives.items() if "stiffness" in drive]
