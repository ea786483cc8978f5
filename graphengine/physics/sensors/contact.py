"""A contact sensor. It measures the mean contact force during a tick. So it does not miss a touch between two ticks.

The sensor measures contacts of the body that carries it. It ignores contacts of other bodies that are fixed to that body.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import model_validator

from graphengine.descriptions.engine import Floats, mujoco
from graphengine.devices.contact import ContactReading, ContactSensor
from graphengine.format.spec import NotNegative, Positive
from graphengine.physics.handles.motion_handles import CarriedPrim
from graphengine.physics.implementations import Profile, check_less, implements


class ContactProfile(Profile):
    """The parameters of a contact sensor."""

    threshold: NotNegative = 0.0
    """Force below which no contact is reported, N."""
    limit: Positive = 100_000.0
    """Greatest force reported, N; a greater force is clamped."""
    radius: NotNegative = 0.0
    """Radius around the sensor in which contacts count, m; with 0, all contacts of its body count."""

    @model_validator(mode="after")
    def _feels_something(self) -> ContactProfile:
        check_less(threshold=self.threshold, limit=self.limit)
        return self


@implements(ContactSensor, ContactProfile)
class BodyContactSensor(CarriedPrim):
    """The contact sensor at a prim; the prim's `facts` are the values of its profile."""

    sees_steps = True
    kept = ("_of_step", "_of_tick")

    def _set_up(self) -> None:
        self.reset()

    def bind(self) -> None:
        """Look up the body that carries the sensor, and its geoms."""
        super().bind()
        self._own = self._simulation.model.geom_bodyid == self.body

    def reset(self) -> None:
        """Set the measured forces to zero."""
        self._of_step, self._of_tick = np.zeros(3), np.zeros(3)

    def see_forces(self) -> None:
        """Add the contact force of a physics step to the force of the tick."""
        if self._simulation.in_first_step:
            self._of_tick = np.zeros(3)
        self._of_step = self._force()
        self._of_tick = self._of_tick + self._of_step

    def _force(self) -> Floats:
        """Return the sum of the forces, N, in the world frame, of all contacts of the body that are near the sensor."""
        total, wrench = np.zeros(3), np.empty(6)
        model, data = self._simulation.model, self._simulation.data
        if data.ncon == 0:
            return total
        first, second = self._own[data.contact.geom].T
        touching, frames = first != second, data.contact.frame
        if radius := self._prim.facts["radius"]:
            touching &= np.linalg.norm(data.contact.pos - self.pose()[0], axis=1) < radius
        for contact in np.flatnonzero(touching).tolist():
            mujoco.mj_contactForce(model, data, contact, wrench)
            # The rows of a contact's frame are its axes; the force is that on the second geom.
            force = wrench[:3] @ frames[contact].reshape(3, 3)
            total += force if second[contact] else -force
        return total

    def reading(self) -> ContactReading:
        """Return the mean force of this tick; for graphs that run per physics step, the force of this step."""
        simulation = self._simulation
        time, total = simulation.step_time, self._of_tick / simulation.substeps
        if simulation.stepping:
            total = self._of_step
        force = math.hypot(*total.tolist())
        if force == 0.0 or force < self._prim.facts["threshold"]:
            return ContactReading(time, False, 0.0)
        return ContactReading(time, True, min(force, self._prim.facts["limit"]))
