"""Poses of mobile bases in the plane, for nodes that plan, follow or check a path."""

from __future__ import annotations

import math

from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.node import BadValueError, ExecIn, ExecOut, In, Node, Quaterniond, Vector3d

Heading = tuple[float, float, float]
"""x (m), y (m) and yaw (rad) of a pose in the plane."""


def yaw_of(q: Quaternion) -> float:
    """Return the yaw (rad) of a quaternion: the angle from the x axis to the rotated x axis in the xy plane; 0 for q = 0.

    For q = (x, y, z, w) of any norm, the rotated axis lies along (w^2 + x^2 - y^2 - z^2, 2 (x y + z w)).
    """
    x, y, z, w = q
    return math.atan2(2.0 * (x * y + z * w), w * w + x * x - y * y - z * z)


def heading_of(position: tuple[str, Vector3], orientation: tuple[str, Quaternion]) -> Heading:
    """Return x, y and yaw of a pose.

    Args:
        position: name of the port that holds the position, and its value.
        orientation: name of the port that holds the orientation, and its value.

    Raises:
        BadValueError: x, y or the yaw is not finite.
    """
    x, y, _ = position[1]
    yaw = yaw_of(orientation[1])
    for (port, value), numbers in ((position, (x, y)), (orientation, (yaw,))):
        if not all(map(math.isfinite, numbers)):
            raise BadValueError(port, value, "finite")
    return x, y, yaw


def wrapped(angle: float) -> float:
    """Return the equivalent angle in [-pi, pi]."""
    return math.remainder(angle, math.tau)


class PlanarNode(Node):
    """Superclass of nodes that need the pose of a mobile base."""

    exec_in = ExecIn()
    current_position: Vector3d = In(
        required=True, unit="m", doc="position of the base in the world frame; z is ignored"
    )
    current_orientation: Quaterniond = In(
        required=True, doc="orientation (x, y, z, w) of the base in the world frame; only its yaw is used"
    )
    exec_out = ExecOut()

    def heading(self) -> Heading:
        """Return x, y and yaw of the base.

        Raises:
            BadValueError: x, y or the yaw is not finite.
        """
        return heading_of(("currentPosition", self.current_position), ("currentOrientation", self.current_orientation))
