"""Adds graphs with which arms follow trajectories (FollowJointTrajectory)."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from graphengine.bringup.robots.arm_chains import arm_chains
from graphengine.bringup.robots.controllers_file import Controller
from graphengine.descriptions.robot_files.draft import Draft, Remark, no_joint, says
from graphengine.format.diagnostics import Span
from graphengine.format.wording import printable

CONTROLLER = "joint_trajectory_controller"
"""Default name of the controller in the graph of an arm."""


@dataclass(frozen=True, slots=True)
class Limb:
    """An arm or a gripper, found in a controller's parameters or by its joints.

    Attributes:
        controller: name of the controller; its action moves the limb.
        joints: names of the joints of an arm from the base to the flange, or in the order of the controller's parameters; the
            joint that opens and closes a gripper.
        source: where the limb was found, as text for messages.
        span: source location of the controller or the first joint.
        parameters: further parameters of the limb's graph.
        guessed: whether the limb was found only by its joints.
    """

    controller: str
    joints: tuple[str, ...]
    source: str
    span: Span | None
    parameters: dict[str, Any] = field(default_factory=dict)
    guessed: bool = False


def fill(draft: Draft, held: Collection[str], controllers: Iterable[Controller], *, guess: bool) -> set[str]:
    """Add a graph for each arm.

    Args:
        draft: receives the graphs, and remarks on them.
        held: names of joints that take position commands.
        controllers: controllers that may define the arms.
        guess: whether chains of joints count as arms if no controller defines an arm.

    Returns:
        the names of the joints of all arms.
    """
    arms = list(_of_controllers(draft, held, controllers))
    if not arms and guess:
        arms = list(_of_chains(draft, held))
    for arm in arms:
        name = "arm" if len(arms) == 1 else printable(arm.controller.removesuffix("_controller"))
        controller = {"controller": arm.controller} if arm.controller != CONTROLLER else {}
        parameters = controller | {"joints": list(arm.joints)} | arm.parameters
        count = f"{len(arm.joints)} joints"
        draft.add_graph(name, "graphs/arm/trajectory.yaml", parameters, f"{count}, from {arm.source}")
        claim = says("graphs", name, "parameters", "joints", value=list(arm.joints))
        remark = Remark(
            f"arm: trajectories of {count} on {printable(arm.controller)}, from {arm.source}", arm.span, claim
        )
        (draft.guessed if arm.guessed else draft.carried).append(remark)
    return {name for arm in arms for name in arm.joints}


def _flaw(draft: Draft, joints: Sequence[str], held: Collection[str]) -> str:
    """Return the reason why a controller cannot move the given joints; empty if it can.

    Args:
        draft: draft with the description.
        joints: names of the controller's joints.
        held: names of joints that take position commands.
    """
    for name in joints:
        if name not in draft.description.joints:
            return no_joint(draft.description, name)
        if name not in held:
            return f"joint {printable(name)!r} has no drive that takes positions"
    return "" if joints else "it names no joints"


def usable(
    draft: Draft, held: Collection[str], controllers: Iterable[Controller], parameter: str
) -> Iterator[tuple[Controller, tuple[str, ...]]]:
    """Yield each controller that can move its joints, with their names; the others are added to `draft.lost`.

    Args:
        draft: draft with the description.
        held: names of joints that take position commands.
        controllers: controllers of arms or of grippers.
        parameter: parameter of a controller that names its joints.
    """
    for controller in controllers:
        joints = controller.texts(parameter)
        if reason := _flaw(draft, joints, held):
            draft.lost.append(Remark(f"{controller.title}: {reason}", controller.span))
        else:
            yield controller, joints


def _of_controllers(draft: Draft, held: Collection[str], controllers: Iterable[Controller]) -> Iterator[Limb]:
    """Yield the arm of each trajectory controller."""
    chosen = (each for each in controllers if each.kind.endswith("JointTrajectoryController"))
    for controller, joints in usable(draft, held, chosen, "joints"):
        yield Limb(controller.name, joints, controller.title, controller.span, _parameters(controller, joints))


def _parameters(controller: Controller, joints: Sequence[str]) -> dict[str, Any]:
    """Return the tolerances and other constraints of a controller as parameters of the arm's graph."""
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


def _of_chains(draft: Draft, held: Collection[str]) -> Iterator[Limb]:
    """Yield an arm for each chain of joints that looks like one."""
    arms = arm_chains(draft.description, held)
    names = [_common_words(arm) or f"arm_{number}" for number, arm in enumerate(arms, 1)]
    if len(set(names)) < len(names):
        names = [f"arm_{number}" for number, _ in enumerate(arms, 1)]
    for name, joints in zip(names, arms, strict=True):
        controller = CONTROLLER if len(arms) == 1 else f"{name}_controller"
        span = draft.description.joints[joints[0]].element.span
        yield Limb(controller, joints, "the chain of joints with position drives", span, guessed=True)


def _common_words(names: Collection[str]) -> str:
    """Return the common prefix of all names in whole words separated by `_`, without a final `joint`."""
    first, last = min(names).split("_"), max(names).split("_")
    differing = (number for number, (one, other) in enumerate(zip(first, last, strict=False)) if one != other)
    words = first[: next(differing, 0)]
    return "_".join(words[:-1] if words[-1:] == ["joint"] else words)
