"""Gravity compensation: drives that carry the weight of the links beyond their joints, as those of robot arms do.

MuJoCo's own `gravcomp` lifts bodies from outside, so that the wheels of a mobile base would not carry its arm. Here each drive
exerts the effort that holds the links beyond its joint at rest; the joint before it carries the reaction, as on the real robot.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from graphengine.physics.engine import Floats, Indices, mujoco
from graphengine.physics.model.drives import Drive


class GravityCompensation:
    """The drives of a model that compensate for gravity.

    Args:
        model: compiled model.
        data: state of the simulation; positions of its bodies must be those of the current state.
        drives: drives by the names of their joints in the model.

    Attributes:
        joints: names of the joints.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, drives: Iterable[tuple[str, Drive]]) -> None:
        self.joints = [name for name, drive in drives if drive.gravity_compensation]
        self._model, self._data = model, data
        self._ids = np.array([model.joint(name).id for name in self.joints], np.intp)
        self._dofs = model.jnt_dofadr[self._ids].astype(np.intp)
        self._slides = model.jnt_type[self._ids] == mujoco.mjtJoint.mjJNT_SLIDE
        masses = model.body_mass * (1.0 - model.body_gravcomp)  # those that gravity acts on
        self._masses = np.append(masses, 0.0)[:, None]
        self._places = np.zeros((model.nbody + 1, 3))
        self._ranges = _beyond(model, model.jnt_bodyid[self._ids])
        self._carried = self._sums(self._masses)
        self._efforts = np.zeros(model.nv)

    def apply(self, efforts: Floats) -> Floats:
        """Add the compensation to the commanded efforts of all degrees of freedom in the next step.

        Returns:
            the compensating efforts, N m or N, in an array that the next call overwrites.
        """
        data, ids, gravity = self._data, self._ids, self._model.opt.gravity
        self._places[:-1] = data.xipos
        axes, anchors = data.xaxis[ids], data.xanchor[ids]
        moments = self._sums(self._masses * self._places) - self._carried * anchors  # kg m
        a, b, c = gravity.tolist()
        torques = (moments @ np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]]) * axes).sum(1)
        forces = self._carried[:, 0] * (axes @ gravity)
        self._efforts[self._dofs] = -np.where(self._slides, forces, torques)
        data.qfrc_applied[self._dofs] = efforts[self._dofs] + self._efforts[self._dofs]
        return self._efforts

    def _sums(self, values: Floats) -> Floats:
        """Sum values of bodies over the bodies beyond each joint."""
        sums: Floats = np.add.reduceat(values, self._ranges)[::2]
        return sums


def _beyond(model: mujoco.MjModel, bodies: Indices) -> Indices:
    """Return first and last index, alternating, of the bodies that hang on each body; MuJoCo numbers them in one go."""
    counts = np.ones(model.nbody, np.intp)
    for body in range(model.nbody - 1, 0, -1):
        counts[model.body_parentid[body]] += counts[body]
    return np.stack([bodies, bodies + counts[bodies]], axis=1).ravel().astype(np.intp)
