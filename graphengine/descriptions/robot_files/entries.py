"""The entries of a robot file that will be written: the keys of each section, as `robot_spec` describes them, and comments."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Generic, Literal, TypedDict, TypeVar

K = TypeVar("K")


class DriveKeys(TypedDict, total=False):
    """Keys of a `DriveSpec`."""

    damping: float
    stiffness: float
    target_velocity: float
    max_force: float
    max_acceleration: float
    max_velocity: float
    overtravel: float
    interpolate: bool
    gravity_compensation: bool


class JointKeys(TypedDict, total=False):
    """Keys of a `JointSpec`."""

    drive: DriveKeys
    armature: float
    start: float
    limits: list[float]
    spring: dict[str, float]


class LinkKeys(TypedDict, total=False):
    """Keys of a `LinkSpec`."""

    gravity: bool
    colour: list[float]


class WheelKeys(TypedDict, total=False):
    """Keys of a `WheelColliderSpec`."""

    shape: str
    radius: float
    width: float
    offset: float


WheelCollider = WheelKeys | Literal["ellipsoid"]
"""Value of a wheel collider; `ellipsoid` keeps the size of a cylinder."""


class MaterialKeys(TypedDict, total=False):
    """Keys of a `MaterialSpec`."""

    static_friction: float
    dynamic_friction: float
    restitution: float
    across: float
    direction: list[float]
    expressed_in: str
    steady_sliding: bool
    combine: str
    bind: list[str]


class SensorKeys(TypedDict, total=False):
    """Keys of a `SensorSpec`."""

    type: str
    parent: str
    position: list[float]
    orientation: dict[str, list[float]]
    profile: dict[str, Any] | str
    sees_own_robot: bool


class GraphKeys(TypedDict, total=False):
    """Keys of a `GraphUse`."""

    use: str
    parameters: dict[str, Any]


@dataclass(slots=True)
class Entry(Generic[K]):
    """A key of a section with its value, and the comments of the import on them.

    Attributes:
        value: keys and values, in the order in which they are written.
        comments: lines of the comment above the key.
        hint: comment after the value, on the same line.
    """

    value: K
    comments: list[str] = field(default_factory=list)
    hint: str = ""


def material(friction: float, combine: str, bind: list[str], directed: MaterialKeys | None = None) -> MaterialKeys:
    """Return the keys of a material; `directed` has the keys of a friction that differs across a direction."""
    both: MaterialKeys = {"static_friction": friction, "dynamic_friction": friction}
    return both | (directed or {}) | {"combine": combine, "bind": bind}
