"""One MuJoCo model and its state, behind `backend.World`."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import TypeVar

from graphengine.diagnostics import PhysicsError, PrimError, listing
from graphengine.stage import Prim, Stage
from graphengine.world.drives import Drive
from graphengine.world.engine import mujoco
from graphengine.world.handles import Carried, Handle, Joints
from graphengine.world.lidar import RayLidar

SETTLED_SPEED = 1e-4
"""m/s and rad/s below which everything counts as at rest."""
SETTLED_FOR = 0.1
"""Seconds that it has to stay so: a falling robot has no speed at first."""
SETTLE_LIMIT = 5.0
"""Seconds after which a scene starts whether at rest or not."""

H = TypeVar("H", bound=Handle)


class Simulation:
    """Physics and sensors of a scene.

    A step is `mj_step2` followed by `mj_step1`: the trajectory of `mj_step`, and poses and velocities that belong to the state
    after the step, where `mj_step` leaves those of the state before.

    Args:
        model: compiled; its timestep is one substep.
        stage: prims whose `body` names bodies of the model.
        tick_rate: ticks a second, exact.
        substeps: physics steps in a tick.
        seed: of the sensors' noise.
        settle: let everything come to rest first; what then is the state at t = 0.
    """

    def __init__(
        self, model: mujoco.MjModel, stage: Stage, tick_rate: Fraction, substeps: int, seed: int = 0, settle: bool = False
    ) -> None:
        self.model = model
        self.data = mujoco.MjData(model)
        self.stage = stage
        self.tick_period = (tick_rate.denominator, tick_rate.numerator)
        self.substeps = substeps
        self.seed = seed
        self.tick = 0
        self.settled_after = 0.0
        """Seconds that settling took."""
        self._handles: dict[tuple[type[Handle], str], Handle] = {}
        self._ramps: dict[int, tuple[float, float]] = {}
        """Velocity servos whose set point is on its way: target, and change a step."""
        # A diverged state must stay to be seen; MuJoCo would silently begin anew.
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        self._warnings = self.data.warning.number
        mujoco.mj_step1(model, self.data)
        if settle:
            self._settle()
        self._start = mujoco.mj_getState  # replaced below
        self._save_start()
        self.zero_commands()
