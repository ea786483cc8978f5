"""The graphs of joints that no base drives: their states, their commands, arms and grippers."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from graphengine.physics.description.urdf import WORLD
from graphengine.physics.importing import arm_graph, gripper_graph
from graphengine.physics.importing.base import Drivetrain
from graphengine.physics.importing.controllers_file import Controller
from graphengine.physics.importing.draft import Draft


def fill(draft: Draft, controllers: Sequence[Controller], drivetrain: Drivetrain | None) -> None:
    """Add the graphs of joints with drives, apart from those of a base."""
    base = {wheel.joint for wheel in drivetrain.wheels} if drivetrain is not None else set()
    base |= {joint.name for joint in drivetrain.steering} if drivetrain is not None else set()
    drives = {name: entry.value.get("drive") for name, entry in draft.sections["joints"].items()}
    driven = [name for name, drive in drives.items() if drive and name not in base]
    held = [name for name in driven if "stiffness" in drives[name]]
    add_graphs(draft, driven, held, controllers, on_base=drivetrain is not None)


def add_graphs(
    draft: Draft, driven: list[str], held: Collection[str], controllers: Sequence[Controller] = (), *, on_base: bool
) -> None:
    """Add the graphs of some joints.

    Args:
        draft: takes the graphs, and remarks on them.
        driven: joints that take commands.
        held: those of them that take positions.
        controllers: of ros2_control.
        on_base: whether the robot has a base, whose graph publishes the states of all joints.
    """
    if not driven:
        return
    draft.commanded = driven
    if not on_base:
        draft.add_graph("joint_states", "graphs/joint_states.yaml", {})
    draft.add_graph("joint_commands", "graphs/joint_commands.yaml", {})
    legs = not (draft.fixed_base or draft.urdf.root == WORLD or on_base)
    moved = arm_graph.fill(draft, held, controllers, guess=not legs)
    gripper_graph.fill(draft, held, controllers, guess=bool(moved))
