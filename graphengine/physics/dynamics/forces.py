"""Computes the forces that act in the current state.

After a step, the forces and accelerations in MuJoCo's data still belong to the state before that step.
"""

from __future__ import annotations

from graphengine.descriptions.engine import mujoco


class Forces:
    """Computes the forces and accelerations of the current state on request.

    Args:
        model: model of the state.
        data: state of the simulation.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._known = self._known_of_step = False

    def forget(self) -> None:
        """Mark the computed forces as outdated, because the state has changed."""
        self._known = self._known_of_step = False

    def of_step(self) -> mujoco.MjData:
        """Return the state before the physics step that is being made, with the forces between bodies that this step applied.

        Only `Handle.see_forces` may call this. `qacc` is then the mean acceleration over the step.
        """
        model, data = self._model, self._data
        if not self._known_of_step:
            pushes = data.xfrc_applied.copy()
            # MuJoCo does not count the force that carries a weightless body among the external forces.
            data.xfrc_applied[:, :3] -= (model.body_mass * model.body_gravcomp)[:, None] * model.opt.gravity
            mujoco.mj_rnePostConstraint(model, data)
            data.xfrc_applied[:] = pushes
            self._known_of_step = True
        return data

    def now(self) -> mujoco.MjData:
        """Return the state, with forces computed for it; the forces are valid until the state changes."""
        if not self._known:
            mujoco.mj_forwardSkip(self._model, self._data, mujoco.mjtStage.mjSTAGE_VEL, 1)
            mujoco.mj_rnePostConstraint(self._model, self._data)
            self._known = True
        return self._data
