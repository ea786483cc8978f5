"""The forces that act in the present state.

What a step leaves behind are the forces and accelerations of the state before it.
"""

from __future__ import annotations

from graphengine.physics.engine import mujoco


class Forces:
    """Finds the forces of a state when somebody asks for them, which the next step finds anew.

    Args:
        model: of the state.
        data: the state.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._known = False

    def forget(self) -> None:
        """The state has changed."""
        self._known = False

    def now(self) -> mujoco.MjData:
        """The state with its forces; read it at once."""
        if not self._known:
            mujoco.mj_forwardSkip(self._model, self._data, mujoco.mjtStage.mjSTAGE_VEL, 1)
            mujoco.mj_rnePostConstraint(self._model, self._data)
            self._known = True
        return self._data
