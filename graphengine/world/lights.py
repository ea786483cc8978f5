"""The lights of a world: which are there, and how bright they are while the simulation runs.

The intensity that a light begins with is 1, whatever the world's file gives it, and its colour is that of its diffuse light.
MuJoCo's diffuse light then is colour times intensity; ambient and specular light follow the intensity, so that at 0 it is out.
All this belongs to the model, not to the state: what was written is kept here, by path of the light, for the next model.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from graphengine.context import Light
from graphengine.stage import Prim, Stage
from graphengine.world.engine import mujoco


def world_lights(model: mujoco.MjModel, robots: Collection[str]) -> list[int]:
    """Numbers of the lights that belong to no robot; in their order, which is the same whatever robots there are."""
    prefixes = tuple(f"{robot}/" for robot in robots)
    bodies = [model.body(body).name for body in model.light_bodyid]
    return [light for light, body in enumerate(bodies) if not body.startswith(prefixes)]


class Lights:
    """How bright the lights of a stage have been made.

    Args:
        stage: with the lights, whose facts are what they were built with.
    """

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self._written: dict[str, Light] = {}

    def of(self, prim: Prim) -> Light:
        """Intensity and colour of a light."""
        return self._written.get(prim.path, (1.0, prim.facts["diffuse"]))

    def write(self, model: mujoco.MjModel, prim: Prim, light: Light) -> None:
        """Make a light another one."""
        self._tell(model, prim, light)
        self._written[prim.path] = light

    def carry_over(self, model: mujoco.MjModel) -> None:
        """Write in another model what was written before."""
        for path, light in self._written.items():
            self._tell(model, self._stage.find(path), light)

    def put_back(self, model: mujoco.MjModel) -> None:
        """Let all be as they were built."""
        written, self._written = self._written, {}
        for prim in map(self._stage.find, written):
            self._tell(model, prim, self.of(prim))

    def _tell(self, model: mujoco.MjModel, prim: Prim, light: Light) -> None:
        intensity, colour = light
        number = world_lights(model, [robot.name for robot in self._stage.prims("robot")])[prim.facts["number"]]
        model.light_diffuse[number] = intensity * np.array(colour)
        model.light_ambient[number] = intensity * np.array(prim.facts["ambient"])
        model.light_specular[number] = intensity * np.array(prim.facts["specular"])
