"""Where a prim is, as attributes; those of robots and free bodies can be written."""

from __future__ import annotations

from typing import Any

from graphengine.devices.backend import World
from graphengine.devices.entity import Move
from graphengine.devices.rotation import Pose, compose, relative
from graphengine.devices.stage import Prim
from graphengine.node.prims.attribute import Attribute, numbers


class _Pose:
    """Where a prim is, relative to its parent."""

    def __init__(self, world: World, prim: Prim) -> None:
        self.movable = any(entity.prim_path == prim.path for entity in world.entities.all())
        self._world = world
        self._prim = prim

    def translate(self) -> list[float]:
        """Position, m."""
        return list(self._read()[0])

    def orient(self) -> list[float]:
        """Orientation, the real part first."""
        x, y, z, w = self._read()[1]
        return [w, x, y, z]

    def set_translate(self, value: Any) -> None:
        """Move it, and leave its orientation."""
        x, y, z = numbers(value, 3)
        self._put(((x, y, z), self._read()[1]))

    def set_orient(self, value: Any) -> None:
        """Turn it, and leave its position."""
        w, x, y, z = numbers(value, 4)
        self._put((self._read()[0], (x, y, z, w)))

    def _parent(self) -> Pose:
        assert self._prim.parent is not None  # the root has no pose
        return self._world.frame(self._prim.parent).pose()

    def _read(self) -> Pose:
        return relative(self._parent(), self._world.frame(self._prim).pose())

    def _put(self, pose: Pose) -> None:
        """Let it go on from there as fast as it was."""
        there = Move(*compose(self._parent(), pose), *self._world.body(self._prim).velocity())
        self._world.entities.place(self._prim.path, there)


def pose_attributes(world: World, prim: Prim) -> dict[str, Attribute]:
    """Position and orientation."""
    pose = _Pose(world, prim)
    return {
        "xformOp:translate": Attribute("double3", pose.translate, pose.set_translate if pose.movable else None),
        "xformOp:orient": Attribute("quatd", pose.orient, pose.set_orient if pose.movable else None),
    }
