"""External forces that act on bodies for a limited time.

The impulse of a push is exactly its force times its duration: the force of a step that is only partly covered is scaled down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graphengine.devices.rotation import Vector3
from graphengine.format.stateful import Stateful
from graphengine.physics.engine import Floats, mujoco


@dataclass(slots=True)
class _Push:
    """A force on a body.

    Attributes:
        body: name of the body in the model.
        force: force in the world frame, N.
        point: point of application in the body's frame, m; None for the centre of mass of the body and all bodies below it.
        left: number of physics steps for which the force still acts; may be a fraction.
    """

    body: str
    force: Floats
    point: Floats | None
    left: float


class Pushes(Stateful):
    """All external forces; MuJoCo's `xfrc_applied` contains the forces of the next step."""

    kept = ("_pushes",)

    def __init__(self) -> None:
        self._pushes: list[_Push] = []

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Continue with another model; bodies that it does not have are no longer pushed."""
        self._model, self._data = model, data
        body = mujoco.mjtObj.mjOBJ_BODY
        self._pushes = [push for push in self._pushes if mujoco.mj_name2id(model, body, push.body) >= 0]
        self.apply()

    def __bool__(self) -> bool:
        return bool(self._pushes)

    def add(self, body: str, force: Vector3, duration: float, point: Vector3 | None) -> None:
        """Apply a force (N) to a body for a duration (s) at a point (m), in the world frame; None: the centre of mass."""
        where = None
        if point is not None:
            number = self._model.body(body).id
            where = self._data.xmat[number].reshape(3, 3).T @ (np.array(point) - self._data.xpos[number])
        self._pushes.append(_Push(body, np.array(force, float), where, duration / self._model.opt.timestep))
        self.apply()

    def advance(self) -> None:
        """Count a completed step."""
        for push in self._pushes:
            push.left -= 1.0
        self._pushes = [push for push in self._pushes if push.left > 0.0]
        self.apply()

    def apply(self) -> None:
        """Set the forces of the next step for the current poses."""
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

    def clear(self) -> None:
        """End all pushes."""
        self._pushes.clear()
        self._data.xfrc_applied[:] = 0.0
