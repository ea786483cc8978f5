"""The forces that act in the present state.

What a step leaves behind are the forces and accelerations of the state before it. To compute them anew in place would move the
point where the solver begins the next step, and so the trajectory; hence it happens in a copy.
"""

from __future__ import annotations

from graphengine.world.engine import mujoco


class Forces:
    """A copy of a state, in which forces are known.

    Args:
        model: of the state.
        data: the state; only read.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._copy: mujoco.MjData | None = None
        self._known = False

    def forget(self) -> None:
        """The state has changed."""
        self._known = False

    def now(self) -> mujoco.MjData:
        """The state with its forces, computed when first asked for after a change; read it at once."""
        if self._copy is None:
            self._copy = mujoco.MjData(self._model)
        if not self._known:
            mujoco.mj_copyData(self._copy, self._model, self._data)
            mujoco.mj_forwardSkip(self._model, self._copy, mujoco.mjtStage.mjSTAGE_VEL, 1)
            mujoco.mj_rnePostConstraint(self._model, self._copy)
            self._known = True
        return self._copy
