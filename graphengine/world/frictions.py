"""Materials whose friction is changed while the simulation runs: their colliders are mixed with the floor anew, as at build.

A collider's friction belongs to the model, not to the state, so what was written is kept here, by path of the material: a model
that has a robot more or less takes it over, and `put_back` undoes it.
"""

from __future__ import annotations

import numpy as np

from graphengine.context import Friction
from graphengine.spec import MaterialSpec
from graphengine.stage import Prim, Stage
from graphengine.world.engine import mujoco
from graphengine.world.materials import against_floor


class Frictions:
    """What friction the materials of a stage have been given.

    Args:
        stage: with the materials, whose facts are what they were built with.
    """

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._written: dict[str, Friction] = {}

    def of(self, prim: Prim) -> Friction:
        """Static and dynamic friction of a material."""
        return self._written.get(prim.path) or _built(prim)

    def write(self, model: mujoco.MjModel, prim: Prim, friction: Friction) -> None:
        """Give a material another friction."""
        _mix(model, prim, friction)
        self._written[prim.path] = friction

    def carry_over(self, model: mujoco.MjModel) -> None:
        """Write in another model what was written before; materials that are gone are forgotten."""
        self._written = {path: friction for path, friction in self._written.items() if path in self._stage}
        for path, friction in self._written.items():
            _mix(model, self._stage.find(path), friction)

    def put_back(self, model: mujoco.MjModel) -> None:
        """Let all have the friction they were built with."""
        for path in self._written:
            prim = self._stage.find(path)
            _mix(model, prim, _built(prim))
        self._written.clear()


def _built(prim: Prim) -> Friction:
    return prim.facts["static_friction"], prim.facts["dynamic_friction"]


def _mix(model: mujoco.MjModel, prim: Prim, friction: Friction) -> None:
    """Tell MuJoCo of the colliders of all bodies that a material is bound to."""
    static, dynamic = friction
    material = MaterialSpec(static_friction=static, dynamic_friction=dynamic, combine=prim.facts["combine"])
    for body, wheel in prim.facts["bodies"].items():
        contact = against_floor(material, prim.facts["floor"], wheel=wheel)
        for geom in np.flatnonzero(model.geom_bodyid == model.body(body).id):
            if model.geom_contype[geom] or model.geom_conaffinity[geom]:
                contact.tell(model.geom(geom))
