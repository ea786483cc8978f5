"""Chooses the drives of a robot's joints.

A joint that a base, a controller, `<ros2_control>` or `<transmission>` commands gets a drive for this command. Other joints of
such a robot turn freely, because a drive would brake a passive wheel. If the description lists no commands, the import guesses
the drives.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from graphengine.bringup.robots.base import Drivetrain
from graphengine.bringup.robots.joint_commands import KINDS, JointCommands
from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.default_drives import WHEEL_DAMPING, gain, servo, stated_drive, stated_kind
from graphengine.descriptions.robot_files.draft import Claim, Draft, Remark, RobotWheel
from graphengine.descriptions.robot_files.entries import DriveKeys, JointKeys
from graphengine.descriptions.usd_model import StatedDrive
from graphengine.format.wording import printable

_SPEED_ERROR = 0.01
"""Maximum deviation of a wheel's speed due to the friction of its share of the robot's weight, rad/s."""
_ANGLE_ERROR = 0.01
"""Maximum deviation of a steering angle due to the friction of a wheel's share of the robot's weight, rad."""
_ACCELERATION = 1.0
"""Default acceleration limit of a mecanum or omni base, whose controllers have no ramps, m/s2."""
_GRAVITY = 9.81
_CASTERS = "joints of casters, which carry links on the floor"
_LIGHTEST = 0.005
"""Armature of a caster's joint as a fraction of the robot's mass times the square of the joint's height above the floor.

The links of a caster in a description are often so light that the contact with the floor makes them jump.
"""


def add_drives(
    draft: Draft, commands: Mapping[str, JointCommands], wheels: Sequence[RobotWheel], drivetrain: Drivetrain | None
) -> None:
    """Choose the drive of each moving joint.

    Args:
        draft: receives the drives, and remarks on them.
        commands: a dict from joints to the commands that they take.
        wheels: wheels on the floor.
        drivetrain: drivetrain of the base; None for a robot without a base.
    """
    decisions: dict[_Decision, list[Joint]] = {}
    own: set[str] = set()
    carrying = _carrying(draft) if drivetrain is not None else {}
    driven = [wheel.joint for wheel in drivetrain.wheels] if drivetrain is not None else []
    scrub = _scrub(draft, wheels, drivetrain)
    ranged = [joint for joint in driven if joint in commands and any(commands[joint].ranges.get("velocity", ()))]
    if ranged:
        text = f"velocity ranges of {', '.join(map(printable, ranged))}: by default, ros2_control does not enforce them"
        draft.lose(text, commands[ranged[0]].span)
    for joint in draft.description.moving():
        if joint.mimic is not None:
            continue
        decision = _decide(draft, joint, commands, wheels, drivetrain, carrying)
        decisions.setdefault(decision, []).append(joint)
        entry = draft.joints[joint.name]
        gains_of_stage = _own_gains(draft, joint, decision.kind)
        drive = gains_of_stage or _drive(joint, decision.kind, scrub, drivetrain)
        if drive is not None:
            entry.value["drive"] = drive
        if gains_of_stage:
            own.add(joint.name)
        elif decision.kind == "position" and (drivetrain is None or joint not in drivetrain.steering):
            draft.servos.append(joint.name)
        if decision.why == _CASTERS:
            entry.value["armature"] = gain(_LIGHTEST * draft.description.mass * carrying[joint.name] ** 2)
        if decision.kind not in ("velocity", "position"):
            entry.hint = _TOLD[decision.kind]
        if joint.name in commands:
            entry.value |= _bounds(joint, drive if joint.name not in driven else None, commands[joint.name])
    for name, each in commands.items():
        if each.start:
            claim: Claim = {("joints", name, "start"): each.start}
            draft.carried.append(Remark(f"start position {each.start:g}", each.span, claim, ("joint", printable(name))))
    held = [joint for decision, joints in decisions.items() if decision.kind == "velocity" for joint in joints]
    if drivetrain is not None:
        _tell_braking(draft, [joint for joint in held if joint.name not in driven], wheels)
    for stated in (True, False):
        alike = [entry.value.get("drive", {}) for name, entry in draft.joints.items() if (name in own) == stated]
        if gains := sorted(
            {drive["damping"] for drive in alike if drive.get("damping") and not drive.get("stiffness")}
        ):
            text = f"damping of velocity drives: {', '.join(f'{damping:g}' for damping in gains)} N m s/rad"
            draft.remark(
                f"{text}, {'as in the stage' if stated else 'by the weight on the wheels'}",
                None,
                {},
                guessed=not stated,
            )
    for decision, joints in decisions.items():
        names = ", ".join(printable(joint.name) for joint in joints)
        text, claim = f"{_TOLD[decision.kind]}: {names}; {decision.why}", _drives(joints, decision.kind)
        draft.remark(text, joints[0].element.span, claim, guessed=decision.guessed)


def _tell_braking(draft: Draft, joints: Sequence[Joint], wheels: Sequence[RobotWheel]) -> None:
    """Add a remark on wheels on the floor that brake the base, because no graph commands their velocity drives."""
    standing = {wheel.joint for wheel in wheels}
    if braking := [joint for joint in joints if joint.name in standing]:
        names = ", ".join(printable(joint.name) for joint in braking)
        text = "no graph commands these wheels on the floor, whose velocity drives hold them and brake the base"
        draft.notice(f"{names}: {text}", braking[0].element.span)


def _carrying(draft: Draft) -> dict[str, float]:
    """Return a dict from the joints between the root link and links on the floor to their heights above the floor, m."""
    found: dict[str, float] = {}
    for link, lowest in draft.standing.items():
        for carrier in draft.description.carriers(link) if link in draft.description.links else ():
            found[carrier.name] = draft.description.pose_in_root(carrier.child)[0][2] - lowest
    return found


def _drives(joints: Sequence[Joint], kind: str) -> Claim:
    """Return the claim that joints have drives of a kind, or none for a kind without a drive."""
    gains = {
        "damping": ... if kind in ("velocity", "position") else None,
        "stiffness": ... if kind == "position" else None,
    }
    return {("joints", joint.name, "drive", gain): value for joint in joints for gain, value in gains.items()}


@dataclass(frozen=True, slots=True)
class _Decision:
    """The drive of a joint (`velocity`, `position`, `effort` or `free`), the reason, and whether the drive is a guess."""

    kind: str
    why: str
    guessed: bool = False


_TOLD = {
    "velocity": "velocity drive",
    "position": "position drive",
    "effort": "no drive, takes efforts",
    "free": "no drive, turns freely",
}


def _decide(
    draft: Draft,
    joint: Joint,
    commands: Mapping[str, JointCommands],
    wheels: Sequence[RobotWheel],
    drivetrain: Drivetrain | None,
    carrying: Collection[str],
) -> _Decision:
    command, stated = commands.get(joint.name), _stated(draft, joint)
    told = stated_kind(joint, stated) if stated is not None else None
    kinds = command.ranges if command is not None else {}
    source = f"commanded by {drivetrain.base.source}" if drivetrain is not None and not drivetrain.base.guessed else ""
    if drivetrain is not None and joint.name in [wheel.joint for wheel in drivetrain.wheels]:
        return _of_base("velocity", "driven wheels of the base", kinds, source)
    if drivetrain is not None and joint in drivetrain.steering:
        return _of_base("position", "they steer wheels of the base", kinds, source)
    if told is not None and not (told[0] == "position" and _rolls(joint, wheels) and not kinds):
        return _Decision(*told)
    if command is not None and kinds:
        kind = next(kind for kind in KINDS if kind in kinds)
        if "velocity" in kinds and joint.limits is None:
            kind = "velocity"
        why = f"{kind} command of {command.source.partition(' ')[0]}"
        if kind == "effort" and draft.position_drives:
            return _Decision("position", f"--position-drives, in place of the {why}", guessed=True)
        return _Decision(kind, why)
    if any(joint.name in wheel.rollers.joints for wheel in draft.wheels.values()):
        return _Decision("free", "rollers of the wheels", guessed=True)
    if command is not None or commands:
        return _Decision("free", "no controller commands them")
    if joint.name in [wheel.joint for wheel in wheels]:
        return _Decision("free", "wheels that drive nothing", guessed=True)
    if joint.name in [wheel.swivel for wheel in wheels]:
        return _Decision("free", "swivels of casters", guessed=True)
    if joint.name in carrying and joint.limits is None:
        return _Decision("free", _CASTERS, guessed=True)
    if joint.type == "continuous" and "wheel" in joint.name.lower():
        return _Decision("velocity", "wheels by their names, though not by their colliders", guessed=True)
    if joint.effort is not None:
        return _Decision("position", "a limit of effort suggests a motor, which holds them", guessed=True)
    return _Decision("free", "nothing suggests a motor", guessed=True)


def _stated(draft: Draft, joint: Joint) -> StatedDrive | None:
    """Return what a USD stage says about a joint's drive; None for other descriptions."""
    return draft.description.usd.drives.get(joint.name) if draft.description.usd is not None else None


def _own_gains(draft: Draft, joint: Joint, kind: str) -> DriveKeys | None:
    """Return the drive of a joint with the gains of a USD stage; None if it has none that suit the kind of drive."""
    stated = _stated(draft, joint)
    return stated_drive(joint, stated, kind) if stated is not None and kind in ("position", "velocity") else None


def _rolls(joint: Joint, wheels: Sequence[RobotWheel]) -> bool:
    """Return whether a joint turns a wheel on the floor, or is the swivel of a caster."""
    return any(joint.name == wheel.joint or (wheel.caster and joint.name == wheel.swivel) for wheel in wheels)


def _of_base(kind: str, role: str, kinds: Mapping[str, object], source: str) -> _Decision:
    """Return the decision for a joint of a base; a guess unless the description or a controller commands the joint.

    Args:
        kind: kind of drive.
        role: role of the joint in the base, for the remark.
        kinds: kinds of commands that the joint takes.
        source: remark on the source of the base; empty if the base is a guess.
    """
    if kind in kinds:
        return _Decision(kind, f"{role} with a {kind} command")
    return _Decision(kind, f"{role}, {source}" if source else role, guessed=not source)


def _scrub(draft: Draft, wheels: Sequence[RobotWheel], drivetrain: Drivetrain | None) -> float:
    """Return the torque with which the friction of its share of the robot's weight holds a wheel, N m; 0 without wheels."""
    driven = drivetrain.wheels if drivetrain is not None else ()
    radii = [each.radius for each in wheels if not each.caster] or [each.radius for each in driven]
    return draft.description.mass * _GRAVITY * max(radii) / len(radii) if radii else 0.0


def _drive(joint: Joint, kind: str, scrub: float, drivetrain: Drivetrain | None) -> DriveKeys | None:
    """Return the drive of a joint in the robot file; None for a joint without a drive.

    Args:
        joint: the joint.
        kind: kind of drive.
        scrub: torque with which friction holds a wheel, N m.
        drivetrain: drivetrain of the base; None for a robot without a base.
    """
    driven = drivetrain.wheels if drivetrain is not None else ()
    wheel = next((wheel for wheel in driven if wheel.joint == joint.name), None)
    if kind == "velocity":
        drive: DriveKeys = {"damping": gain(max(WHEEL_DAMPING, scrub / _SPEED_ERROR))}
        if drivetrain is not None and wheel is not None and drivetrain.base.kinematics in ("mecanum", "omni"):
            acceleration = float(drivetrain.base.parameters.get("acceleration") or _ACCELERATION)
            drive["max_acceleration"] = gain(acceleration / wheel.radius)  # their controllers have no ramps
        return drive
    if kind == "position":
        gains = servo(joint)
        if drivetrain is not None and joint in drivetrain.steering:
            stiffness = max(scrub / _ANGLE_ERROR, gains["stiffness"] if joint.effort is not None else 0.0)
            gains = {"stiffness": gain(stiffness), "damping": gain(stiffness / 10)}
        return gains
    return None


def _bounds(joint: Joint, drive: DriveKeys | None, commands: JointCommands) -> JointKeys:
    """Return the start position and limits in the commands of a joint, as keys of the joint in the robot file.

    The largest speed of a velocity range becomes `max_velocity` of `drive`.
    """
    keys: JointKeys = {}
    if commands.start:
        keys["start"] = commands.start
    speeds = [abs(end) for end in commands.ranges.get("velocity", ()) if end]
    if drive is not None and speeds:
        drive["max_velocity"] = max(speeds)
    lower, upper = commands.ranges.get("position", (None, None))
    if joint.limits is not None and (lower is not None or upper is not None):
        low = max(joint.limits[0], joint.limits[0] if lower is None else lower)
        high = min(joint.limits[1], joint.limits[1] if upper is None else upper)
        if low < high and (low, high) != joint.limits:
            keys["limits"] = [low, high]
    return keys
