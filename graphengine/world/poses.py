"""Positions and rotations as plain tuples: metres, unit quaternions (x, y, z, w)."""

from __future__ import annotations

import math

from graphengine.context import Quaternion, Vector3
from graphengine.spec import Orientation
from graphengine.stage import IDENTITY, ORIGIN, Prim

Pose = tuple[Vector3, Quaternion]

NOWHERE: Pose = (ORIGIN, IDENTITY)
"""The pose that changes nothing."""


def rotate(rotation: Quaternion, vector: Vector3) -> Vector3:
    """The vector turned by the rotation: v + 2 q x (q x v + w v)."""
    x, y, z, w = rotation
    a, b, c = vector
    s, t, u = y * c - z * b + w * a, z * a - x * c + w * b, x * b - y * a + w * c
    return a + 2 * (y * u - z * t), b + 2 * (z * s - x * u), c + 2 * (x * t - y * s)


def multiply(first: Quaternion, second: Quaternion) -> Quaternion:
    """The rotation that turns by `second`, then by `first`."""
    x, y, z, w = first
    a, b, c, d = second
    return (
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    )


def compose(outer: Pose, inner: Pose) -> Pose:
    """The pose in the outer frame of what has the pose `inner` in the frame at `outer`."""
    position, rotation = outer
    x, y, z = rotate(rotation, inner[0])
    return (position[0] + x, position[1] + y, position[2] + z), multiply(rotation, inner[1])


def from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Rotation about the fixed x, then y, then z axis, as in URDF; rad."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def from_orientation(orientation: Orientation) -> Quaternion:
    """Unit quaternion of an orientation in a file; one of length zero means no rotation."""
    if orientation.quaternion_xyzw is None:
        roll, pitch, yaw = orientation.rpy_deg or ORIGIN
        return from_rpy(math.radians(roll), math.radians(pitch), math.radians(yaw))
    x, y, z, w = orientation.quaternion_xyzw
    length = math.hypot(x, y, z, w)
    return (x / length, y / length, z / length, w / length) if length else IDENTITY


def carrier(prim: Prim) -> tuple[str | None, Pose]:
    """Name of the physics body that moves a prim, None for the world, and the prim's pose in that body's frame."""
    pose = NOWHERE
    for ancestor in prim.ancestors():
        if ancestor.body is not None:
            return ancestor.body, pose
        pose = compose((ancestor.position, ancestor.orientation), pose)
    return None, pose
