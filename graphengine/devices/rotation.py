"""Vectors, rotations and poses as tuples of floats, which are faster than numpy for single values.

Rotations are unit quaternions (x, y, z, w). `from_orientation`, `vector` and `pose_of` convert values from files and from MuJoCo.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from graphengine.format.spec import Orientation

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Pose = tuple[Vector3, Quaternion]

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)
NOWHERE: Pose = (ORIGIN, IDENTITY)
"""The identity pose."""
_STEEP = 0.999
"""Sine of the pitch above which `asin` loses digits."""
_STRAIGHT = 1e-14
"""Cosine of the pitch below which the pitch counts as 90 degrees."""


def conjugate(q: Quaternion) -> Quaternion:
    """Return the inverse of a unit quaternion."""
    return -q[0], -q[1], -q[2], q[3]


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the product of two unit quaternions: the rotation that applies b first and then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def rotate(q: Quaternion, v: Vector3) -> Vector3:
    """Return the vector v, rotated by the unit quaternion q."""
    x, y, z, w = q
    vx, vy, vz = v
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx


def unrotate(q: Quaternion, v: Vector3) -> Vector3:
    """Return the vector v, rotated by the inverse of q. If q is a body's orientation, the result is v in the body's frame."""
    return rotate((-q[0], -q[1], -q[2], q[3]), v)


def compose(parent: Pose, child: Pose) -> Pose:
    """Return the pose of a child in the frame of its parent's pose.

    Args:
        parent: pose of the parent.
        child: pose of the child relative to the parent.
    """
    (px, py, pz), q = parent
    x, y, z = rotate(q, child[0])
    return (px + x, py + y, pz + z), multiply(q, child[1])


def relative(parent: Pose, child: Pose) -> Pose:
    """Return the pose of `child` relative to `parent`; both are given in the same frame."""
    (px, py, pz), q = parent
    (cx, cy, cz), c = child
    return unrotate(q, (cx - px, cy - py, cz - pz)), multiply(conjugate(q), c)


def from_rpy(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation for roll, pitch and yaw (rad) as in URDF: about the fixed x axis, then the y axis, then the z axis."""
    sr, cr = math.sin(roll / 2), math.cos(roll / 2)
    sp, cp = math.sin(pitch / 2), math.cos(pitch / 2)
    sy, cy = math.sin(yaw / 2), math.cos(yaw / 2)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def to_rpy(q: Quaternion) -> Vector3:
    """Return the roll, pitch and yaw of a unit quaternion, rad: the arguments with which `from_rpy` returns this rotation."""
    x, y, z, w = q
    sine = 2.0 * (w * y - z * x)
    if abs(sine) < _STEEP:
        roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        return roll, math.asin(sine), math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    ahead, left, up = (rotate(q, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    if math.hypot(ahead[0], ahead[1]) < _STRAIGHT:  # roll and yaw turn about the same axis
        return 0.0, math.copysign(math.pi / 2, sine), -2.0 * math.copysign(1.0, sine) * math.atan2(x, w)
    yaw = math.atan2(ahead[1], ahead[0])  # the two axes are almost the same, so the roll is measured after this yaw
    sine, cosine = math.sin(yaw), math.cos(yaw)
    pitch = math.atan2(-ahead[2], cosine * ahead[0] + sine * ahead[1])
    return math.atan2(sine * up[0] - cosine * up[1], cosine * left[1] - sine * left[0]), pitch, yaw


def yaw_of(q: Quaternion) -> float:
    """Return the yaw of a unit quaternion, rad: its rotation about the fixed z axis after roll and pitch."""
    x, y, z, w = q
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def tilt_of(q: Quaternion) -> float:
    """Return the angle between the rotated z axis and the z axis, rad."""
    return 2.0 * math.asin(min(1.0, math.hypot(q[0], q[1])))


def from_orientation(orientation: Orientation) -> Quaternion:
    """Return the unit quaternion of an orientation that a file gives as a quaternion or as roll, pitch and yaw in degrees."""
    if orientation.quaternion_xyzw is None:
        roll, pitch, yaw = orientation.rpy_deg or ORIGIN
        return from_rpy(math.radians(roll), math.radians(pitch), math.radians(yaw))
    x, y, z, w = orientation.quaternion_xyzw
    length = math.hypot(x, y, z, w)
    return x / length, y / length, z / length, w / length


def vector(values: NDArray[np.float64]) -> Vector3:
    """Return a numpy array of three numbers from MuJoCo as a tuple of floats."""
    x, y, z = values.tolist()
    return x, y, z


def pose_of(position: NDArray[np.float64], quaternion: NDArray[np.float64]) -> Pose:
    """Return a pose from MuJoCo, whose quaternions are (w, x, y, z), as a tuple of position and quaternion (x, y, z, w)."""
    w, x, y, z = quaternion.tolist()
    return vector(position), (x, y, z, w)
