"""Finds the geoms that touch an entity in the physics steps of a tick."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco
from graphengine.devices.stage import Prim
from graphengine.physics.core.handle_table import Handle

if TYPE_CHECKING:
    from graphengine.physics.core.simulation_core import SimulationCore

_KEPT = 1000
"""Maximum number of sets of contacts that a handle remembers."""


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
    kept = ("_tick", "geoms")

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        self.geoms: dict[int, None] = {}
        self._tick = -1
        """Value of `tick` of the simulation during the physics steps whose contacts `geoms` contains."""
        super().__init__(simulation, prim)
        self._collect(self._data.ncon)

    def bind(self) -> None:
        """Find the geoms of the entity; ids of an earlier model are discarded."""
        model, self._data = self._simulation.model, self._simulation.data
        self._is_own = np.isin(model.body_rootid[model.geom_bodyid], topmost_bodies(model, self._prim))
        self._views: dict[int, tuple[Any, Any]] = {}
        """For each number of contacts, views of MuJoCo's contacts: pairs of geoms, distances (m). Their address is constant."""
        self._near: dict[bytes, list[tuple[int, int]]] = {}
        """For each sequence of pairs, the contacts of the entity: index of the contact, and geom of the other body."""
        self.named: tuple[tuple[int, ...], tuple[str, ...]] = (), ()
        self.geoms.clear()

    def reset(self) -> None:
        """Discard the geoms touched so far."""
        self.geoms.clear()

    def see_motion(self) -> None:
        """Add the geoms that touch the entity after a physics step."""
        if (tick := self._simulation.tick) != self._tick:  # `tick` increases after the last step of a tick
            self._tick = tick
            self.geoms.clear()
        if count := self._data.ncon:
            self._collect(count)

    def _collect(self, count: int) -> None:
        if count not in self._views:
            self._views[count] = self._data.contact.geom.view(np.int64)[:, 0], self._data.contact.dist
        pairs, distances = self._views[count]
        near = self._near.get(pairs.tobytes())
        if near is None:
            near = self._find_near(pairs)
        for index, other in near:
            if other not in self.geoms and distances[index] < 0.0:
                self.geoms[other] = None

    def _find_near(self, pairs: NDArray[np.int64]) -> list[tuple[int, int]]:
        """Return the contacts of the entity with geoms of other bodies, and remember them."""
        geoms = pairs.copy().view(np.int32).reshape(-1, 2)
        own = self._is_own[geoms]
        near = np.flatnonzero((geoms >= 0).all(axis=1) & (own[:, 0] != own[:, 1]))
        if len(self._near) == _KEPT:
            self._near.clear()
        others = np.where(own[:, 0], geoms[:, 1], geoms[:, 0])[near]
        found = self._near[pairs.tobytes()] = list(zip(near.tolist(), others.tolist(), strict=True))
        return found
