"""Poses that files and the stage give; arithmetic on them is in `graphengine.rotation`."""

from __future__ import annotations

import math

from graphengine.context import Quaternion
from graphengine.rotation import Pose, from_rpy
from graphengine.spec import Orientation
from graphengine.stage import IDENTITY, ORIGIN

NOWHERE: Pose = (ORIGIN, IDENTITY)
"""The pose that changes nothing."""


def from_orientation(orientation: Orientation) -> Quaternion:
    """Unit quaternion of an orientation in a file."""
    if orientation.quaternion_xyzw is None:
        roll, pitch, yaw = orientation.rpy_deg or ORIGIN
        return from_rpy(math.radians(roll), math.radians(pitch), math.radians(yaw))
    x, y, z, w = orientation.quaternion_xyzw
    length = math.hypot(x, y, z, w)
    return x / length, y / length, z / length, w / length
