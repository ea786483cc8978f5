"""A world without physics for tests. A test adds bodies, robots and devices as stubs, and sets and reads their values."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from graphengine.devices.device import device_of
from graphengine.devices.dry_world import ArticulationStub, BodyStub, DryEntities, DryWorld
from graphengine.devices.entity import Move
from graphengine.devices.rotation import IDENTITY, ORIGIN, Quaternion, Vector3
from graphengine.devices.stage import Stage

D = TypeVar("D")


class RecordingEntities(DryEntities):
    """The movable robots and bodies of a RecordingWorld, by prim path."""

    def __init__(self, world: RecordingWorld) -> None:
        super().__init__(world.stage)
        self._world = world

    def place(self, name: str, move: Move, *, forced: bool = True) -> None:
        """Move a robot or body to a pose with a velocity; fields of `move` that are not set keep the present value."""
        body = self._world.body(self._world.stage.find(name))
        present = body.pose()
        body.place(move.position or present[0], move.orientation or present[1])
        body.linear, body.angular = move.linear or body.linear, move.angular or body.angular


class RecordingWorld(DryWorld):
    """A world without physics for tests. A test adds bodies, robots and devices, and moves them.

    To add prims of other kinds, call `stage.add`. A `RecordingContext` has such a world in its attribute `world`.
    """

    def __init__(self, tick_period: tuple[int, int] = (1, 60), substeps: int = 1) -> None:
        super().__init__(Stage(), tick_period, substeps)

    def add_body(self, path: str, position: Vector3 = ORIGIN, orientation: Quaternion = IDENTITY) -> BodyStub:
        """Add a rigid body at a pose in the world frame (position in m), and return the body's stub."""
        prim = self.stage.add(path, "body", position=position, orientation=orientation, body=path)
        return self._bodies.setdefault(prim, BodyStub(position, orientation))

    def add_robot(self, path: str, joints: Sequence[str] = (), **facts: Any) -> ArticulationStub:
        """Add a robot with the given joints, and return the stub of its articulation.

        The robot's root prim is a body; its only link is `Geometry/base_link`. `facts` are further properties of the robot.
        """
        base = f"{path}/Geometry/base_link"
        robot = self.stage.add(path, "robot", body=base, facts={"base_link": base, "joints": tuple(joints), **facts})
        self.stage.add(base, "link", body=base)
        self._bodies[robot] = BodyStub()
        return self.articulation(robot)

    def add_device(self, stub: Callable[..., D], path: str, **facts: Any) -> D:
        """Add the prim of a device, and return the device's stub.

        Args:
            stub: class of the stub, such as `LidarStub`.
            path: path of the device's prim.
            facts: properties of the device that the stub reads, such as `rate` (Hz).
        """
        return self.device(stub, self.stage.add(path, device_of(stub).kind, facts=facts))

    @property
    def entities(self) -> RecordingEntities:
        """All entities of the world: one for each robot and one for each body."""
        return RecordingEntities(self)
