"""Finds the geoms that touch an entity in the physics steps of a tick."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.devices.stage import Prim
from graphengine.physics.core.handle_table import Handle

if TYPE_CHECKING:
    from graphengine.physics.core.simulation_core import SimulationCore

_FEW = 40
"""Number of contacts up to which a loop takes less time than functions of numpy."""


def topmost_bodies(model: mujoco.MjModel, prim: Prim) -> list[int]:
    """Return the ids of the topmost bodies of the entity at a prim."""
    if prim.body is not None:
        return [int(model.body_rootid[model.body(prim.body).id])]
    topmost = np.flatnonzero(model.body_parentid == 0)[1:].tolist()
    return [body for body in topmost if model.body(body).name.startswith(f"{prim.entity_name}/")]


class TouchedGeoms(Handle["SimulationCore"]):
    """The geoms that touch an entity in at least one physics step of the current tick, including floors.

    Attributes:
        geoms: ids of the geoms, in order of the first contact.
        named: a former value of `geoms`, and the names of the bodies that have these geoms.
    """

    sees_steps = True
    kept = ("geoms",)

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        self.geoms: dict[int, None] = {}
        super().__init__(simulation, prim)
        self._collect(self._data.ncon)

    def bind(self) -> None:
        """Find the geoms of the entity; ids of an earlier model are discarded."""
        model, self._data = self._simulation.model, self._simulation.data
        self._is_own = np.isin(model.body_rootid[model.geom_bodyid], topmost_bodies(model, self._prim))
        self._views: dict[int, tuple[Any, Any]] = {}
        """Views of MuJoCo's contacts, whose address is constant, for each number of contacts: pairs of geoms, distances (m)."""
        self._others: dict[int, int] = {}
        """For each pair of geoms, the geom that is not of the entity; -1 if both are or none is."""
        self.named: tuple[tuple[int, ...], tuple[str, ...]] = (), ()
        self.geoms.clear()

    def reset(self) -> None:
        """Discard the geoms touched so far."""
        self.geoms.clear()

    def see_motion(self) -> None:
        """Add the geoms that touch the entity after a physics step."""
        simulation = self._simulation
        if simulation.steps % simulation.substeps == 1 % simulation.substeps:
            self.geoms.clear()
        if count := self._data.ncon:
            self._collect(count)

    def _collect(self, count: int) -> None:
        pairs, distances = self._views.get(count) or self._view(count)
        if count > _FEW:
            near = self._is_own[pairs.view(np.int32)].any(axis=1)
            pairs, distances = pairs[near], distances[near]
        geoms, others = self.geoms, self._others
        for index, (pair,) in enumerate(pairs.tolist()):
            other = others.get(pair)
            if other is None:
                other = others[pair] = self._other(pair)
            if other >= 0 and other not in geoms and distances[index] < 0.0:
                geoms[other] = None

    def _view(self, count: int) -> tuple[Any, Any]:
        contact = self._data.contact
        self._views[count] = contact.geom.view(np.int64), contact.dist
        return self._views[count]

    def _other(self, pair: int) -> int:
        first, second = np.array([pair]).view(np.int32).tolist()
        if first < 0 or second < 0 or self._is_own[first] == self._is_own[second]:
            return -1
        return int(second if self._is_own[first] else first)
