"""Where a base is on the floor, as the nodes need it that drive it along a path."""

from __future__ import annotations

import math

from graphengine.devices.sensor import Quaternion, Vector3
from graphengine.node import BadValueError, ExecIn, ExecOut, In, Node, Quaterniond, Vector3d

Heading = tuple[float, float, float]
"""x and y (m) and the yaw (rad) of something on the floor."""


def yaw_of(q: Quaternion) -> float:
    """Angle (rad) from the world's x axis to the direction that q turns x to, seen from above; 0 for the quaternion 0.

    Of q = (x, y, z, w) of any length, the turned axis lies along (w^2 + x^2 - y^2 - z^2, 2 (x y + z w)).
    """
    x, y, z, w = q
    return math.atan2(2.0 * (x * y + z * w), w * w + x * x - y * y - z * z)


def heading_of(position: tuple[str, Vector3], orientation: tuple[str, Quaternion]) -> Heading:
    """Where a pose is on the floor, given as two ports and their values.

    Raises:
        BadValueError: it is not finite.
    """
    x, y, _ = position[1]
    yaw = yaw_of(orientation[1])
    for (port, value), numbers in ((position, (x, y)), (orientation, (yaw,))):
        if not all(map(math.isfinite, numbers)):
            raise BadValueError(port, value, "finite")
    return x, y, yaw


def wrapped(angle: float) -> float:
    """The same direction within half a turn: an angle in [-pi, pi]."""
    return math.remainder(angle, math.tau)


class PlanarNode(Node):
    """A node that has to know where the base is."""

    exec_in = ExecIn()
    current_position: Vector3d = In(required=True, unit="m", doc="of the base in the world; z does not count")
    current_orientation: Quaterniond = In(required=True, doc="of the base in the world, (x, y, z, w); its yaw counts")
    exec_out = ExecOut()

    def heading(self) -> Heading:
        """Where the base is, and which way it looks.

        Raises:
            BadValueError: it is not finite.
        """
        return heading_of(("currentPosition", self.current_position), ("currentOrientation", self.current_orientation))
