"""Handles of conveyors, which set the surface velocity of a body."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from graphengine.descriptions.engine import wake
from graphengine.devices.rotation import Vector3
from graphengine.devices.stage import Prim
from graphengine.format.errors import PhysicsError
from graphengine.physics.core.handle_table import Handle

if TYPE_CHECKING:
    from graphengine.physics.core.simulation_core import SimulationCore

FASTEST = 1000.0
"""Greatest magnitude of each component of a surface's velocity, m/s or rad/s."""


class Conveyor(Handle["SimulationCore"]):
    """A handle to the moving surface of a body. If the body does not have a moving surface, creating the handle adds one."""

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        assert prim.body is not None
        self._body = prim.body
        if self._body not in simulation.surfaces.velocities:
            simulation.add_surfaces([self._body])
        super().__init__(simulation, prim)

    def bind(self) -> None:
        """Do nothing: the simulation itself looks up the surfaces of its model."""

    def move(self, linear: Vector3, angular: Vector3) -> None:
        """Set the velocity of the surface, starting with the next step.

        Args:
            linear: velocity in the body's frame, m/s.
            angular: angular velocity about the body's origin in its frame, rad/s.

        Raises:
            PhysicsError: a component is not finite, or its magnitude exceeds `FASTEST`; nothing has changed.
        """
        simulation = self._simulation
        if simulation.surfaces.velocities[self._body] == (linear, angular):  # a graph may write it each tick
            return
        if not all(abs(part) <= FASTEST for part in itertools.chain(linear, angular)):
            raise PhysicsError(
                f"{self.prim_path}: no component of a surface velocity may exceed {FASTEST:g} m/s or rad/s in magnitude"
            )
        simulation.surfaces.velocities[self._body] = linear, angular
        simulation.surfaces.hold()
        wake(simulation.model, simulation.data)  # sleeping bodies do not react to the belt below them
        simulation.refresh()
