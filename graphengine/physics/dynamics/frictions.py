"""Materials whose friction is changed while the simulation runs: their colliders are mixed with the floor anew, as at build."""

from __future__ import annotations

import numpy as np

from graphengine.devices.sensor import Friction
from graphengine.devices.stage import Prim
from graphengine.format.spec import MaterialSpec
from graphengine.physics.dynamics.written import Written
from graphengine.physics.engine import mujoco
from graphengine.physics.model.materials import against_floor


class Frictions(Written[Friction]):
    """Static and dynamic friction of the materials of a stage."""

    def built(self, prim: Prim) -> Friction:
        """What a material was built with."""
        return prim.facts["static_friction"], prim.facts["dynamic_friction"]

    def tell(self, model: mujoco.MjModel, prim: Prim, value: Friction) -> None:
        """Tell MuJoCo of the colliders of all bodies that a material is bound to."""
        static, dynamic = value
        material = MaterialSpec(static_friction=static, dynamic_friction=dynamic, combine=prim.facts["combine"])
        for body, wheel in prim.facts["bodies"].items():
            contact = against_floor(material, prim.facts["floor"], wheel=wheel)
            for geom in np.flatnonzero(model.geom_bodyid == model.body(body).id):
                if model.geom_contype[geom] or model.geom_conaffinity[geom]:
                    contact.tell(model.geom(geom))
