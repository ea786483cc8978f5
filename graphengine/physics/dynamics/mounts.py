"""Moves bodies that are fixed to the world.

The pose of a body that is fixed to the world belongs to the model, not to the state. MuJoCo and the lidars' rays assume that the
pose is constant. So the body is moved in a copy of the model, and the simulation continues with the copy.
"""

from __future__ import annotations

import copy
from typing import Self

import numpy as np

from graphengine.descriptions.engine import Floats, mujoco
from graphengine.devices.rotation import Pose
from graphengine.format.stateful import Stateful


class Mounts(Stateful):
    """The bodies that are fixed to the world and were moved since the model was compiled."""

    kept = ("_moved",)

    def __init__(self) -> None:
        self._moved: dict[str, tuple[Floats, Floats]] = {}
        """A dict from the name of each moved body to its compiled and its current pose; a pose is x, y, z (m) and a quaternion
        (w, x, y, z)."""

    def __bool__(self) -> bool:
        return bool(self._moved)

    def __contains__(self, body: str) -> bool:
        return body in self._moved

    def moved(self, model: mujoco.MjModel, body: int, pose: Pose) -> tuple[Self, mujoco.MjModel]:
        """Return new mounts with one more moved body, and a copy of the model in which that body is moved."""
        name, (position, (x, y, z, w)) = model.body(body).name, pose
        built, _ = self._moved.get(name, (np.concatenate((model.body_pos[body], model.body_quat[body])), None))
        mounts, found = copy.copy(self), copy.copy(model)
        mounts._moved = {**self._moved, name: (built, np.array((*position, w, x, y, z)))}
        mounts.carry_over(found)
        return mounts, found

    def carry_over(self, model: mujoco.MjModel) -> None:
        """Move the bodies in another model; discard bodies that the model does not have."""
        for name in list(self._moved):
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
            if body < 0:
                del self._moved[name]
            else:
                model.body_pos[body], model.body_quat[body] = np.split(self._moved[name][1], [3])

    def put_back(self, model: mujoco.MjModel) -> mujoco.MjModel | None:
        """Forget all moves; return a copy of a model with all bodies at their compiled poses, None if no body was moved."""
        if not self._moved:
            return None
        self._moved = {name: (built, built) for name, (built, _) in self._moved.items()}
        found = copy.copy(model)
        self.carry_over(found)
        self._moved.clear()
        return found
