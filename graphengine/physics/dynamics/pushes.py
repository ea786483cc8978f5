"""External forces that act on bodies for a limited time.

The impulse of a push is exactly force times duration: if a push ends within a step, its force in that step is smaller.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graphengine.descriptions.engine import Floats, mujoco
from graphengine.devices.rotation import Vector3
from graphengine.format.stateful import Stateful


@dataclass(slots=True)
class _Push:
    """A force on a body.

    Attributes:
        body: name of the body in the model.
        force: force in the world frame, N.
        point: point of application in the body's frame, m; None for the centre of mass of the body and all bodies below it.
        left: number of physics steps for which the force still acts; not always an integer.
    """

    body: str
    force: Floats
    point: Floats | None
    left: float


class Pushes(Stateful):
    """All pushes that still act. MuJoCo's `xfrc_applied` contains their forces in the next step."""

    kept = ("_pushes",)

    def __init__(self) -> None:
        self._pushes: list[_Push] = []

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Switch to another model and state; pushes end on bodies that the model does not have."""
        self._model, self._data = model, data
        body = mujoco.mjtObj.mjOBJ_BODY
        self._pushes = [push for push in self._pushes if mujoco.mj_name2id(model, body, push.body) >= 0]
        self.apply()

    def __bool__(self) -> bool:
        return bool(self._pushes)

    def add(self, body: str, force: Vector3, duration: float, point: Vector3 | None) -> None:
        """Apply a force to a body for some time.

        Args:
            body: name of the body in the model.
            force: force in the world frame, N.
            duration: time for which the force acts, s.
            point: point of application in the world frame, m; None for the centre of mass of the body and all bodies below it.
        """
        where = None
        if point is not None:
            number = self._model.body(body).id
            where = self._data.xmat[number].reshape(3, 3).T @ (np.array(point) - self._data.xpos[number])
        self._pushes.append(_Push(body, np.array(force, float), where, duration / self._model.opt.timestep))
        self.apply()

    def advance(self) -> None:
        """Count a completed step, and end the pushes whose duration is over."""
        for push in self._pushes:
            push.left -= 1.0
        self._pushes = [push for push in self._pushes if push.left > 0.0]
        self.apply()

    def apply(self) -> None:
        """Write the forces of the next step to `xfrc_applied`, for the current poses."""
        data = self._data
        data.xfrc_applied[:] = 0.0
        for push in self._pushes:
            body = self._model.body(push.body).id
            force = push.force * min(push.left, 1.0)
            at = data.subtree_com[body]
            if push.point is not None:
                at = data.xpos[body] + data.xmat[body].reshape(3, 3) @ push.point
            data.xfrc_applied[body, :3] += force
            data.xfrc_applied[body, 3:] += np.cross(at - data.xipos[body], force)

    def clear(self, prefix: str = "") -> None:
        """End all pushes on bodies whose names begin with a prefix."""
        self._pushes = [push for push in self._pushes if not push.body.startswith(prefix)]
        self.apply()
