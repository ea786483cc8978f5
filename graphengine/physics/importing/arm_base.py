"""Fixes the base of an arm to the world if the description does not fix the root link."""

from __future__ import annotations

import numpy as np

from graphengine.format.wording import printable
from graphengine.physics.description.urdf import WORLD, Urdf
from graphengine.physics.engine import mujoco
from graphengine.physics.importing.draft import Draft, Remark
from graphengine.physics.importing.trial import trial_model, trial_spec
from graphengine.physics.model.geoms import extents

CHAIN = 3
"""Least number of joints in a row of an arm."""
STANDING = 0.05
"""Height (m) above the lowest point of a robot up to which a leg reaches the floor, all joints at zero."""


def fill(draft: Draft) -> None:
    """Fix the root link of a robot that has an arm but neither wheels nor legs."""
    urdf = draft.urdf
    if draft.fixed_base or urdf.root == WORLD or _rolls(draft):
        return
    depths = _depths(urdf)
    limbs = [joint.child for joint in urdf.moving() if depths[joint.parent] == 0]
    if max(depths.values()) < CHAIN or _legs(draft, limbs) > 1:
        return
    draft.fixed_base = True
    text = (
        f"the base is fixed to the world: an arm without wheels or legs would fall over; for a robot whose {urdf.root} "
    )
    draft.guessed.append(Remark(printable(text + "moves, write fixed_base: false"), urdf.links[urdf.root].element.span))


def _rolls(draft: Draft) -> bool:
    return bool(draft.wheels) or any("wheel" in joint.name.lower() for joint in draft.urdf.moving())


def _depths(urdf: Urdf) -> dict[str, int]:
    """Return for each link the number of moving joints between it and the root."""
    depths: dict[str, int] = {}
    for link in urdf.depth_first():
        carrier = link.carrier
        depths[link.name] = depths[carrier.parent] + carrier.moves if carrier is not None else 0
    return depths


def _legs(draft: Draft, limbs: list[str]) -> int:
    """Return the number of limbs that reach the lowest point of the robot."""
    trial = trial_spec(draft)
    model = trial_model(draft, trial[0]) if trial is not None else None
    if model is None:
        return 0
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    whole = extents(model, data, np.arange(model.ngeom))
    if whole is None:
        return 0
    found = 0
    for limb in limbs:
        bodies = [body for link in draft.urdf.depth_first(limb) if (body := _body(model, link.name)) > 0]
        reach = extents(model, data, np.flatnonzero(np.isin(model.geom_bodyid, bodies)))
        found += reach is not None and reach[0][2] < whole[0][2] + STANDING
    return found


def _body(model: mujoco.MjModel, name: str) -> int:
    number: int = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
    return number
