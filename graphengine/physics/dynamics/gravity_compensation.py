"""Gravity compensation: drives carry the weight of the links beyond their joints, as the drives of robot arms do.

MuJoCo's own `gravcomp` applies external forces to bodies. With these forces, the wheels of a mobile base would not carry the
weight of the arm. Here each drive exerts the effort that holds the links beyond its joint at rest. The reaction acts on the links
before the joint.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from graphengine.descriptions.actuators.drives import Drive
from graphengine.descriptions.engine import Floats, Indices, mujoco
from graphengine.physics.kernels.optional_kernels import record

CARRYING = record("joint dof body bodies slides", "carried")
"""A drive that compensates for gravity, for `drive_kernel`: ids of its joint and degree of freedom, the first body beyond the
joint and the number of these bodies, 1 for a prismatic joint, and the mass of these bodies on which gravity acts, kg."""


class GravityCompensation:
    """The drives of a model that compensate for gravity.

    Args:
        model: compiled model.
        data: state of the simulation; the positions of its bodies must be up to date when `apply` is called.
        drives: drives by the names of their joints in the model.

    Attributes:
        joints: names of the joints of the drives that compensate for gravity.
        masses: mass of each body on which gravity acts, kg.
        efforts: compensating efforts of all degrees of freedom in the next step, N m or N.
        table: the drives as records of `CARRYING`.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, drives: Iterable[tuple[str, Drive]]) -> None:
        self.joints = [name for name, drive in drives if drive.gravity_compensation]
        ids = np.array([model.joint(name).id for name in self.joints], np.intp)
        self._ids, self._dofs = ids, model.jnt_dofadr[ids].astype(np.intp)
        self._slides = model.jnt_type[ids] == mujoco.mjtJoint.mjJNT_SLIDE
        self._any_slides = bool(self._slides.any())
        self._ranges = _beyond(model, model.jnt_bodyid[ids])
        self.masses: Floats = model.body_mass * (1.0 - model.body_gravcomp)
        self._weighted = np.zeros((model.nbody + 1, 3))
        self._carried = self._sums(np.append(self.masses, 0.0))
        self.efforts = np.zeros(model.nv)
        self._gravity, self._applied = model.opt.gravity, data.qfrc_applied
        self._centres, self._axes, self._anchors = data.xipos, data.xaxis, data.xanchor
        first, end = self._ranges.reshape(-1, 2).T
        columns = ids, self._dofs, first, end - first, self._slides, self._carried
        self.table = np.rec.fromarrays(columns, dtype=CARRYING).view(np.ndarray)

    @property
    def upright(self) -> bool:
        """Whether gravity acts along the z axis of the world or is 0."""
        return bool(self._gravity[0] == 0.0 == self._gravity[1])

    def apply(self, efforts: Floats) -> Floats:
        """Apply the sum of commanded and compensating efforts to the compensating joints in the next step.

        Args:
            efforts: commanded efforts of all degrees of freedom, N m or N.

        Returns:
            The compensating efforts of all degrees of freedom, N m or N, in an array that the next call overwrites.
        """
        np.multiply(self.masses[:, None], self._centres, out=self._weighted[:-1])
        axes, (a, b, c) = self._axes.take(self._ids, 0), self._gravity.tolist()
        moments = self._sums(self._weighted) - self._carried[:, None] * self._anchors.take(self._ids, 0)  # kg m
        if self.upright:
            own = moments[:, 1] * (c * axes[:, 0]) - moments[:, 0] * (c * axes[:, 1])
        else:
            across = axes @ ((0.0, c, -b), (-c, 0.0, a), (b, -a, 0.0))  # gravity x axis
            own = np.einsum("ij,ij->i", moments, across)
        if self._any_slides:
            own = np.where(self._slides, self._carried * (axes @ self._gravity), own)
        self.efforts[self._dofs] = own = -own
        self._applied[self._dofs] = efforts.take(self._dofs) + own
        return self.efforts

    def _sums(self, values: Floats) -> Floats:
        """Return, for each joint, the sum of `values` over the bodies beyond it; `values` has a row per body and one of zeros."""
        sums: Floats = np.add.reduceat(values, self._ranges)[::2]
        return sums


def _beyond(model: mujoco.MjModel, bodies: Indices) -> Indices:
    """Return an array with the range of body ids in the subtree of each given body: first, end, first, end, and so on.

    MuJoCo numbers the bodies of a subtree consecutively; the end is the id after the last body.
    """
    counts = np.ones(model.nbody, np.intp)
    for body in range(model.nbody - 1, 0, -1):
        counts[model.body_parentid[body]] += counts[body]
    return np.stack([bodies, bodies + counts[bodies]], axis=1).ravel().astype(np.intp)
