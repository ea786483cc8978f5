"""Copies the state of the joints and actuators that two models have in common, by name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from graphengine.descriptions.engine import Indices, mujoco
from graphengine.physics.dynamics.set_points import SetPoints

_SIZES = {mujoco.mjtJoint.mjJNT_FREE: (7, 6), mujoco.mjtJoint.mjJNT_BALL: (4, 3)}
"""Numbers of coordinates and of degrees of freedom, for joint types with more than one."""

_Pairs = tuple[Indices, Indices]


class Transfer:
    """The joints and actuators that two models have in common.

    Args:
        old: model from which state is copied.
        new: model to which state is copied.
        prefix: prefix of the names of the bodies and actuators to copy; empty for all.
    """

    def __init__(self, old: mujoco.MjModel, new: mujoco.MjModel, prefix: str = "") -> None:
        positions: list[tuple[int, int]] = []
        velocities: list[tuple[int, int]] = []
        for one, other in _joints(old, new, prefix):
            coordinates, freedoms = _SIZES.get(mujoco.mjtJoint(old.jnt_type[one]), (1, 1))
            positions += [(old.jnt_qposadr[one] + step, new.jnt_qposadr[other] + step) for step in range(coordinates)]
            velocities += [(old.jnt_dofadr[one] + step, new.jnt_dofadr[other] + step) for step in range(freedoms)]
        actuators = [(index, _find(new, "ACTUATOR", old.actuator(index).name)) for index in range(old.nu)]
        self._positions, self._velocities = _indices(positions), _indices(velocities)
        actuators = [pair for pair in actuators if pair[1] >= 0 and old.actuator(pair[0]).name.startswith(prefix)]
        ranges = [(_activations(old, one), _activations(new, other)) for one, other in actuators]
        self._actuators = _indices(actuators)
        self._activations = _indices([pair for both in ranges for pair in zip(*both, strict=False)])

    def carry_over(self, old: mujoco.MjData, new: mujoco.MjData) -> None:
        """Copy the time, and the state of the joints and actuators that both models have."""
        new.time = old.time
        for name, (source, target) in (
            ("qpos", self._positions),
            ("qvel", self._velocities),
            ("qacc_warmstart", self._velocities),  # what the last step did, which limits of forces go by
            ("qfrc_applied", self._velocities),
            ("ctrl", self._actuators),
            ("act", self._activations),
        ):
            getattr(new, name)[target] = getattr(old, name)[source]

    def carry_over_commands(self, old: SetPoints, new: SetPoints) -> None:
        """Copy the commands of the joints and actuators that both models have."""
        new.targets[self._actuators[1]] = old.targets[self._actuators[0]]
        new.efforts[self._velocities[1]] = old.efforts[self._velocities[0]]


def _joints(old: mujoco.MjModel, new: mujoco.MjModel, prefix: str) -> Iterator[tuple[int, int]]:
    """Yield the old and the new id of each joint that both models have; bodies of the same name must have the same joints."""
    for one in range(old.nbody):
        name = old.body(one).name
        other = _find(new, "BODY", name) if name.startswith(prefix) else -1
        for number in range(old.body_jntnum[one] if other >= 0 else 0):
            yield old.body_jntadr[one] + number, new.body_jntadr[other] + number


def _activations(model: mujoco.MjModel, actuator: int) -> range:
    """Return the indices of an actuator's activation in `act`; empty if it has none."""
    begin = int(model.actuator_actadr[actuator])
    return range(begin, begin + int(model.actuator_actnum[actuator]))


def _find(model: mujoco.MjModel, kind: str, name: str) -> int:
    """Return the id of a model element with a given type and name; -1 if the model has no such element."""
    return int(mujoco.mj_name2id(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), name))


def _indices(pairs: Sequence[tuple[int, int]]) -> _Pairs:
    array = np.array(pairs, np.intp).reshape(-1, 2)
    return array[:, 0], array[:, 1]
