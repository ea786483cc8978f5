"""The Protocol of surface grippers, which hold bodies by suction, and a surface gripper stub for tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, Protocol

from graphengine.devices.device import Sensor, Stub, device
from graphengine.devices.stage import Prim

GripperStatus = Literal["Open", "Closing", "Closed"]
"""Status of a surface gripper: `Closing` until all grip points hold a body, then `Closed`."""


class SurfaceGripperDevice(Sensor, Protocol):
    """A suction gripper with one or several grip points.

    A closed point holds the body in front of it until the body is pulled off.
    """

    @property
    def status(self) -> GripperStatus:
        """Status of the gripper after the last physics step."""

    @property
    def gripped(self) -> Sequence[str]:
        """Prim paths of all held bodies, each once, in the order of the grip points; geometry without a body is left out."""

    def close(self) -> None:
        """Start to grip the bodies in front of the grip points, from the next physics step on.

        The call has no effect if the gripper is not open.
        """

    def open(self) -> None:
        """Release all bodies immediately."""


@device("surface_gripper", SurfaceGripperDevice, usd="IsaacSurfaceGripper", title="a surface gripper")
class SurfaceGripperStub(Stub):
    """A surface gripper for tests. It closes immediately, and then holds the bodies whose paths a test assigns to `reachable`."""

    reachable: Sequence[str] = ()

    def __init__(self, prim: Prim) -> None:
        super().__init__(prim)
        self.status: GripperStatus = "Open"

    @property
    def gripped(self) -> Sequence[str]:
        """Return `reachable` if the gripper is closed; otherwise an empty sequence."""
        return self.reachable if self.status == "Closed" else ()

    def close(self) -> None:
        """Close immediately, gripping all bodies in `reachable`."""
        self.status = "Closed"

    def open(self) -> None:
        """Open immediately, releasing all bodies."""
        self.status = "Open"
