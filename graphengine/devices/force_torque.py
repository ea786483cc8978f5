"""The Protocol of force-torque sensors, their readings, and a force-torque sensor stub for tests."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from graphengine.devices.device import ReadingStub, TickSensor, device, when_due
from graphengine.devices.rotation import ORIGIN, Vector3
from graphengine.devices.stage import Prim
from graphengine.format.errors import ContextError


@dataclass(frozen=True, slots=True)
class Wrench:
    """The force and the torque that a joint transmits, mean over one tick. The profile selects their axes and their sign."""

    time: float
    """Simulation time at the end of the tick, s."""
    index: int
    """Sample index since the start of play."""
    force: Vector3
    """Force, N."""
    torque: Vector3
    """Torque about the sensor's origin, N m."""


class ForceTorqueSensor(TickSensor, Protocol):
    """A sensor in the joint above a link. It measures the wrench between this link and its parent link."""

    def reading(self) -> Wrench:
        """Return the newest sample; all callers get the same object."""


def measured_link(prim: Prim) -> Prim:
    """Return the link on which a sensor is mounted; the sensor measures in the joint above this link.

    Raises:
        ContextError: the sensor is not on a link, or no joint carries the link.
    """
    link = prim.nearest("link") or prim
    if link.parent is None or link.parent.kind != "link":
        advice = "mount it on the child link of the joint at which it measures"
        raise ContextError(f"{prim.path} has no joint above it: it is on the root link", prim.path, advice)
    return link


@device(
    "force_torque",
    ForceTorqueSensor,
    usd="ForceTorqueSensor",
    title="a force-torque sensor",
    sample=when_due("reading"),
)
class ForceTorqueStub(ReadingStub[Wrench]):
    """A force-torque sensor for tests. It reports the wrench that a test sets with `measure`; initially, the wrench is 0."""

    measured = Wrench(0.0, 0, ORIGIN, ORIGIN)

    def __init__(self, prim: Prim) -> None:
        measured_link(prim)
        super().__init__(prim)

    def measure(self, force: Vector3, torque: Vector3, *, time: float = 0.0, index: int = 0) -> None:
        """Set the force (N), torque (N m), simulation time (s) and index of this tick's sample."""
        self.due, self.index, self.measured = True, index, Wrench(time, index, force, torque)
