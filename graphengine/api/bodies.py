"""Poses, velocities and contacts of robots, objects and links."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graphengine.api.guards import reading
from graphengine.api.runner import Runner
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.devices.stage import Prim
from graphengine.format.errors import PrimError, UnknownEntityError
from graphengine.format.wording import unknown


@dataclass(frozen=True, slots=True)
class Pose:
    """Position and orientation of a body.

    Attributes:
        position: position in the world frame, m.
        orientation: orientation in the world frame as a quaternion (x, y, z, w).
    """

    position: Vector3
    orientation: Quaternion


@dataclass(frozen=True, slots=True)
class Velocity:
    """Linear and angular velocity of a body.

    Attributes:
        linear: velocity of the body's origin in the world frame, m/s.
        angular: angular velocity in the world frame, rad/s.
    """

    linear: Vector3
    angular: Vector3


class Body:
    """A robot, an object or another prim with a pose; each property returns its value in the current tick.

    Attributes:
        name: name of a robot or object, or a prim path.
    """

    def __init__(self, runner: Runner, name: str) -> None:
        self._runner = runner
        self.name = name
        self._path = ""

    @property
    @reading
    def pose(self) -> Pose:
        """Pose in the world frame: position in m, orientation as a quaternion (x, y, z, w)."""
        return Pose(*self._runner.session.services.world.frame(self.find()).pose())

    @property
    @reading
    def velocity(self) -> Velocity:
        """Velocity in the world frame, m/s and rad/s."""
        return Velocity(*self._runner.session.services.world.body(self.find()).velocity())

    @property
    @reading
    def touched(self) -> tuple[str, ...]:
        """Names of all bodies that the robot or object touched in any physics step of the last tick, including the floor.

        A shape that belongs to no robot or object, such as a wall, is listed by its own name. The first access covers only the
        contacts after the last step.
        """
        return tuple(self._runner.session.services.world.entities.touched(self.name))

    @reading
    def clearance(self, margin: float = 2.0) -> Mapping[str, float]:
        """Return the distances (m) to all robots, objects and walls within `margin` (m) by name, nearest first.

        A distance is measured from the volume that the body sweeps when it turns about its vertical axis.
        """
        x, y, _ = self.pose.position
        return self._runner.session.services.world.entities.clearance(self.name, (x, y), margin)

    def find(self) -> Prim:
        """Return the prim.

        Raises:
            UnknownEntityError: no robot or object has the name, or no prim has the path.
        """
        services = self._runner.session.services
        if not self._path:
            names = {entity.name: entity.prim_path for entity in services.world.entities.all()}
            if self.name not in names and not self.name.startswith("/"):
                raise UnknownEntityError(unknown("entity", self.name, names))
            self._path = names.get(self.name, self.name)
        try:
            return services.stage.find(self._path)
        except PrimError as error:
            raise UnknownEntityError(str(error)) from None
