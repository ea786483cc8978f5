"""Welds that can hold one body to another while the simulation runs, such as the welds of grippers.

Each weld is compiled into the model of a robot. It is inactive at first, and has a spare entry in the model's list of body pairs
that do not collide. When the weld begins to hold a body, it gets the id of that body, and a spare entry gets the ids of both
bodies: if they collided, the contacts would act against the weld. A weld whose own body is the world has no spare entry,
because the held body would pass through all geoms of the world.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import TIGHT_SOLIMP, TIGHT_SOLREF, Floats, mujoco
from graphengine.devices.rotation import Vector3
from graphengine.format.stateful import Stateful

_WIDE_AWAKE = -1 - mujoco.mjMINAWAKE
"""MuJoCo's `tree_asleep` of a tree of bodies that is fully awake: it may fall asleep only after some steps at rest."""
_EQUALITY = mujoco.mjtConstraint.mjCNSTR_EQUALITY.value
_ANCHOR, _PLACE, _TURN = slice(0, 3), slice(3, 6), slice(6, 10)
"""Slices of a weld's `eq_data`: anchor in the held body's frame, anchor in the other body's frame, and relative rotation."""


def add_weld(spec: mujoco.MjSpec, name: str, body: str) -> None:
    """Add an inactive weld to the body named `body` of a model; the weld can later hold any other body."""
    weld = spec.add_equality(name=name, type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY, active=False)
    weld.name1, weld.name2 = body, "world"
    weld.data[_TURN], weld.data[10] = (1.0, 0.0, 0.0, 0.0), 1.0
    weld.solref, weld.solimp[:2] = TIGHT_SOLREF, TIGHT_SOLIMP
    if body != "world":
        spec.add_exclude(name=name, bodyname1=body, bodyname2=body)  # a pair that never collides


class Welds(Stateful):
    """The welds of a compiled model that are active; `bound_to` finds them in another compiled model.

    Attributes:
        held: a dict from the name of each active weld to the name of the held body and MuJoCo's `eq_data`.
    """

    kept = ("held",)
    _model: mujoco.MjModel
    _data: mujoco.MjData
    _built: NDArray[np.signedinteger]
    """The body pairs that do not collide in the compiled model, in MuJoCo's encoding; a spare entry pairs a body with itself."""

    def __init__(self) -> None:
        self.held: dict[str, tuple[str, Floats]] = {}

    def bound_to(self, model: mujoco.MjModel, data: mujoco.MjData) -> Self:
        """Return the welds of another model; an active weld stays active if that model has the weld and the held body."""
        made = type(self)()
        made._model, made._data, made._built = model, data, model.exclude_signature.copy()
        made.held = {name: held for name, held in self.held.items() if _has(model, name, held[0])}
        made._write()
        return made

    def restore(self, saved: object) -> None:
        """Restore a saved state: deactivate the current welds, and activate the welds of the saved state."""
        for name in self.held:
            self._data.eq_active[self._model.equality(name).id] = False
        super().restore(saved)
        self._write()

    def withdraw(self) -> None:
        """Reset the model's list of body pairs that do not collide to the compiled list. Call this before copying the model."""
        self._model.exclude_signature[:] = self._built

    def hold(self, weld: str, body: int, point: Vector3) -> None:
        """Hold a body at its present pose relative to the weld's own body, from the next step on.

        Args:
            weld: name of the weld.
            body: id of the body to hold.
            point: point in the world frame at which the weld's force acts, m.
        """
        model, state, number = self._model, self._data, self._model.equality(weld).id
        own, numbers = int(model.eq_obj1id[number]), model.eq_data[number].copy()
        numbers[_ANCHOR] = state.xmat[body].reshape(3, 3).T @ (point - state.xpos[body])
        numbers[_PLACE] = state.xmat[own].reshape(3, 3).T @ (point - state.xpos[own])
        back = np.zeros(4)
        mujoco.mju_negQuat(back, state.xquat[own])
        mujoco.mju_mulQuat(numbers[_TURN], back, state.xquat[body])
        self.held[weld] = model.body(body).name, numbers
        self._write()

    def release(self, weld: str) -> None:
        """Release the body that a weld holds, from the next step on."""
        model, data = self._model, self._data
        if weld in self.held:
            other, _ = self.held.pop(weld)
            data.eq_active[model.equality(weld).id] = False
            tree = int(model.body_treeid[model.body(other).id])
            if tree >= 0 and data.tree_asleep[tree] < 0:  # awake, but it may fall asleep in mid-air
                data.tree_asleep[tree] = _WIDE_AWAKE
            self._write()

    def clear(self) -> None:
        """Release all bodies, and withdraw (see `withdraw`)."""
        for weld in list(self.held):
            self.release(weld)
        self.withdraw()

    def force(self, weld: str) -> Floats:
        """Return the force that the held body exerted on the weld's own body in the last step, N, world frame, shape (3,)."""
        data = self._data
        kinds, owners = data.efc_type[: data.ne], data.efc_id[: data.ne]
        rows = np.flatnonzero((kinds == _EQUALITY) & (owners == self._model.equality(weld).id))
        return data.efc_force[rows[:3]].copy() if len(rows) else np.zeros(3)

    def _write(self) -> None:
        """Write all active welds to the model and the state."""
        model, excluded = self._model, self._built.copy()
        spare = np.flatnonzero(excluded >> 16 == excluded & 0xFFFF).tolist()
        for name, (other, numbers) in self.held.items():
            weld, body = model.equality(name).id, model.body(other).id
            model.eq_obj2id[weld], model.eq_data[weld] = body, numbers
            self._data.eq_active[weld] = True
            own = int(model.eq_obj1id[weld])
            if own:
                excluded[spare.pop()] = (min(own, body) << 16) + max(own, body)
        model.exclude_signature[:] = np.sort(excluded)  # the order in which MuJoCo looks them up


def _has(model: mujoco.MjModel, weld: str, body: str) -> bool:
    """Return whether a model has a weld and the body that it holds."""
    kinds = mujoco.mjtObj
    found = (mujoco.mj_name2id(model, kinds.mjOBJ_EQUALITY, weld), mujoco.mj_name2id(model, kinds.mjOBJ_BODY, body))
    return bool(min(found) >= 0)
