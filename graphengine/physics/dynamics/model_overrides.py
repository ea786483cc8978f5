"""Settings that graphs write to the model, not to the state: frictions of materials, and intensities and colours of lights.

The written values are stored by prim path. `carry_over` applies them to a model with other robots, and `put_back` restores the
initial values.

The initial intensity of each light is 1. The initial colour is the colour of the diffuse light in the file of the world. MuJoCo's
diffuse light is set to the colour times the intensity. Ambient and specular light are multiplied by the intensity, so that an
intensity of 0 switches the light off.
"""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np

from graphengine.descriptions.engine import collides, mujoco
from graphengine.devices.backend import Friction, Light
from graphengine.devices.stage import Prim, Stage
from graphengine.format.robot_spec import MaterialSpec
from graphengine.format.stateful import Stateful
from graphengine.physics.model.materials import against_floor
from graphengine.physics.model.world_prims import world_lights

T = TypeVar("T")


class Written(Stateful, Generic[T]):
    """The values that graphs wrote to prims, for example to materials, instead of the initial values.

    Args:
        stage: stage with the prims; the `facts` of a prim contain its initial values.
    """

    kept = ("written",)

    def __init__(self, stage: Stage) -> None:
        self._stage = stage
        self.written: dict[str, T] = {}
        """A dict from prim path to written value."""

    def built(self, prim: Prim) -> T:
        """Return the initial value of a prim."""
        raise NotImplementedError

    def tell(self, model: mujoco.MjModel, prim: Prim, value: T) -> None:
        """Write a prim's value to the model."""
        raise NotImplementedError

    def of(self, prim: Prim) -> T:
        """Return the current value of a prim."""
        return self.written[prim.path] if prim.path in self.written else self.built(prim)

    def write(self, model: mujoco.MjModel, prim: Prim, value: T) -> None:
        """Set the value of a prim."""
        self.tell(model, prim, value)
        self.written[prim.path] = value

    def carry_over(self, model: mujoco.MjModel) -> None:
        """Apply all written values to another model; values of removed prims are discarded."""
        self.written = {path: value for path, value in self.written.items() if path in self._stage}
        for path, value in self.written.items():
            self.tell(model, self._stage.find(path), value)

    def put_back(self, model: mujoco.MjModel) -> None:
        """Restore the initial values of all prims."""
        for prim in map(self._stage.find, self.written):
            self.tell(model, prim, self.built(prim))
        self.written.clear()


class Frictions(Written[Friction]):
    """Static and dynamic friction of a stage's materials. In the model, they are combined with the floor's friction."""

    def built(self, prim: Prim) -> Friction:
        """Return the initial friction of a material."""
        return prim.facts["static_friction"], prim.facts["dynamic_friction"]

    def tell(self, model: mujoco.MjModel, prim: Prim, value: Friction) -> None:
        """Write a material's friction to the colliders of all bodies to which the material is bound."""
        static, dynamic = value
        built, across = prim.facts["dynamic_friction"], prim.facts["across"] or 0.0
        # Friction across changes by the same factor.
        greatest = max(dynamic, across * dynamic / built if built else across)
        material = MaterialSpec(static_friction=static, dynamic_friction=greatest, combine=prim.facts["combine"])
        for body, wheel in prim.facts["bodies"].items():
            contact = against_floor(material, prim.facts["floor"], wheel=wheel)
            for geom in np.flatnonzero((model.geom_bodyid == model.body(body).id) & collides(model)):
                contact.tell(model.geom(geom))


class Lights(Written[Light]):
    """Intensity and colour of a stage's lights."""

    def built(self, prim: Prim) -> Light:
        """Return the initial intensity and colour of a light."""
        return 1.0, prim.facts["diffuse"]

    def tell(self, model: mujoco.MjModel, prim: Prim, value: Light) -> None:
        """Write the intensity and colour of a light to the model."""
        intensity, colour = value
        number = world_lights(model, [robot.entity_name for robot in self._stage.prims("robot")])[prim.facts["number"]]
        model.light_diffuse[number] = intensity * np.array(colour)
        model.light_ambient[number] = intensity * np.array(prim.facts["ambient"])
        model.light_specular[number] = intensity * np.array(prim.facts["specular"])
