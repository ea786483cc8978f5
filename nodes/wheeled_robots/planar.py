"""Functions for poses in the plane, and the base class of nodes that plan, follow or check the path of a mobile base."""

from __future__ import annotations

import math

from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.node import BadValueError, ExecIn, ExecOut, In, Node, Quaterniond, Vector3d

Heading = tuple[float, float, float]
"""x (m), y (m) and yaw (rad) of a pose in the plane."""


def yaw_of(q: Quaternion) -> float:
    """Return the yaw (rad) of a quaternion (x, y, z, w), which need not have unit length; 0 if all components are 0.

    The yaw is the angle in the xy plane from the x axis to the rotated x axis. The rotated x axis has the x and y components
    w^2 + x^2 - y^2 - z^2 and 2 (x y + z w).
    """
    x, y, z, w = q
    return math.atan2(2.0 * (x * y + z * w), w * w + x * x - y * y - z * z)


def heading_of(position: tuple[str, Vector3], orientation: tuple[str, Quaternion]) -> Heading:
    """Return x (m), y (m) and yaw (rad) of a pose.

    Args:
        position: OmniGraph name and value of the port with the position.
        orientation: OmniGraph name and value of the port with the orientation.

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
    """Return the equivalent angle (rad) in [-pi, pi]."""
    return math.remainder(angle, math.tau)


class PlanarNode(Node):
    """Base of nodes that need the pose of a mobile base."""

    exec_in = ExecIn()
    current_position: Vector3d = In(required=True, unit="m", doc="position of the base in the world; z is ignored")
    current_orientation: Quaterniond = In(
        required=True, doc="orientation (x, y, z, w) of the base in the world; only its yaw is used"
    )
    exec_out = ExecOut()

    def heading(self) -> Heading:
        """Return x (m), y (m) and yaw (rad) of the mobile base, from the inputs.

        Raises:
            BadValueError: x, y or the yaw is not finite.
        """
        return heading_of(("currentPosition", self.current_position), ("currentOrientation", self.current_orientation))
