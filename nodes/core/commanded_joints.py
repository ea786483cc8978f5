"""Lints of commands: joints that two graphs command, and commands that joints without a drive ignore."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from graphengine.compiler.lint_registry import lint
from graphengine.format.errors import GraphError, PrimError
from graphengine.format.wording import listing
from graphengine.nodes.core.articulation import IsaacArticulationController

if TYPE_CHECKING:
    from graphengine.compiler.graph import Graph, Instance
    from graphengine.compiler.lint_registry import LintContext
    from graphengine.devices.stage import Prim

_KINDS = {"position_command": "stiffness", "velocity_command": "damping", "effort_command": ""}
"""Commands, and the gain of a drive without which each has no effect."""


@dataclass(frozen=True, slots=True)
class _Command:
    """What a controller commands."""

    graph: Graph
    instance: Instance
    robot: Prim
    joints: tuple[str, ...]
    kinds: tuple[str, ...]


@lint("W207")
def lint_joints_commanded_twice(context: LintContext) -> None:
    """Joints whose targets two graphs set; the graph that runs last wins."""
    first: dict[tuple[str, str, str], _Command] = {}
    for command in _commands(context):
        others: dict[int, tuple[_Command, dict[str, None]]] = {}
        for joint, kind in ((joint, kind) for joint in command.joints for kind in command.kinds):
            other = first.setdefault((command.robot.path, joint, kind), command)
            if other.graph is not command.graph:
                others.setdefault(id(other), (other, {}))[1][joint] = None
        for other, joints in others.values():
            context.findings.add(
                "W207",
                f"{command.graph.name}/{command.instance.id} and {other.graph.name}/{other.instance.id} "
                f"command the same joints of {command.robot.path}",
                command.instance.span,
                listing(joints, "joints"),
                "the later command of a tick wins; remove one, or give each its own jointNames",
                related=[(other.instance.span, "the other one")],
            )


@lint("W209")
def lint_commands_without_drive(context: LintContext) -> None:
    """Targets of joints that have no drive to follow them."""
    for command in _commands(context):
        drives = {p.facts["joint"]: p.facts["drive"] for p in command.robot.descendants() if p.kind == "joint"}
        gains = [_KINDS[kind] for kind in command.kinds]
        idle = [j for j in command.joints if not any(not gain or getattr(drives.get(j), gain, 0.0) for gain in gains)]
        if idle and gains:
            node, robot = command.instance, command.robot.path
            message = f"{node.id} commands joints of {robot} that have no drive for it: nothing moves"
            way = f"give them a drive with {' or '.join(gains)} below `joints:` of the robot file, or command efforts"
            context.findings.add("W209", message, node.span, listing(idle, "joints"), way, related=node.entry.via)


def _commands(context: LintContext) -> Iterator[_Command]:
    """Controllers that run, as far as their robot and joints are known before the run."""
    for graph, instance, node in context.nodes(IsaacArticulationController):
        index, wires = instance.index, graph.data_wires
        wired = {wire.target_field for wire in wires if wire.target == index}
        if index not in graph.plan.order or ({"joint_names", "joint_indices"} & wired and not node.joint_names):
            continue
        try:
            robot = context.stage.stands_for_robot(context.stage.find(node.prim()))
            joints: tuple[str, ...] = robot.facts.get("joints", ()) if robot else ()
            chosen = node.joint_names or tuple(joints[number] for number in node.joint_indices) or joints
        except (PrimError, GraphError, IndexError):  # reported by the dry setup
            continue
        kinds = tuple(kind for kind in _KINDS if kind in wired or len(getattr(node, kind)))
        if robot is not None:
            yield _Command(graph, instance, robot, tuple(chosen), kinds)
