"""Implements `devices.backend.World` with one MuJoCo model and its state."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from graphengine.descriptions.engine import Floats
from graphengine.devices.backend import Friction, Light
from graphengine.devices.contact_points import Contacts
from graphengine.devices.device import device_of
from graphengine.devices.rotation import Vector3, vector
from graphengine.devices.stage import Prim
from graphengine.devices.visible import Bodies
from graphengine.format.errors import ContextError
from graphengine.physics.dynamics.contact_forces import contact_points
from graphengine.physics.dynamics.held_bodies import find_mover
from graphengine.physics.handles.conveyors import Conveyor
from graphengine.physics.handles.motion_handles import CarriedPrim, Joints, PlacedBody
from graphengine.physics.handles.mujoco_entities import MujocoEntities
from graphengine.physics.implementations import IMPLEMENTATIONS
from graphengine.physics.pictures.pictured_simulation import PicturedSimulation
from graphengine.physics.pictures.visible_bodies import visible_bodies
from graphengine.physics.ray_casting.rays import compile_kernels

D = TypeVar("D")


class Simulation(PicturedSimulation):
    """The physics and sensors of a scene: gives handles to prims, and reads and writes their settings.

    The methods do not check a prim's kind; callers must do so. Arguments and errors are those of `SimulationCore`.
    """

    @cached_property
    def entities(self) -> MujocoEntities:
        """The robots and objects of the world."""
        return MujocoEntities(self)

    def bodies(self) -> Bodies:
        """Return all bodies with their visible shapes. The bodies change when a robot is added or removed."""
        return visible_bodies(self.model)

    def poses(self) -> Floats:
        """Return position (m) and quaternion (x, y, z, w) of each body in the world frame as a new array, shape (bodies, 7)."""
        return np.hstack([self.data.xpos, self.data.xquat[:, [1, 2, 3, 0]]])

    def contacts(self) -> Contacts:
        """Return all contact points of the current state with their forces, except for contacts of sleeping bodies."""
        return contact_points(self.model, self.forces.now())

    def body(self, prim: Prim) -> CarriedPrim:
        """Return a handle to the pose and velocity of a prim, which moves with its own body or with the body that carries it."""
        return self.handles.find(CarriedPrim, prim)

    frame = body

    @property
    def gravity(self) -> Vector3:
        """The acceleration of free fall in the world frame, m/s2."""
        return vector(self.model.opt.gravity)

    def set_gravity(self, gravity: Vector3) -> None:
        """Set gravity (m/s2, world frame) for all later steps, and wake sleeping bodies."""
        if gravity == self.gravity:  # a graph may write it each tick, and then nothing would ever sleep
            return
        self.model.opt.gravity = gravity
        self.wake_all()

    def friction(self, prim: Prim) -> Friction:
        """Return static and dynamic friction of a material prim."""
        return self._frictions.of(prim)

    def set_friction(self, prim: Prim, friction: Friction) -> None:
        """Set static and dynamic friction of a material for all later steps, and wake sleeping bodies."""
        if friction == self._frictions.of(prim):
            return
        self._frictions.write(self.model, prim, friction)
        self.wake_all()

    def conveyor(self, prim: Prim) -> Conveyor:
        """Return a handle to the surface velocity of a body.

        Raises:
            ContextError: a joint moves the body.
        """
        assert prim.body is not None
        if prim.body not in self.surfaces.velocities and self.model.body(prim.body).jntnum[0]:
            advice = "a conveyor must be fixed to the world or to another body; for a robot, write fixed_base: true"
            raise ContextError(f"{prim.path} cannot be a conveyor: a joint moves it", prim.path, advice)
        return self.handles.find(Conveyor, prim)

    def light(self, prim: Prim) -> Light:
        """Return intensity and colour of a light prim."""
        return self._lights.of(prim)

    def set_light(self, prim: Prim, light: Light) -> None:
        """Set intensity and colour of a light for later images."""
        self._lights.write(self.model, prim, light)

    def mass(self, prim: Prim) -> float:
        """Return the mass of the prim's own body, kg."""
        assert prim.body is not None
        return float(self.model.body(prim.body).mass[0])

    def placement(self, prim: Prim) -> PlacedBody | None:
        """Return a handle that places the prim's body at a pose and holds it there; None if the body cannot be moved alone."""
        return self.handles.find(PlacedBody, prim) if find_mover(self.model, self.stage, prim) is not None else None

    def articulation(self, robot: Prim) -> Joints:
        """Return a handle to the joints of a robot prim."""
        return self.handles.find(Joints, robot)

    def compile_kernels(self) -> None:
        """Compile the kernels that the sensors of the stage need. The set-up of nodes then does not wait for the compiler."""
        kinds = {prim.kind for prim in self.stage.prims()} & IMPLEMENTATIONS.all.keys()
        if any(getattr(IMPLEMENTATIONS.all[kind].handle, "casts_rays", False) for kind in kinds):
            compile_kernels(self._rays_choice)

    def device(self, interface: Callable[..., D], prim: Prim, **options: Any) -> D:
        """Return the device (such as a sensor) at a prim; calls with equal options return the same object."""
        found: D = self.handles.find(IMPLEMENTATIONS.all[device_of(interface).kind].handle, prim, **options)
        return found
