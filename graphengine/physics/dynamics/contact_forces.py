"""Computes the contact points of a state, with their forces."""

from __future__ import annotations

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.devices.contact_points import Contacts


def contact_points(model: mujoco.MjModel, data: mujoco.MjData) -> Contacts:
    """Return all contact points between geoms, with positions, normals and forces in the world frame.

    Args:
        model: compiled model.
        data: state for which the forces are computed, as `Forces.now` returns it.
    """
    contact = data.contact
    chosen = np.flatnonzero((contact.geom >= 0).all(axis=1) & (contact.efc_address >= 0))
    frames = contact.frame[chosen].reshape(-1, 3, 3)
    along_axes, wrench = np.zeros((len(chosen), 3)), np.zeros(6)
    for row, number in enumerate(chosen.tolist()):
        mujoco.mj_contactForce(model, data, number, wrench)
        along_axes[row] = wrench[:3]
    return Contacts(
        contact.pos[chosen].copy(),
        frames[:, 0].copy(),  # the rows of a contact's frame are its axes; the first is the normal
        np.einsum("ni,nij->nj", along_axes, frames),
        model.geom_bodyid[contact.geom[chosen]].astype(np.intp),
    )
