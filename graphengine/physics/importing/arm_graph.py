"""The graphs of joints that no base drives: their states, their commands, and the trajectories of arms."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.diagnostics import Span
from graphengine.format.wording import did_you_mean, printable
from graphengine.physics.description.urdf import WORLD
from graphengine.physics.importing.arm_chains import arm_chains
from graphengine.physics.importing.base import Drivetrain
from graphengine.physics.importing.controllers_file import Controller
from graphengine.physics.importing.draft import Draft, Entry, Remark

TRAJECTORY = "graphs/arm/trajectory.yaml"
"""The graph of an arm."""
STATES, COMMANDS = "joint_states", "joint_commands"
"""Names of the graphs of joints in the robot file."""
CONTROLLER = "joint_trajectory_controller"
"""Name of the controller in the graph of an arm, unless a parameter names another."""


@dataclass(frozen=True, slots=True)
class Arm:
    """An arm as a source describes it.

    Attributes:
        controller: name of the controller whose actions and topics move it.
        joints: from its base to its flange, or in the controller's order.
        source: what says so, for people.
        span: its place.
        parameters: further parameters of its graph.
        guessed: whether nothing but the chain of joints says so.
    """

    controller: str
    joints: tuple[str, ...]
    source: str
    span: Span | None
    parameters: dict[str, Any] = field(default_factory=dict)
    guessed: bool = False


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
        _add(draft, STATES, f"graphs/{STATES}.yaml", {})
    _add(draft, COMMANDS, f"graphs/{COMMANDS}.yaml", {})
    arms = list(_of_controllers(draft, controllers, held))
    if not arms and (draft.fixed_base or draft.urdf.root == WORLD or on_base):
        arms = list(_of_chains(draft, held))
    for arm in arms:
        _add_arm(draft, arm, "arm" if len(arms) == 1 else arm.controller.removesuffix("_controller"))


def _add(draft: Draft, name: str, use: str, parameters: dict[str, Any], *comments: str) -> None:
    parameters = {"base": draft.urdf.root} | parameters
    if parameters["base"] == "base_link":  # the graph's default
        del parameters["base"]
    value: dict[str, Any] = {"use": use} | ({"parameters": parameters} if parameters else {})
    draft.sections["graphs"][name] = Entry(value, list(comments))


def _add_arm(draft: Draft, arm: Arm, name: str) -> None:
    controller = {"controller": arm.controller} if arm.controller != CONTROLLER else {}
    parameters = controller | {"joints": list(arm.joints)} | arm.parameters
    _add(draft, printable(name), TRAJECTORY, parameters, f"{len(arm.joints)} joints, from {arm.source}")
    text = f"arm: trajectories of {len(arm.joints)} joints on {printable(arm.controller)}, from {arm.source}"
    (draft.guessed if arm.guessed else draft.carried).append(Remark(text, arm.span))


def _of_controllers(draft: Draft, controllers: Iterable[Controller], held: Collection[str]) -> Iterator[Arm]:
    """The arms of the trajectory controllers whose joints the description has."""
    for controller in controllers:
        word = controller.type.rpartition("/")[2]
        if not word.endswith("JointTrajectoryController"):
            continue
        joints, source = controller.texts("joints"), printable(f"{word} {controller.name}")
        if reason := _flaw(draft, joints, held):
            draft.lost.append(Remark(f"{source}: {reason}", controller.span))
        else:
            yield Arm(controller.name, joints, source, controller.span, _parameters(controller, joints))


def _flaw(draft: Draft, joints: Sequence[str], held: Collection[str]) -> str:
    """Why a controller cannot move some joints; empty if it can."""
    for name in joints:
        if name not in draft.urdf.joints:
            near = did_you_mean(name, draft.urdf.joints)
            return f"the description has no joint {printable(name)!r}" + (f"; {near}" if near else "")
        if name not in held:
            return f"joint {printable(name)!r} has no drive that takes positions"
    return "" if joints else "it names no joints"


def _parameters(controller: Controller, joints: Sequence[str]) -> dict[str, Any]:
    """The constraints of a controller as parameters of the graph; those with the controller's defaults are left out."""
    tolerances = {
        f"{graph}_tolerances": [controller.positive(f"constraints.{joint}.{kind}") or 0.0 for joint in joints]
        for graph, kind in (("path", "trajectory"), ("goal", "goal"))
    }
    found: dict[str, Any] = {name: values for name, values in tolerances.items() if any(values)}
    for name, parameter in (("goal_time", "goal_time"), ("stopped_velocity", "stopped_velocity_tolerance")):
        number = controller.number(f"constraints.{parameter}")
        if number is not None:
            found[name] = max(number, 0.0)
    if controller.flag("allow_partial_joints_goal", default=False):
        found["partial"] = True
    return found


def _of_chains(draft: Draft, held: Collection[str]) -> Iterator[Arm]:
    """The arms as chains of joints suggest them."""
    arms = arm_chains(draft.urdf, held)
    names = [_common_words(arm) or f"arm_{number}" for number, arm in enumerate(arms, 1)]
    if len(set(names)) < len(names):
        names = [f"arm_{number}" for number, _ in enumerate(arms, 1)]
    for name, joints in zip(names, arms, strict=True):
        controller = CONTROLLER if len(arms) == 1 else f"{name}_controller"
        span = draft.urdf.joints[joints[0]].element.span
        yield Arm(controller, joints, "the chain of joints with position drives", span, guessed=True)


def _common_words(names: Collection[str]) -> str:
    """The words, separated by `_`, that all names begin with."""
    first, last = min(names).split("_"), max(names).split("_")
    differing = (number for number, (one, other) in enumerate(zip(first, last, strict=False)) if one != other)
    words = first[: next(differing, 0)]
    return "_".join(words[:-1] if words[-1:] == ["joint"] else words)
