"""What a joint does and what its drive is told, as attributes; those of the drive can be written."""

from __future__ import annotations

import math
from typing import Any

from graphengine.devices.backend import World
from graphengine.devices.motion import Articulation
from graphengine.devices.stage import Prim
from graphengine.node.prims.attribute import Attribute, numbers


class _Joint:
    """A joint that moves, in degrees or metres."""

    def __init__(self, articulation: Articulation, name: str) -> None:
        self._articulation = articulation
        self._selection = articulation.select([name])
        self._index = articulation.joint_names.index(name)
        slides = articulation.prismatic[self._index]
        self.kind, self.unit = ("linear", 1.0) if slides else ("angular", math.degrees(1.0))

    def position(self) -> float:
        """Where it is."""
        return float(self._articulation.positions()[self._index]) * self.unit

    def velocity(self) -> float:
        """How fast it moves, in units a second."""
        return float(self._articulation.velocities()[self._index]) * self.unit

    def target_position(self) -> float:
        """Where its drive wants it; NaN without stiffness."""
        return float(self._articulation.set_points()[0][self._index]) * self.unit

    def target_velocity(self) -> float:
        """How fast its drive wants it; NaN without damping."""
        return float(self._articulation.set_points()[1][self._index]) * self.unit

    def set_target_position(self, value: Any) -> None:
        """Tell the drive."""
        self._selection.command(positions=[numbers([value], 1)[0] / self.unit])

    def set_target_velocity(self, value: Any) -> None:
        """Tell the drive."""
        self._selection.command(velocities=[numbers([value], 1)[0] / self.unit])


def joint_attributes(world: World, prim: Prim) -> dict[str, Attribute]:
    """What a joint does, and what its drive is told."""
    found = {"physics:jointEnabled": Attribute("bool", lambda: bool(prim.facts.get("enabled", True)))}
    robot, name = world.stage.robot_of(prim), prim.facts.get("joint", prim.name)
    if robot is None or name not in robot.facts.get("joints", ()):
        return found
    joint = _Joint(world.articulation(robot), name)
    state, drive = f"state:{joint.kind}:physics", f"drive:{joint.kind}:physics"
    found[f"{state}:position"] = Attribute("float", joint.position)
    found[f"{state}:velocity"] = Attribute("float", joint.velocity)
    if not math.isnan(joint.target_position()):
        found[f"{drive}:targetPosition"] = Attribute("float", joint.target_position, joint.set_target_position)
    if not math.isnan(joint.target_velocity()):
        found[f"{drive}:targetVelocity"] = Attribute("float", joint.target_velocity, joint.set_target_velocity)
    return found
