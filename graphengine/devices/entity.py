"""Data types for entities: the robots and objects of a world, which users can inspect, move and push.

Positions are in the world frame, m; quaternions are (x, y, z, w).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.format.errors import BlockedPoseError

EntityKind = Literal["robot", "object", "static", "mover"]
"""A `robot` has joints or sensors. Of the other entities, an `object` can move, a `static` entity cannot, and a `mover` follows
its path in the scene."""
MOST_TOLD = 3
"""Maximum number of overlaps or entities that a finding or warning lists."""


@dataclass(frozen=True, slots=True)
class Entity:
    """One robot or object of a world, including all bodies attached to it."""

    name: str
    """Unique name: a robot's name, or the last element of an object's path; `World/box` if a robot is also named `box`."""
    prim_path: str
    kind: EntityKind
    spawned: bool
    """Whether the entity was added while the simulation ran."""


@dataclass(frozen=True, slots=True)
class EntityState:
    """Pose, velocity and acceleration of an entity's prim in the world frame."""

    position: Vector3
    orientation: Quaternion
    linear_velocity: Vector3
    """Velocity of the prim's origin, m/s."""
    angular_velocity: Vector3
    """Angular velocity, rad/s."""
    linear_acceleration: Vector3
    """Acceleration of the prim's origin, m/s2: (0, 0, -9.81) in free fall, zero at rest."""
    angular_acceleration: Vector3
    """Angular acceleration, rad/s2."""


@dataclass(frozen=True, slots=True)
class Move:
    """A new pose and velocity for an entity in the world frame."""

    position: Vector3 | None = None
    """Position of the entity's prim, m; None keeps the current position."""
    orientation: Quaternion | None = None
    """Orientation of the entity's prim as a quaternion, which need not be normalized; None keeps the current orientation."""
    linear: Vector3 | None = None
    """Velocity of the prim's origin, m/s; None stands for zero."""
    angular: Vector3 | None = None
    """Angular velocity, rad/s; None stands for zero."""


@dataclass(frozen=True, slots=True)
class Overlap:
    """Another object that overlaps an entity, and the depth of the overlap."""

    other: str
    """Name of the other entity. For a shape that belongs to no entity, such as a floor, the name of the shape."""
    depth: float
    """Depth of the overlap, m."""


@dataclass(frozen=True, slots=True)
class Box:
    """A box whose edges are parallel to the axes of a frame, given by two opposite corners in this frame, m."""

    low: Vector3
    high: Vector3


def warning(name: str, overlaps: Sequence[Overlap]) -> str:
    """Return the warning that an entity overlaps other objects after it was placed; empty without overlaps."""
    if not overlaps:
        return ""
    return f"{name} is {_listed(overlaps)}: physics pushes them apart at once, which may throw them far"


def refuse(name: str, overlaps: Sequence[Overlap]) -> None:
    """Do nothing without overlaps.

    Raises:
        BlockedPoseError: there are overlaps; the message names them.
    """
    if overlaps:
        remedy = "choose another pose, or force it with `force` (graphrun ctl: --force)"
        raise BlockedPoseError(f"{name} would be {_listed(overlaps)}: nothing was changed\n  {remedy}")


def _listed(overlaps: Sequence[Overlap]) -> str:
    told = [f"{overlap.depth:.2g} m deep in {overlap.other}" for overlap in overlaps[:MOST_TOLD]]
    told += [f"in {more} more"] if (more := len(overlaps) - MOST_TOLD) > 0 else []
    return ", ".join(told)
