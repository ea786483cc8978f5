"""Handles that set the surface velocity of a body, for conveyors."""

from __future__ import annotations

import itertools

from graphengine.devices.rotation import Vector3
from graphengine.format.errors import PhysicsError
from graphengine.physics.handles.motion_handles import CoreHandle

FASTEST = 1000.0
"""Greatest magnitude of each component of a surface's velocity, m/s or rad/s."""


class Conveyor(CoreHandle):
    """A handle to the moving surface of a body. If the body does not have a moving surface, creating the handle adds one."""

    def _set_up(self) -> None:
        assert self._prim.body is not None
        self._body = self._prim.body
        if self._body not in self._simulation.surfaces.velocities:
            self._simulation.add_surfaces([self._body])

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
            text = f"no component of a surface velocity may exceed {FASTEST:g} m/s or rad/s in magnitude"
            raise PhysicsError(f"{self.prim_path}: {text}")
        simulation.surfaces.velocities[self._body] = linear, angular
        simulation.surfaces.hold()
        simulation.wake_all()  # sleeping bodies do not react to the belt below them
