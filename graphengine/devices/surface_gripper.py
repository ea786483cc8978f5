"""Surface grippers, which hold things by suction: the Protocol and the stub."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol

from graphengine.devices.device import Sensor, Stub, device
from graphengine.devices.stage import Prim

GripperStatus = Literal["Open", "Closing", "Closed"]
"""`Closing` while some points of a gripper hold nothing and it tries to grip with them; `Closed` when all hold something."""


class SurfaceGripperDevice(Sensor, Protocol):
    """A gripper with one or several points; each holds the body in front of it, until it is pulled off."""

    @property
    def status(self) -> GripperStatus:
        """Status after the last physics step."""

    @property
    def gripped(self) -> Sequence[str]:
        """Paths of the prims of all held bodies, each once, in the order of the points; a body of the world's own is left out."""

    def close(self) -> None:
        """Start to grip what is in front of the points, in the next physics steps; no effect unless it is open."""

    def open(self) -> None:
        """Release everything at once."""


@device("surface_gripper", SurfaceGripperDevice, usd="IsaacSurfaceGripper", title="a surface gripper")
class SurfaceGripperStub(Stub):
    """A surface gripper that is closed at once; tests write what it holds to `reachable`."""

    reachable: Sequence[str] = ()

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        self.status: GripperStatus = "Open"

    @property
    def gripped(self) -> Sequence[str]:
        """Return what the test put within reach, if the gripper is closed."""
        return self.reachable if self.status == "Closed" else ()

    def close(self) -> None:
        """Close the gripper."""
        self.status = "Closed"

    def open(self) -> None:
        """Open the gripper."""
        self.status = "Open"
