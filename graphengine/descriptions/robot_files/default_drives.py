"""Drives that joints get in a robot file: those of a USD stage, or those of a description that says nothing about them."""

from __future__ import annotations

from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.draft import Draft, rounded
from graphengine.descriptions.robot_files.entries import DriveKeys
from graphengine.descriptions.usd_model import StatedDrive
from graphengine.format.wording import printable

WHEEL_DAMPING = 50.0
"""Minimum damping of the velocity drive of a wheel, N m s/rad; with it, a small robot is within 0.02 % of its target speed."""
_MOST = 1e9
"""Maximum stiffness or damping of a drive, in SI units."""


def add_wheel_drives(draft: Draft) -> None:
    """Add a velocity drive for every wheel; for descriptions that are used without a robot file."""
    for wheel in draft.description.wheels(draft.description.moving()):
        draft.joints[wheel.joint].value["drive"] = {"damping": WHEEL_DAMPING}


def servo(joint: Joint) -> DriveKeys:
    """Return the gains of a position drive that exerts its full effort at a deviation of 0.1 rad or 10 mm.

    Without an effort limit, an effort of 10 N m or 10 N is assumed. The damping is a tenth of the stiffness.
    """
    stiffness = (joint.effort or 10.0) / (0.01 if joint.type == "prismatic" else 0.1)
    return {"stiffness": gain(stiffness), "damping": gain(stiffness / 10)}


def gain(number: float) -> float:
    """Return a stiffness or damping as the robot file has it: three significant digits, at most `_MOST`."""
    return rounded(min(number, _MOST), 3)


def stated_kind(joint: Joint, stated: StatedDrive) -> tuple[str, str] | None:
    """Return the kind of drive of a joint of a stage, and the reason; None if the stage says nothing.

    What the graphs of the stage command decides; for several kinds of commands, or none, the numbers of the drive decide.
    """
    gains = f"stiffness {stated.stiffness:g}, damping {stated.damping:g}"
    by_gains = "position" if stated.stiffness > 0 else "velocity" if stated.damping > 0 else ""
    if stated.commands:
        kind = by_gains if by_gains in stated.commands else stated.commands[0]
        if "velocity" in stated.commands and joint.limits is None and by_gains != "position":
            kind = "velocity"
        return kind, f"{kind} command of {printable(stated.controllers[0].rpartition('/')[2])} in the stage"
    return (by_gains, f"its DriveAPI has {gains}") if by_gains else None


def stated_drive(joint: Joint, stated: StatedDrive, kind: str) -> DriveKeys | None:
    """Return the drive of a joint of a stage with the numbers of its DriveAPI; None if these do not suit the kind of drive.

    A position drive needs stiffness. A velocity drive needs damping and no stiffness, which would hold it back.
    """
    if not (stated.stiffness > 0 if kind == "position" else stated.damping > 0 and not stated.stiffness):
        return None
    drive: DriveKeys = {"damping": min(stated.damping, _MOST)}
    if kind == "position":
        drive = {"stiffness": min(stated.stiffness, _MOST)} | drive
    elif stated.velocity:
        drive["target_velocity"] = stated.velocity
    if stated.max_force is not None:
        drive["max_force"] = stated.max_force
    return drive


def add_stated_drives(draft: Draft) -> None:
    """Add the drives of a stage that is used without a robot file; wheels on no stated drive get velocity drives."""
    usd = draft.description.usd
    assert usd is not None
    wheels = {wheel.joint for wheel in draft.description.wheels(draft.description.moving())}
    for joint in draft.description.moving():
        stated = usd.drives[joint.name]
        kind, _ = stated_kind(joint, stated) or ("velocity" if joint.name in wheels else "", "")
        if not kind or kind == "effort" or joint.mimic is not None:
            continue
        otherwise: DriveKeys = {"damping": WHEEL_DAMPING} if kind == "velocity" else servo(joint)
        draft.joints[joint.name].value["drive"] = stated_drive(joint, stated, kind) or otherwise
