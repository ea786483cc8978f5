"""Entities: the robots and objects of a world, which can be inspected, moved and pushed.

Positions are in the world frame, m; quaternions are (x, y, z, w).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from graphengine.devices.sensor import Quaternion, Vector3

EntityKind = Literal["robot", "object", "static"]
"""A `robot` has joints or sensors, an `object` moves, and what is `static` stands where it was put."""
MOST_TOLD = 3
"""Overlaps that a warning names."""


@dataclass(frozen=True, slots=True)
class Entity:
    """One robot or object of a world, with all bodies attached to it."""

    name: str
    """Unique in its world: the last element of the prim's path, or all of it where a robot has that name."""
    prim_path: str
    kind: EntityKind
    spawned: bool
    """Whether it came while the world was running."""


@dataclass(frozen=True, slots=True)
class EntityState:
    """Pose of an entity's prim and velocity of its origin, in the world frame."""

    position: Vector3
    orientation: Quaternion
    linear_velocity: Vector3
    """m/s."""
    angular_velocity: Vector3
    """rad/s."""
    linear_acceleration: Vector3
    """m/s2; gravity is among what causes it: -9.81 along z in free fall, zero at rest."""
    angular_acceleration: Vector3
    """rad/s2."""


@dataclass(frozen=True, slots=True)
class Move:
    """A new pose and velocity for an entity, in the world frame."""

    position: Vector3 | None = None
    """Of its prim, m; None for the present one."""
    orientation: Quaternion | None = None
    """Of its prim, of any length but zero; None for the present one."""
    linear: Vector3 | None = None
    """Velocity of its prim's origin, m/s; None for rest."""
    angular: Vector3 | None = None
    """Velocity, rad/s; None for rest."""


@dataclass(frozen=True, slots=True)
class Overlap:
    """An object that an entity overlaps."""

    other: str
    """Name of the other entity; for what belongs to none, such as a floor, that of the shape."""
    depth: float
    """How far they are to be pushed apart, m."""


@dataclass(frozen=True, slots=True)
class Box:
    """A box along the axes of a frame, given by two opposite corners, m."""

    low: Vector3
    high: Vector3


def warning(name: str, overlaps: Sequence[Overlap]) -> str:
    """The warning for a moved entity that overlaps objects; empty without overlaps."""
    if not overlaps:
        return ""
    told = [f"{overlap.depth:.2g} m deep in {overlap.other}" for overlap in overlaps[:MOST_TOLD]]
    told += [f"in {more} more"] if (more := len(overlaps) - MOST_TOLD) > 0 else []
    return f"{name} is {', '.join(told)}: physics pushes them apart at once, which may throw them far"
