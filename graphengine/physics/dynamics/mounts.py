"""Bodies that are bolted to the world, put elsewhere.

Where such a body is belongs to the model, not to the state. MuJoCo and the rays of lidars take it for settled once a run has
begun, so a body is moved in a copy of the model, and the simulation goes on with that.
"""

from __future__ import annotations

import copy
from typing import Self

import numpy as np

from graphengine.devices.rotation import Pose
from graphengine.format.stateful import Stateful
from graphengine.physics.engine import Floats, mujoco


class Mounts(Stateful):
    """Which bodies stand elsewhere than the model was compiled with."""

    kept = ("_moved",)

    def __init__(self) -> None:
        self._moved: dict[str, tuple[Floats, Floats]] = {}
        """By name of the body: where it was built, and where it is; position, then the quaternion (w, x, y, z)."""

    def __bool__(self) -> bool:
        return bool(self._moved)

    def moved(self, model: mujoco.MjModel, body: int, pose: Pose) -> tuple[Self, mujoco.MjModel]:
        """These with a topmost body elsewhere, and a copy of the model in which it is."""
        name, (position, (x, y, z, w)) = model.body(body).name, pose
        built, _ = self._moved.get(name, (np.concatenate((model.body_pos[body], model.body_quat[body])), None))
        mounts, found = copy.copy(self), copy.copy(model)
        mounts._moved = {**self._moved, name: (built, np.array((*position, w, x, y, z)))}
        mounts.carry_over(found)
        return mounts, found

    def carry_over(self, model: mujoco.MjModel) -> None:
        """Move in a model what was moved before; bodies that it does not have are forgotten."""
        for name in list(self._moved):
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
            if body < 0:
                del self._moved[name]
            else:
                model.body_pos[body], model.body_quat[body] = np.split(self._moved[name][1], [3])

    def put_back(self, model: mujoco.MjModel) -> mujoco.MjModel | None:
        """A copy of a model in which all stand where they were built; None where they do."""
        if not self._moved:
            return None
        self._moved = {name: (built, built) for name, (built, _) in self._moved.items()}
        found = copy.copy(model)
        self.carry_over(found)
        self._moved.clear()
        return found
