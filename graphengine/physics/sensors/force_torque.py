"""A force-torque sensor. It measures the wrench that the joint above its link transmits; this joint may be fixed.

The wrench is the mean over the physics steps of a tick: the transmitted impulse, divided by the duration of the tick. It follows
from the accelerations of the links beyond the joint and from the forces on them: gravity, contacts, constraints, pushes.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from graphengine.descriptions.engine import Floats
from graphengine.devices.force_torque import ForceTorqueSensor, Wrench, measured_link
from graphengine.devices.rotation import vector
from graphengine.physics.implementations import Deviation, Profile, Rate, implements
from graphengine.physics.sensors.sampling import TickSampled


class ForceTorqueProfile(Profile):
    """The parameters of a force-torque sensor. The torque is about the sensor's origin."""

    rate: Rate = 60.0
    """Samples per second; at most one per tick."""
    measure_direction: Literal["child_to_parent", "parent_to_child"] = Field(
        default="child_to_parent",
        description="child_to_parent: the wrench that the sensor's link exerts on its parent link, for example the weight of a "
        "gripper; parent_to_child: the opposite one.",
    )
    axes: Literal["sensor", "parent"] = "sensor"
    """Axes of force and torque: those of the sensor, or those of the parent link."""
    force_noise: Deviation = 0.0
    """Standard deviation of the noise of each force, N."""
    torque_noise: Deviation = 0.0
    """Standard deviation of the noise of each torque, N m."""


@implements(ForceTorqueSensor, ForceTorqueProfile)
class JointWrenchSensor(TickSampled[Wrench]):
    """The force-torque sensor at a prim; the prim's `facts` are the values of its profile."""

    sees_steps = True
    kept = (*TickSampled.kept, "_sum")

    def _set_up(self) -> None:
        self._sum = np.zeros(6)
        facts = self._prim.facts
        self._noise = np.repeat((facts["force_noise"], facts["torque_noise"]), 3)
        super()._set_up()

    def bind(self) -> None:
        """Look up the bodies of the sensor's link and of its parent link.

        Raises:
            ContextError: no joint carries the sensor's link.
        """
        super().bind()
        link, model = measured_link(self._prim), self._simulation.model
        above = link.parent.body if link.parent is not None else None
        self._parent = model.body(above).id if above is not None else 0
        self._sign = 1.0 if self._prim.facts["measure_direction"] == "parent_to_child" else -1.0
        self._weightless = link.body is None  # a frame with nothing beyond it

    def reset(self) -> None:
        """Discard the newest sample and the forces of the tick."""
        super().reset()
        self._sum = np.zeros(6)

    def see_forces(self) -> None:
        """Add the wrench of this physics step to the sum of the tick."""
        if self._simulation.in_first_step:
            self._sum = np.zeros(6)
        if not self._weightless:
            self._sum = self._sum + self._wrench()

    def _wrench(self) -> Floats:
        """Return force (N) and torque (N m) of this physics step, shape (6,)."""
        data, (position, axes) = self._simulation.forces.of_step(), self.frame()
        if self._prim.facts["axes"] == "parent":
            axes = data.xmat[self._parent].reshape(3, 3)
        # cfrc_int acts on the child link, in the world's axes; its torque is about the centre of mass of the whole tree.
        torque, force = np.split(data.cfrc_int[self.body], 2)
        torque = torque + np.cross(self._centre - position, force)
        return self._sign * np.concatenate((force @ axes, torque @ axes))

    def _make_sample(self, index: int) -> Wrench:
        values = self._sum / self._simulation.substeps
        if self._noise.any():
            values = values + self._noise * self._noise_of(index).standard_normal(6)
        return Wrench(self._simulation.time, index, vector(values[:3]), vector(values[3:]))
