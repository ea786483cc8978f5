"""What graphs wrote over things that belong to the model and not to the state: frictions of materials, and lights.

It is kept by prim path: a model that has a robot more or less takes it over, and `put_back` undoes it.

The intensity that a light begins with is 1, whatever the world's file gives it, and its colour is that of its diffuse light.
MuJoCo's diffuse light then is colour times intensity; ambient and specular light follow the intensity, so that at 0 it is out.
"""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np

from graphengine.devices.backend import Friction, Light
from graphengine.devices.stage import Prim, Stage
from graphengine.format.spec import MaterialSpec
from graphengine.format.stateful import Stateful
from graphengine.physics.engine import collides, mujoco
from graphengine.physics.model.materials import against_floor
from graphengine.physics.model.world_prims import world_lights

T = TypeVar("T")


class Written(Stateful, Generic[T]):
    """Values of prims of one kind, where they are others than those that were built.

    Args:
        stage: with the prims, whose facts are what they were built with.
    """

    kept = ("written",)

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self.written: dict[str, T] = {}
        """By prim path."""

    def built(self, prim: Prim) -> T:
        """What a prim was built with."""
        raise NotImplementedError

    def tell(self, model: mujoco.MjModel, prim: Prim, value: T) -> None:
        """Tell MuJoCo of a prim's value."""
        raise NotImplementedError

    def of(self, prim: Prim) -> T:
        """A prim's value."""
        return self.written[prim.path] if prim.path in self.written else self.built(prim)

    def write(self, model: mujoco.MjModel, prim: Prim, value: T) -> None:
        """Give a prim another value."""
        self.tell(model, prim, value)
        self.written[prim.path] = value

    def carry_over(self, model: mujoco.MjModel) -> None:
        """Write in another model what was written before; prims that are gone are forgotten."""
        self.written = {path: value for path, value in self.written.items() if path in self._stage}
        for path, value in self.written.items():
            self.tell(model, self._stage.find(path), value)

    def put_back(self, model: mujoco.MjModel) -> None:
        """Let all have what they were built with."""
        for prim in map(self._stage.find, self.written):
            self.tell(model, prim, self.built(prim))
        self.written.clear()


class Frictions(Written[Friction]):
    """Static and dynamic friction of the materials of a stage; colliders are mixed with the floor anew, as at build."""

    def built(self, prim: Prim) -> Friction:
        """What a material was built with."""
        return prim.facts["static_friction"], prim.facts["dynamic_friction"]

    def tell(self, model: mujoco.MjModel, prim: Prim, value: Friction) -> None:
        """Tell MuJoCo of the colliders of all bodies that a material is bound to."""
        static, dynamic = value
        built, across = prim.facts["dynamic_friction"], prim.facts["across"] or 0.0
        greatest = max(
            dynamic, across * dynamic / built if built else across
        )  # friction across changes by the same factor
        material = MaterialSpec(static_friction=static, dynamic_friction=greatest, combine=prim.facts["combine"])
        for body, wheel in prim.facts["bodies"].items():
            contact = against_floor(material, prim.facts["floor"], wheel=wheel)
            for geom in np.flatnonzero((model.geom_bodyid == model.body(body).id) & collides(model)):
                contact.tell(model.geom(geom))


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
