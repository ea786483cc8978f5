"""Surface grippers, which hold bodies by suction: the Protocol and the stub."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol

from graphengine.devices.device import Sensor, Stub, device
from graphengine.devices.stage import Prim

GripperStatus = Literal["Open", "Closing", "Closed"]
"""`Closing` while the gripper tries to grip with points that hold no body yet; `Closed` when all points hold one."""


class SurfaceGripperDevice(Sensor, Protocol):
    """A gripper with one or several points; each point grips the body in front of it, until the body is pulled off."""

    @property
    def status(self) -> GripperStatus:
        """Status after the last physics step."""

    @property
    def gripped(self) -> Sequence[str]:
        """Prim paths of all held bodies, each once, in the order of the points; geometry that belongs to no body is left out."""

    def close(self) -> None:
        """Start to grip the bodies in front of the points, from the next physics step on; no effect unless open."""

    def open(self) -> None:
        """Release all bodies immediately."""


@device("surface_gripper", SurfaceGripperDevice, usd="IsaacSurfaceGripper", title="a surface gripper")
class SurfaceGripperStub(Stub):
    """A surface gripper that closes immediately; tests write the paths of the bodies within reach to `reachable`."""

    reachable: Sequence[str] = ()

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        self.status: GripperStatus = "Open"

    @property
    def gripped(self) -> Sequence[str]:
        """Return `reachable` if the gripper is closed."""
        return self.reachable if self.status == "Closed" else ()

    def close(self) -> None:
        """Close immediately, gripping all bodies in `reachable`."""
        self.status = "Closed"

    def open(self) -> None:
        """Open immediately, releasing all bodies."""
        self.status = "Open"
