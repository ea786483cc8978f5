"""MuJoCo's own model and state of a session."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graphengine.api.guards import reading
from graphengine.api.pictures import simulated
from graphengine.api.runner import Runner

if TYPE_CHECKING:
    import mujoco


class MujocoObjects:
    """MuJoCo's model and state of a session, for all that the Python API does not offer. Both are the session's own, not copies.

    Take both from `sim.mujoco` again after `reset`, `restore`, `reload`, `spawn`, `remove` and `move`, which may replace them.

    Your own writes are not recorded, so a replay does not repeat them. They may be overwritten: `reset` and `restore` overwrite
    the whole state, each change of a joint command overwrites all of `data.ctrl` and `data.qfrc_applied`, and each push or move
    all of `data.xfrc_applied`. After you write positions or velocities, call `mujoco.mj_forward(model, data)`, because the next
    step starts from the quantities that it computes.

    Names of a robot's bodies, joints and geoms begin with `ROBOT/`, as in `dd100/base_link`.
    """

    def __init__(self, runner: Runner) -> None:
        self._runner = runner

    @property
    @reading
    def model(self) -> mujoco.MjModel:
        """The compiled model, a `mujoco.MjModel`; its timestep is one substep, s.

        >>> sim.mujoco.model.opt.gravity.tolist()
        [0.0, 0.0, -9.81]
        """
        return simulated(self._runner.session.services.world).model

    @property
    @reading
    def data(self) -> mujoco.MjData:
        """The state after the last physics step, a `mujoco.MjData`.

        >>> sim.mujoco.data.qpos.size == sim.mujoco.model.nq
        True
        """
        return simulated(self._runner.session.services.world).data
