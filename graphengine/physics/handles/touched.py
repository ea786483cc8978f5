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
        self._collect()

    def bind(self) -> None:
        """Find the geoms of the entity; ids of an earlier model are discarded."""
        model = self._simulation.model
        self._is_own = np.isin(model.body_rootid[model.geom_bodyid], topmost_bodies(model, self._prim))
        self._own = self._is_own.tolist()
        self._views: dict[int, tuple[Any, Any, Any]] = {}
        """Views of MuJoCo's contacts, whose address is constant, for each number of contacts: geoms, pairs of geoms, distances (m)."""
        self._seen = b""
        """Pairs of geoms at the last step if all of them touched; empty at the first step of a tick."""
        self.named: tuple[tuple[int, ...], tuple[str, ...]] = (), ()
        self.geoms.clear()

    def reset(self) -> None:
        """Discard the geoms touched so far."""
        self.geoms.clear()

    def restore(self, saved: Any) -> None:
        """Restore the geoms."""
        super().restore(saved)
        self._seen = b""

    def see_motion(self) -> None:
        """Add the geoms that touch the entity after a physics step."""
        if self._simulation.in_first_step:
            self.geoms.clear()
            self._seen = b""
        if self._simulation.data.ncon:
            self._collect()

    def _collect(self) -> None:
        data = self._simulation.data
        count = data.ncon
        if count not in self._views:
            geoms = data.contact.geom
            self._views[count] = geoms, geoms.view(np.int64), data.contact.dist
        geoms, pairs, distances = self._views[count]
        seen, closed = pairs.tobytes(), max(distances.tolist(), default=0.0) < 0.0
        if closed and seen == self._seen:
            return
        self._seen = seen if closed else b""
        if count > _FEW:
            near = self._is_own[geoms].any(axis=1)
            geoms, distances = geoms[near], distances[near]
        own = self._own
        for (one, other), distance in zip(geoms.tolist(), distances.tolist(), strict=True):
            if distance < 0.0 and one >= 0 and other >= 0 and own[one] != own[other]:
                self.geoms[other if own[one] else one] = None
