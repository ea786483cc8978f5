"""Drives that joints get in a robot file if the description says nothing about them."""

from __future__ import annotations

from graphengine.descriptions.robot_description import Joint
from graphengine.descriptions.robot_files.draft import Draft, rounded
from graphengine.descriptions.robot_files.entries import DriveKeys

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
