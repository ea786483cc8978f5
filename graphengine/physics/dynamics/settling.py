"""Lets a scene come to rest before it starts."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from graphengine.physics.engine import mujoco

SETTLED_SPEED = 1e-4
"""m/s and rad/s below which everything counts as at rest."""
SETTLED_FOR = 0.1
"""Seconds that it has to stay so: what begins to fall has no speed at first."""
SETTLE_LIMIT = 5.0
"""Seconds after which a scene starts, at rest or not."""


def settle(model: mujoco.MjModel, data: mujoco.MjData, step: Callable[[], None]) -> float | None:
    """Leave each tree of bodies in the state in which it came to rest, whatever others did afterwards.

    Poses and contacts of the state that this leads to are not computed yet.

    Returns:
        Simulation time until all were at rest, s; None if some did not come to rest in time.
    """
    joints = np.searchsorted(model.jnt_qposadr, np.arange(model.nq), side="right") - 1
    tree_of_position = model.dof_treeid[model.jnt_dofadr[joints]]
    positions, velocities = data.qpos.copy(), data.qvel.copy()
    still, enough = np.zeros(model.ntree, int), math.ceil(SETTLED_FOR / model.opt.timestep)
    taken = None
    for count in range(1, round(SETTLE_LIMIT / model.opt.timestep) + 1):
        step()
        speeds = np.zeros(model.ntree)
        np.maximum.at(speeds, model.dof_treeid, np.abs(data.qvel))
        still = np.where(speeds < SETTLED_SPEED, still + 1, 0)
        moving = still <= enough
        np.copyto(positions, data.qpos, where=moving[tree_of_position])
        np.copyto(velocities, data.qvel, where=moving[model.dof_treeid])
        if not moving.any():
            taken = count * model.opt.timestep
            break
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:] = positions, velocities
    return taken
