"""Vectors, rotations and poses of plain floats, which are faster than numpy for single ones.

Rotations are unit quaternions (x, y, z, w).
"""

from __future__ import annotations

import math

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Pose = tuple[Vector3, Quaternion]

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)
NOWHERE: Pose = (ORIGIN, IDENTITY)
"""The identity pose."""


def conjugate(q: Quaternion) -> Quaternion:
    """The inverse of a unit quaternion."""
    return -q[0], -q[1], -q[2], q[3]


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Rotation b followed by rotation a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotate(q: Quaternion, v: Vector3) -> Vector3:
    """The vector v rotated by q: v + 2w(u x v) + 2u x (u x v), with u the vector part of q."""
    x, y, z, w = q
    vx, vy, vz = v
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx


def unrotate(q: Quaternion, v: Vector3) -> Vector3:
    """The vector v rotated by the inverse of q: from world to body frame if q is the body's orientation."""
    return rotate((-q[0], -q[1], -q[2], q[3]), v)


def compose(parent: Pose, child: Pose) -> Pose:
    """Pose in the parent's outer frame, for a `child` pose relative to `parent`."""
    (px, py, pz), q = parent
    x, y, z = rotate(q, child[0])
    return (px + x, py + y, pz + z), multiply(q, child[1])


def relative(parent: Pose, child: Pose) -> Pose:
    """Pose of `child` in the frame of `parent`; both are given in the same outer frame."""
    (px, py, pz), q = parent
    (cx, cy, cz), c = child
    return unrotate(q, (cx - px, cy - py, cz - pz)), multiply(conjugate(q), c)


def from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Rotation about the fixed x, then y, then z axis, rad, as in URDF."""
    sr, cr = math.sin(roll / 2), math.cos(roll / 2)
    sp, cp = math.sin(pitch / 2), math.cos(pitch / 2)
    sy, cy = math.sin(yaw / 2), math.cos(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
