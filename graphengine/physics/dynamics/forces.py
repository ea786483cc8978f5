"""Computes the forces that act in the current state.

After a step, MuJoCo's forces and accelerations belong to the state before it.
"""

from __future__ import annotations

from graphengine.physics.engine import mujoco


class Forces:
    """Computes the forces of a state on request; the next step computes them again.

    Args:
        model: model of the state.
        data: state of the simulation.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._known = False

    def forget(self) -> None:
        """Discard computed forces, because the state has changed."""
        self._known = False

    def now(self) -> mujoco.MjData:
        """Return the state with computed forces, which are valid until the state changes."""
        if not self._known:
            mujoco.mj_forwardSkip(self._model, self._data, mujoco.mjtStage.mjSTAGE_VEL, 1)
            mujoco.mj_rnePostConstraint(self._model, self._data)
            self._known = True
        return self._data
