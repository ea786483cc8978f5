"""Reads the commands that joints take from MuJoCo actuators, graphs of USD stages, `<ros2_control>` and `<transmission>`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from graphengine.bringup.robots.controllers_file import Controller
from graphengine.descriptions.files.xml import Element, number
from graphengine.descriptions.robot_files.draft import Draft, no_joint
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import printable

KINDS = ("position", "velocity", "effort")
_SERVOS = ("TrajectoryController", "GripperActionController")
"""Ends of the types of controllers that a position drive replaces, whatever their command interface is."""


@dataclass(slots=True)
class JointCommands:
    """The commands that a joint takes.

    Attributes:
        source: controller or element that lists the commands, as text for messages.
        span: source location of this controller or element.
        ranges: a dict from types of commands to the lowest and highest value, SI units; None for a missing value.
        start: initial position of the joint, rad or m; None if it is missing.
    """

    source: str
    span: Span
    ranges: dict[str, tuple[float | None, float | None]] = field(default_factory=dict)
    start: float | None = None


def joint_commands(draft: Draft, controllers: Iterable[Controller]) -> dict[str, JointCommands]:
    """Return the commands that each joint takes, by name of the joint.

    The `<ros2_control>` and `<transmission>` elements with joints are marked as used in the draft.
    """
    found: dict[str, JointCommands] = {}
    for actuator in draft.description.actuators:
        if actuator.joint:
            span = draft.description.joints[actuator.joint].element.span
            source = f"actuator {printable(actuator.name)}"
            found.setdefault(actuator.joint, JointCommands(source, span)).ranges[actuator.kind] = None, None
    for name, stated in draft.description.usd.drives.items() if draft.description.usd is not None else ():
        if stated.commands:
            span = draft.description.joints[name].element.span
            source = f"{printable(stated.controllers[0])} in the stage"
            found[name] = JointCommands(source, span, dict.fromkeys(stated.commands, (None, None)))
    for controller in controllers:
        _controller(draft, controller, found)
    for element in draft.description.element.all("ros2_control"):
        _ros2_control(draft, element, found)
    for element in draft.description.element.all("transmission"):
        _transmission(draft, element, found)
    return found


def add_mimics(root: Element, findings: Findings) -> bool:
    """Convert the older `<param name="mimic">` of joints in a `<ros2_control>` to `<mimic>` elements.

    Args:
        root: root element of the description; changed in place.
        findings: receives a note for each converted joint.

    Returns:
        whether any joint was converted.
    """
    changed, joints = False, {joint.get("name"): joint for joint in root.all("joint")}
    listed = [(control, joint) for control in root.all("ros2_control") for joint in control.all("joint")]
    for control, joint in listed:
        name, leader = joint.get("name"), _text(joint, "mimic")
        follower = joints.get(name)
        if follower is None or leader not in joints or follower.first("mimic") is not None:
            continue
        factors = {key: text for key in ("multiplier", "offset") if (text := _text(joint, key))}
        follower.children.append(Element("mimic", {"joint": leader} | factors, joint.span))
        text = f"joint {name!r} follows {leader!r}, as ros2_control {control.get('name')!r} says: its <mimic> is added"
        findings.add("N103", text, joint.span)
        changed = True
    return changed


def _controller(draft: Draft, controller: Controller, found: dict[str, JointCommands]) -> None:
    """Add the commands of a controller to `found`; the type of a controller may be unknown and add none."""
    word = controller.kind
    kinds = ("position",) if word.endswith(_SERVOS) else controller.texts("command_interfaces", "interface_name")
    kinds = kinds or tuple(kind for kind in KINDS if f"{kind.capitalize()}Controller" in word)
    kinds = tuple(kind for kind in kinds if kind in KINDS)
    if not kinds:  # a broadcaster, or of a type that says nothing about commands
        return
    for name in controller.texts("joint", "joints"):
        if name not in draft.description.joints or not draft.description.joints[name].moves:
            continue
        commands = found.setdefault(name, JointCommands(f"controller {printable(controller.name)}", controller.span))
        for kind in kinds:
            commands.ranges.setdefault(kind, (None, None))


def _ros2_control(draft: Draft, element: Element, found: dict[str, JointCommands]) -> None:
    source = f"ros2_control {printable(element.get('name'))}"
    joints = element.all("joint")
    if joints:
        draft.use(element)
    for joint in joints:
        name = joint.get("name")
        if _unknown(draft, name, source, joint.span):
            continue
        commanded = name in found
        commands = found.setdefault(name, JointCommands(source, joint.span))
        for interface in joint.all("command_interface"):
            kind = interface.get("name")
            if kind in KINDS:
                if not commanded or kind in commands.ranges:  # a controller uses one of several interfaces
                    commands.ranges[kind] = _parameter(interface, "min"), _parameter(interface, "max")
            else:
                draft.lose(f"{source}: a drive takes no {kind!r} command", interface.span)
        states = [state for state in joint.all("state_interface") if state.get("name") == "position"]
        starts = [_parameter(state, "initial_value") for state in states] + [_parameter(joint, "initial_position")]
        commands.start = next((start for start in starts if start is not None), commands.start)
        if draft.description.joints[name].mimic is None and (leader := _text(joint, "mimic")):
            text = f"{source}: {name} follows {leader}: write <mimic> into the joint of the description"
            draft.lose(printable(text), joint.span)


def _transmission(draft: Draft, element: Element, found: dict[str, JointCommands]) -> None:
    source = f"transmission {printable(element.get('name'))}"
    for joint in element.all("joint"):
        name = joint.get("name")
        if _unknown(draft, name, source, joint.span):
            continue
        draft.use(element)
        commands = found.setdefault(name, JointCommands(source, joint.span))
        if commands.source != source:  # <ros2_control> says it more exactly
            continue
        interfaces = [each for holder in (joint, *element.all("actuator")) for each in holder.all("hardwareInterface")]
        for interface in interfaces:
            word = interface.text.rpartition("/")[2]  # such as VelocityJointInterface
            for kind in KINDS:
                if word.startswith(kind.capitalize()):
                    commands.ranges.setdefault(kind, (None, None))


def _unknown(draft: Draft, name: str, source: str, span: Span) -> bool:
    """Return whether the description has no moving joint with this name; add a remark if no joint has the name."""
    joint = draft.description.joints.get(name)
    if joint is None:
        draft.lose(f"{source}: {no_joint(draft.description, name)}", span)
    return joint is None or not joint.moves


def _text(element: Element, name: str) -> str:
    return next((parameter.text for parameter in element.all("param") if parameter.get("name") == name), "")


def _parameter(element: Element, name: str) -> float | None:
    return number(_text(element, name))
