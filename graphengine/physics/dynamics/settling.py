"""Lets a scene come to rest before it starts."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from graphengine.descriptions.engine import mujoco

SETTLED_SPEED = 1e-4
"""Speed below which a body counts as at rest, m/s and rad/s."""
SETTLED_FOR = 0.1
"""Time for which a body must stay slower than `SETTLED_SPEED`, s; a body that begins to fall is slow only for a shorter time."""
SETTLE_LIMIT = 5.0
"""Longest simulation time for settling, s; then the scene starts, even if it is not at rest."""


def settle(model: mujoco.MjModel, data: mujoco.MjData, step: Callable[[], None]) -> float | None:
    """Step the simulation until all bodies are at rest, then reset it with the positions and velocities that they had at rest.

    Each kinematic tree gets the positions and velocities at which this tree came to rest, even if another tree moved it later.
    Actuators keep the control signals and activations that hold them there. The caller must then compute the poses and contacts
    of this state.

    Args:
        model: compiled model.
        data: state, which is changed.
        step: function that advances the simulation by one physics step.

    Returns:
        Simulation time until all bodies were at rest, s; None if a body was not at rest after `SETTLE_LIMIT`.
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
    control, activations = data.ctrl.copy(), data.act.copy()
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:], data.ctrl[:], data.act[:] = positions, velocities, control, activations
    return taken
