"""Fixes the base of an arm to the world if the description does not fix the root link."""

from __future__ import annotations

import numpy as np

from graphengine.bringup.robots.trial import trial
from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.geoms import extents
from graphengine.descriptions.robot_description import WORLD, RobotDescription
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.format.wording import printable

CHAIN = 3
"""Minimum number of moving joints in a chain for the robot to count as an arm."""
STANDING = 0.05
"""Maximum height (m) of the lowest point of a leg above the robot's lowest point, with all joints at zero."""


def fix_arm(draft: Draft) -> None:
    """Fix the root link of a robot with an arm but without wheels and legs, and add a remark."""
    description = draft.description
    rolls = bool(draft.wheels) or any("wheel" in joint.name.lower() for joint in description.moving())
    if draft.fixed_base or description.root == WORLD or rolls:
        return
    depths = _depths(description)
    limbs = [joint.child for joint in description.moving() if depths[joint.parent] == 0]
    if max(depths.values()) < CHAIN or _legs(draft, limbs) > 1:
        return
    draft.fixed_base = True
    text = "the base is fixed to the world: an arm without wheels or legs would fall over; "
    text += f"for a robot whose {description.root} moves, write fixed_base: false"
    draft.guess(printable(text), description.links[description.root].element.span)


def _depths(description: RobotDescription) -> dict[str, int]:
    """Return a dict from each link to the number of moving joints between the root link and this link."""
    depths: dict[str, int] = {}
    for link in description.depth_first():
        carrier = link.carrier
        depths[link.name] = depths[carrier.parent] + carrier.moves if carrier is not None else 0
    return depths


def _legs(draft: Draft, limbs: list[str]) -> int:
    """Return the number of limbs that reach down to the robot's lowest point; 0 if the robot cannot be compiled.

    Args:
        draft: draft of the robot.
        limbs: names of the first links of the limbs.
    """
    if (model := trial(draft)) is None:
        return 0
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    whole = extents(model, data, np.arange(model.ngeom))
    if whole is None:
        return 0
    found, kind = 0, mujoco.mjtObj.mjOBJ_BODY
    for limb in limbs:
        bodies = [
            body
            for link in draft.description.depth_first(limb)
            if (body := mujoco.mj_name2id(model, kind, link.name)) > 0
        ]
        reach = extents(model, data, np.flatnonzero(np.isin(model.geom_bodyid, bodies)))
        found += reach is not None and reach[0][2] < whole[0][2] + STANDING
    return found
