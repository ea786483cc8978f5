"""Prepares the drives of all robots for a physics step: set points, gravity compensation and force limits in one pass."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.physics.dynamics.force_limits import ForceLimits
from graphengine.physics.dynamics.gravity_compensation import GravityCompensation
from graphengine.physics.dynamics.set_points import SetPoints
from graphengine.physics.kernels.optional_kernels import load_kernel


class DriveStep:
    """Moves set points, compensates gravity and limits forces before each physics step.

    A compiled kernel does the work if numba is usable. Otherwise, and for drives that compensate for a gravity that is not
    vertical, numpy does the work. Both give the same results to the last bit.

    Args:
        model: compiled model.
        data: state of the simulation.
        points: commands of all actuators and joints.
        limits: drives with a maximum force.
        compensation: drives that compensate for gravity.
        kernel: the compiled kernel; None to load it if a drive has limits, compensates for gravity or interpolates.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        points: SetPoints,
        limits: ForceLimits,
        compensation: GravityCompensation,
        *,
        kernel: Callable[..., bool] | None = None,
    ) -> None:
        self._points, self._limits, self._compensation = points, limits, compensation
        self._always = bool(limits.joints or compensation.joints)
        self._kernel = kernel or (_kernel() if self._always or points.even.any() else None)
        control = data.ctrl if model.nu else np.zeros(1)
        state = data.qpos, data.qvel, data.qfrc_bias, data.qacc_warmstart
        self._constants = (
            *(points.changes, points.even, limits.table, compensation.table, model.opt.timestep, *state),
            *(compensation.masses, data.xipos, data.xaxis, data.xanchor, model.opt.gravity, compensation.efforts),
            *(control, data.qfrc_applied),
        )

    def prepare(self, steps: int) -> None:
        """Write the control signals and applied forces of the next step.

        Args:
            steps: number of steps left in the tick.
        """
        points, limits, compensation = self._points, self._limits, self._compensation
        if self._kernel is not None and (not compensation.joints or compensation.upright):
            if points.pending or self._always:
                changing = points.pending, steps, points.targets, points.efforts, limits.reach
                points.pending = self._kernel(*changing, *self._constants)
            return
        if limits.joints:
            limits.observe()
        points.take_over(steps)
        compensating = compensation.apply(points.efforts) if compensation.joints else None
        if limits.joints:
            limits.apply(points.efforts, compensating)


@functools.cache
def _kernel() -> Callable[..., bool] | None:
    """Return the compiled kernel, or None if numba does not work."""
    return load_kernel(_load, "drives")


def _load() -> Callable[..., bool] | None:
    import numba

    from graphengine.physics.dynamics.drive_kernel import prepare_drives
    from graphengine.physics.kernels.compiled import announced

    if numba.config.DISABLE_JIT:  # numpy is faster than Python
        return None
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    data = mujoco.MjData(model)
    parts = SetPoints(model, data, ()), ForceLimits(model, data, ()), GravityCompensation(model, data, ())
    with announced("the limits of drives"):
        DriveStep(model, data, *parts, kernel=prepare_drives).prepare(1)
    return prepare_drives
