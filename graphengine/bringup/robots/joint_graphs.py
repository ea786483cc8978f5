"""Adds graphs for joints that do not belong to a base: joint states, commands, arms, grippers and legs.

Arms follow trajectories (FollowJointTrajectory); a legged robot with motors stands in the pose of its keyframe `home`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from graphengine.bringup.robots.arm_chains import arm_chains, gripper_joints
from graphengine.bringup.robots.arm_gains import DEVIATION
from graphengine.bringup.robots.base import Drivetrain
from graphengine.bringup.robots.controllers_file import Controller
from graphengine.descriptions.robot_files.draft import Claim, Draft, in_path, no_joint, rounded
from graphengine.descriptions.robot_files.entries import Entry
from graphengine.descriptions.robot_files.mjcf_parts import KEYFRAME
from graphengine.format.diagnostics import Span
from graphengine.format.wording import printable

_ARM_CONTROLLER = "joint_trajectory_controller"
"""Default name of the controller in the graph of an arm."""
_GRIPPER_CONTROLLER = "gripper_controller"
"""Default name of the controller in the graph of a gripper."""
_STAND = "stand"
"""Name of the legs' graph in the robot file."""
_ANGLE = 0.4
"""Deviation of a joint at which the graph commands the joint's full torque, rad."""
_DAMPING = 0.05
"""Ratio of damping to stiffness, s."""


def add_joint_graphs(draft: Draft, controllers: Sequence[Controller], drivetrain: Drivetrain | None) -> None:
    """Add graphs for all joints with drives that do not belong to the base.

    A robot with a base gets no graph for joint states, because the graph of the base publishes the states of all joints.
    """
    base = drivetrain.joints if drivetrain is not None else ()
    driven, held = ([name for name in names if name not in base] for names in _drives(draft))
    if not driven:
        return
    if drivetrain is None:
        draft.add_graph("joint_states", "graphs/joint_states.yaml", {})
        _add_stand(draft)
    if _STAND in draft.graphs:  # which commands all joints itself
        return
    draft.commanded = list(driven)
    draft.add_graph("joint_commands", "graphs/joint_commands.yaml", {})
    bolted = draft.fixed_base or not draft.description.moves_freely
    moved = _add_arms(draft, held, controllers, guess=bolted or drivetrain is not None)
    _add_grippers(draft, held, controllers, guess=bool(moved))


def _drives(draft: Draft) -> tuple[Collection[str], Collection[str]]:
    """Return the names of the joints that take commands, and of the joints that take position commands."""
    model = draft.description.mjcf
    if model is not None:
        actuators = {actuator.joint: actuator.kind for actuator in model.actuators}
        driven = [joint.name for joint in draft.description.moving() if joint.name in actuators]
        return driven, [each.joint for each in model.actuators if each.kind == "position" and each.joint in driven]
    drives = {name: entry.value["drive"] for name, entry in draft.joints.items() if "drive" in entry.value}
    return drives, [name for name, drive in drives.items() if "stiffness" in drive]


@dataclass(frozen=True, slots=True)
class _Limb:
    """An arm or a gripper, from the parameters of a controller or from a chain of joints.

    Attributes:
        controller: name of the controller; its action moves the limb.
        joints: for an arm, names of the joints from the base to the flange, or in the order of the controller's parameters; for
            a gripper, the joint that opens and closes it.
        source: controller or joints that define the limb, as text for messages.
        span: source location of the controller or the first joint.
        parameters: further parameters of the limb's graph.
        guessed: whether the limb comes from a chain of joints, without a controller.
    """

    controller: str
    joints: tuple[str, ...]
    source: str
    span: Span | None
    parameters: dict[str, Any] = field(default_factory=dict)
    guessed: bool = False


def _add_arms(draft: Draft, held: Collection[str], controllers: Iterable[Controller], *, guess: bool) -> set[str]:
    """Add a graph for each arm.

    Args:
        draft: receives the graphs, and remarks on them.
        held: names of joints that take position commands.
        controllers: controllers that may define the arms.
        guess: whether chains of joints count as arms if no controller defines an arm.

    Returns:
        the names of the joints of all arms.
    """
    chosen = (each for each in controllers if each.kind.endswith("JointTrajectoryController"))
    arms = list(_limbs_of_controllers(draft, held, chosen, "joints", _arm_parameters))
    if not arms and guess:
        arms = list(_arms_of_chains(draft, held))
    for arm in arms:
        name, controller = _graph_of(arm, arms, "arm", _ARM_CONTROLLER)
        parameters = controller | {"joints": list(arm.joints)} | arm.parameters
        count = f"{len(arm.joints)} joints"
        draft.add_graph(name, "graphs/arm/trajectory.yaml", parameters, f"{count}, from {arm.source}")
        claim: Claim = {("graphs", name, "parameters", "joints"): list(arm.joints)}
        text = f"arm: trajectories of {count} on {printable(arm.controller)}, from {arm.source}"
        draft.remark(text, arm.span, claim, guessed=arm.guessed)
    return {name for arm in arms for name in arm.joints}


def _graph_of(limb: _Limb, limbs: Sequence[_Limb], kind: str, default: str) -> tuple[str, dict[str, str]]:
    """Return the name of a limb's graph, and the parameter `controller` of this graph unless the default fits.

    Args:
        limb: arm or gripper.
        limbs: all arms or all grippers of the robot; a single one has a graph with the name `arm` or `gripper`.
        kind: `arm` or `gripper`.
        default: default value of the parameter.
    """
    name = kind if len(limbs) == 1 else printable(limb.controller.removesuffix("_controller"))
    return name, {"controller": limb.controller} if limb.controller != default else {}


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


def _limbs_of_controllers(
    draft: Draft,
    held: Collection[str],
    controllers: Iterable[Controller],
    parameter: str,
    read: Callable[[Controller, Sequence[str]], dict[str, Any]],
) -> Iterator[_Limb]:
    """Yield the limb of each controller that can move its joints; add a remark on the others to `draft.lost`.

    Args:
        draft: draft with the description.
        held: names of joints that take position commands.
        controllers: controllers of arms or of grippers.
        parameter: parameter of a controller that names its joints.
        read: returns the parameters of the limb's graph for a controller and its joints.
    """
    for controller in controllers:
        joints = controller.texts(parameter)
        if reason := _flaw(draft, joints, held):
            draft.lose(f"{controller.title}: {reason}", controller.span)
        else:
            yield _Limb(controller.name, joints, controller.title, controller.span, read(controller, joints))


def _arm_parameters(controller: Controller, joints: Sequence[str]) -> dict[str, Any]:
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


def _arms_of_chains(draft: Draft, held: Collection[str]) -> Iterator[_Limb]:
    """Yield an arm for each chain of joints from `arm_chains`."""
    arms = arm_chains(draft.description, held)
    names = [_common_words(arm) or f"arm_{number}" for number, arm in enumerate(arms, 1)]
    if len(set(names)) < len(names):
        names = [f"arm_{number}" for number, _ in enumerate(arms, 1)]
    for name, joints in zip(names, arms, strict=True):
        controller = _ARM_CONTROLLER if len(arms) == 1 else f"{name}_controller"
        span = draft.description.joints[joints[0]].element.span
        yield _Limb(controller, joints, "the chain of joints with position drives", span, guessed=True)


def _common_words(names: Collection[str]) -> str:
    """Return the words, separated by `_`, with which all names begin, without a final `joint`."""
    first, last = min(names).split("_"), max(names).split("_")
    differing = (number for number, (one, other) in enumerate(zip(first, last, strict=False)) if one != other)
    words = first[: next(differing, 0)]
    return "_".join(words[:-1] if words[-1:] == ["joint"] else words)


def _add_grippers(draft: Draft, held: Collection[str], controllers: Iterable[Controller], *, guess: bool) -> None:
    """Add a graph for each gripper.

    Args:
        draft: receives the graphs, and remarks on them.
        held: names of joints that take position commands.
        controllers: controllers that may define the grippers.
        guess: whether fingers count as a gripper if no controller defines a gripper.
    """
    chosen = (each for each in controllers if each.kind == "GripperActionController")
    grippers = list(_limbs_of_controllers(draft, held, chosen, "joint", _gripper_parameters))
    if not grippers and guess:
        grippers = list(_grippers_of_fingers(draft, held))
    for gripper in grippers:
        name, controller = _graph_of(gripper, grippers, "gripper", _GRIPPER_CONTROLLER)
        joint = gripper.joints[0]
        draft.add_graph(name, "graphs/arm/gripper.yaml", {"joint": joint} | controller | gripper.parameters)
        text = f"gripper: {joint} on {gripper.controller}/gripper_cmd, from {gripper.source}"
        text += _press(draft, joint)
        claim: Claim = {("graphs", name, "parameters", "joint"): joint}
        draft.remark(printable(text), gripper.span, claim, guessed=gripper.guessed)


def _press(draft: Draft, name: str) -> str:
    """Let position targets exceed the limits of a gripper's joint until the drive presses with its full effort.

    Return a text on this for a message; empty if the joint has no limits, or no drive in the robot file.
    """
    joint, drive = draft.description.joints[name], draft.joints[name].value.get("drive")
    if joint.limits is None or drive is None:
        return ""
    drive["overtravel"] = DEVIATION
    return f"; targets up to {DEVIATION:g} {'m' if joint.type == 'prismatic' else 'rad'} beyond its limits press"


def _gripper_parameters(controller: Controller, _: Sequence[str]) -> dict[str, Any]:
    """Return the limits and the action type of a controller as parameters of the gripper's graph."""
    numbers = {name: controller.positive(name) for name in ("max_effort", "goal_tolerance")}
    found: dict[str, Any] = {name: number for name, number in numbers.items() if number is not None}
    if controller.type.startswith("parallel_"):
        found["action_type"] = "ParallelGripperCommand"
    if controller.flag("allow_stalling", default=False):
        found["allow_stalling"] = True
    return found


def _grippers_of_fingers(draft: Draft, held: Collection[str]) -> Iterator[_Limb]:
    joints = gripper_joints(draft.description, held)
    for number, joint in enumerate(joints, 1):
        name = _GRIPPER_CONTROLLER if len(joints) == 1 else f"gripper_{number}_controller"
        span = draft.description.joints[joint].element.span
        yield _Limb(name, (joint,), "the fingers that follow it", span, guessed=True)


def _add_stand(draft: Draft) -> None:
    """Add a graph that holds the legs of a free robot with the keyframe `home`, and with motors but no servos."""
    model = draft.description.mjcf
    joints = [joint for joint in draft.description.moving() if joint.mimic is None]
    if model is None or KEYFRAME not in model.keyframes or not model.free or draft.fixed_base:
        return
    motors = {actuator.joint for actuator in model.actuators if actuator.kind == "effort"}
    servos = {actuator.joint for actuator in model.actuators if actuator.kind != "effort"}
    held = [joint for joint in joints if joint.name in motors - servos]
    if not held or servos & {joint.name for joint in joints}:
        return
    coordinates = model.keyframes[KEYFRAME].coordinates
    torque = min((joint.effort for joint in held if joint.effort), default=10.0)
    stiffness = rounded(torque / _ANGLE, 2)
    parameters = {
        "base": in_path(draft.description.root),
        "joints": [joint.name for joint in held],
        "positions": [rounded(coordinates[joint.name][0]) for joint in held],
        "stiffness": stiffness,
        "damping": rounded(_DAMPING * stiffness, 2),
    }
    comment = f"torques that hold the joints where the keyframe {KEYFRAME} has them"
    draft.graphs[_STAND] = Entry({"use": "graphs/legs/stand.yaml", "parameters": parameters}, [comment])
    draft.guess(f"gains of the graph stand: {stiffness:g} N m/rad and {parameters['damping']:g} N m s/rad")
