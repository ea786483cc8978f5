"""Contact sensors: the Protocol and the stub."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from graphengine.devices.device import Sensor, Stub, device


@dataclass(frozen=True, slots=True)
class ContactReading:
    """The measurement of a contact sensor in one tick."""

    time: float
    """Simulation time, s."""
    in_contact: bool
    """Whether the force is above the sensor's threshold."""
    force: float
    """Magnitude of the sum of contact forces, N; at most the sensor's range."""


class ContactSensor(Sensor, Protocol):
    """A sensor of contact forces on its body, or on the part of the body near the sensor."""

    def reading(self) -> ContactReading:
        """Return the reading of this tick."""


@device("contact", ContactSensor, usd="IsaacContactSensor", title="a contact sensor", rank=4)
class ContactSensorStub(Stub):
    """A contact sensor whose reading tests write to `felt`; no contact at first."""

    felt = ContactReading(0.0, False, 0.0)

    def reading(self) -> ContactReading:
        """Return the reading set by the test."""
        return self.felt
