"""Adds the graphs that open and close grippers."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import Any

from graphengine.bringup.robots.arm_chains import gripper_joints
from graphengine.bringup.robots.arm_gains import DEVIATION
from graphengine.bringup.robots.arm_graph import Limb, usable
from graphengine.bringup.robots.controllers_file import Controller
from graphengine.descriptions.robot_files.draft import Draft, Remark, says
from graphengine.format.wording import printable

_CONTROLLER = "gripper_controller"
"""Default name of the controller in the graph of a gripper."""


def fill(draft: Draft, held: Collection[str], controllers: Iterable[Controller], *, guess: bool) -> None:
    """Add a graph for each gripper.

    Args:
        draft: receives the graphs, and remarks on them.
        held: names of joints that take position commands.
        controllers: controllers that may define the grippers.
        guess: whether fingers count as a gripper if no controller defines a gripper.
    """
    grippers = list(_of_controllers(draft, held, controllers))
    if not grippers and guess:
        grippers = list(_of_fingers(draft, held))
    for gripper in grippers:
        name = "gripper" if len(grippers) == 1 else printable(gripper.controller.removesuffix("_controller"))
        controller = {"controller": gripper.controller} if gripper.controller != _CONTROLLER else {}
        joint = gripper.joints[0]
        draft.add_graph(name, "graphs/arm/gripper.yaml", {"joint": joint} | controller | gripper.parameters)
        text = f"gripper: {joint} on {gripper.controller}/gripper_cmd, from {gripper.source}"
        text += _press(draft, joint)
        claim = says("graphs", name, "parameters", "joint", value=joint)
        (draft.guessed if gripper.guessed else draft.carried).append(Remark(printable(text), gripper.span, claim))


def _press(draft: Draft, name: str) -> str:
    """Let position targets exceed the range of a gripper's joint so far that its drive presses with its full effort.

    Return this as text for a message; empty if the joint has no limits or no drive in the robot file.
    """
    joint, drive = draft.description.joints[name], draft.entry("joints", name).value.get("drive")
    if joint.limits is None or drive is None:
        return ""
    drive["overtravel"] = DEVIATION
    return f"; targets up to {DEVIATION:g} {'m' if joint.type == 'prismatic' else 'rad'} beyond its limits press"


def _of_controllers(draft: Draft, held: Collection[str], controllers: Iterable[Controller]) -> Iterator[Limb]:
    chosen = (each for each in controllers if each.kind == "GripperActionController")
    for controller, joints in usable(draft, held, chosen, "joint"):
        numbers = {name: controller.positive(name) for name in ("max_effort", "goal_tolerance")}
        parameters: dict[str, Any] = {name: number for name, number in numbers.items() if number is not None}
        if controller.type.startswith("parallel_"):
            parameters["action_type"] = "ParallelGripperCommand"
        if controller.flag("allow_stalling", default=False):
            parameters["allow_stalling"] = True
        yield Limb(controller.name, joints, controller.title, controller.span, parameters)


def _of_fingers(draft: Draft, held: Collection[str]) -> Iterator[Limb]:
    joints = gripper_joints(draft.description, held)
    for number, joint in enumerate(joints, 1):
        name = _CONTROLLER if len(joints) == 1 else f"gripper_{number}_controller"
        span = draft.description.joints[joint].element.span
        yield Limb(name, (joint,), "the fingers that follow it", span, guessed=True)
