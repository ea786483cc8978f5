"""The Protocol of contact sensors, their readings, and a contact sensor stub for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from graphengine.devices.device import Sensor, Stub, device, when_due


@dataclass(frozen=True, slots=True)
class ContactReading:
    """The measurement of a contact sensor in one tick or physics step."""

    time: float
    """Simulation time of the measurement, s."""
    in_contact: bool
    """Whether the contact force is not zero and reaches the sensor's threshold."""
    force: float
    """Magnitude of the sum of the contact forces, N, limited to the sensor's range; 0 below the threshold."""


class ContactSensor(Sensor, Protocol):
    """A sensor that measures the contact forces on a body, or only those within a radius around the sensor."""

    def reading(self) -> ContactReading:
        """Return the mean force of this tick; in a graph that runs at physics steps, the force of this step."""


@device(
    "contact", ContactSensor, usd="IsaacContactSensor", title="a contact sensor", rank=4, sample=when_due("reading")
)
class ContactSensorStub(Stub):
    """A contact sensor for tests. It reports the reading that a test assigns to `felt`; initially there is no contact."""

    felt = ContactReading(0.0, False, 0.0)

    def reading(self) -> ContactReading:
        """Return the value of `felt`."""
        return self.felt
