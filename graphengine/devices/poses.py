"""Conversion of poses from files and from MuJoCo; `graphengine.devices.rotation` has arithmetic on poses."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.rotation import ORIGIN, Pose, Quaternion, Vector3, from_rpy
from graphengine.format.spec import Orientation


def from_orientation(orientation: Orientation) -> Quaternion:
    """Unit quaternion for an orientation in a file."""
    if orientation.quaternion_xyzw is None:
        roll, pitch, yaw = orientation.rpy_deg or ORIGIN
        return from_rpy(math.radians(roll), math.radians(pitch), math.radians(yaw))
    x, y, z, w = orientation.quaternion_xyzw
    length = math.hypot(x, y, z, w)
    return x / length, y / length, z / length, w / length


def vector(values: NDArray[np.float64]) -> Vector3:
    """A MuJoCo vector as three floats."""
    x, y, z = values.tolist()
    return x, y, z


def pose_of(position: NDArray[np.float64], quaternion: NDArray[np.float64]) -> Pose:
    """A pose from MuJoCo, whose quaternions are (w, x, y, z)."""
    w, x, y, z = quaternion.tolist()
    return vector(position), (x, y, z, w)
