"""The lights of a world: which are there, and how bright they are while the simulation runs.

The intensity that a light begins with is 1, whatever the world's file gives it, and its colour is that of its diffuse light.
MuJoCo's diffuse light then is colour times intensity; ambient and specular light follow the intensity, so that at 0 it is out.
"""

from __future__ import annotations

import numpy as np

from graphengine.devices.sensor import Light
from graphengine.devices.stage import Prim
from graphengine.physics.dynamics.written import Written
from graphengine.physics.engine import mujoco
from graphengine.physics.model.world_prims import world_lights


class Lights(Written[Light]):
    """Intensity and colour of the lights of a stage."""

    def built(self, prim: Prim) -> Light:
        """What a light begins with."""
        return 1.0, prim.facts["diffuse"]

    def tell(self, model: mujoco.MjModel, prim: Prim, value: Light) -> None:
        """Tell MuJoCo how bright a light is."""
        intensity, colour = value
        number = world_lights(model, [robot.entity_name for robot in self._stage.prims("robot")])[prim.facts["number"]]
        model.light_diffuse[number] = intensity * np.array(colour)
        model.light_ambient[number] = intensity * np.array(prim.facts["ambient"])
        model.light_specular[number] = intensity * np.array(prim.facts["specular"])
