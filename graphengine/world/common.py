"""What two models have in common, by name: how state goes from one to the other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graphengine.world.drives import SetPoints
from graphengine.world.engine import mujoco

_POSITIONS = {mujoco.mjtJoint.mjJNT_FREE: 7, mujoco.mjtJoint.mjJNT_BALL: 4}
_VELOCITIES = {mujoco.mjtJoint.mjJNT_FREE: 6, mujoco.mjtJoint.mjJNT_BALL: 3}
"""Coordinates and degrees of freedom of joints that have more than one."""

_Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]


class Common:
    """Bodies, joints and actuators of one model that another has too.

    Args:
        old: where state comes from.
        new: where it goes.
    """

    def __init__(self, old: mujoco.MjModel, new: mujoco.MjModel) -> None:
        bodies = [(body, _find(new, "BODY", old.body(body).name)) for body in range(old.nbody)]
        self._bodies = _indices([pair for pair in bodies if pair[1] >= 0])
        positions: list[tuple[int, int]] = []
        velocities: list[tuple[int, int]] = []
        mocaps: list[tuple[int, int]] = []
        for one, other in zip(*(side.tolist() for side in self._bodies), strict=True):
            if old.body_mocapid[one] >= 0:
                mocaps.append((old.body_mocapid[one], new.body_mocapid[other]))
            for number in range(old.body_jntnum[one]):
                a, b = old.body_jntadr[one] + number, new.body_jntadr[other] + number
                kind = mujoco.mjtJoint(old.jnt_type[a])
                positions += _run(old.jnt_qposadr[a], new.jnt_qposadr[b], _POSITIONS.get(kind, 1))
                velocities += _run(old.jnt_dofadr[a], new.jnt_dofadr[b], _VELOCITIES.get(kind, 1))
        actuators = [(index, _find(new, "ACTUATOR", old.actuator(index).name)) for index in range(old.nu)]
        self._positions, self._velocities, self._mocaps = map(_indices, (positions, velocities, mocaps))
        self._actuators = _indices([pair for pair in actuators if pair[1] >= 0])

    def carry_over(self, old: mujoco.MjData, new: mujoco.MjData) -> None:
        """Give what is in both models the state it has in the old one; time goes on."""
        new.time = old.time
        for name, (source, target) in (
            ("qpos", self._positions),
            ("qvel", self._velocities),
            ("qacc_warmstart", self._velocities),
            ("qfrc_applied", self._velocities),
            ("xfrc_applied", self._bodies),
            ("ctrl", self._actuators),
            ("mocap_pos", self._mocaps),
            ("mocap_quat", self._mocaps),
        ):
            getattr(new, name)[target] = getattr(old, name)[source]

    def carry_over_commands(self, old: SetPoints, new: SetPoints) -> None:
        """Give what is in both models the commands that it was given."""
        new.targets[self._actuators[1]] = old.targets[self._actuators[0]]
        new.efforts[self._velocities[1]] = old.efforts[self._velocities[0]]


def _find(model: mujoco.MjModel, kind: str, name: str) -> int:
    """Number of what is called so, -1 if there is none."""
    return int(mujoco.mj_name2id(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), name))


def _run(old: int, new: int, count: int) -> list[tuple[int, int]]:
    return [(old + step, new + step) for step in range(count)]


def _indices(pairs: Sequence[tuple[int, int]]) -> _Pairs:
    array = np.array(pairs, np.intp).reshape(-1, 2)
    return array[:, 0], array[:, 1]
