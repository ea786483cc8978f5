"""Computes the world poses of many frames that are fixed to bodies; quaternions are (w, x, y, z), as in viser."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from viser.transforms import SO3

from graphengine.devices.rotation import Pose

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Carried:
    """Frames that are fixed to bodies.

    Attributes:
        rows: row of each frame's body in the array of poses, shape (n,).
        positions: positions relative to the bodies, m, shape (n, 3).
        rotations: quaternions relative to the bodies, shape (n, 4).
    """

    rows: NDArray[np.intp]
    positions: Floats
    rotations: Floats

    @classmethod
    def of(cls, frames: Sequence[tuple[int, Pose]]) -> Carried:
        """Create frames from pairs of a body's row and a pose relative to this body; these quaternions are (x, y, z, w)."""
        positions = np.array([pose[0] for _, pose in frames], np.float32).reshape(-1, 3)
        rotations = np.array([pose[1] for _, pose in frames], np.float32).reshape(-1, 4)[:, [3, 0, 1, 2]]
        return cls(np.array([row for row, _ in frames], np.intp), positions, rotations)

    def at(self, poses: NDArray[np.float64]) -> tuple[Floats, Floats]:
        """Return positions, m, and quaternions of the frames in the world frame.

        Args:
            poses: position and quaternion (x, y, z, w) of each body, shape (bodies, 7).
        """
        bodies = poses[self.rows].astype(np.float32)
        turns = bodies[:, [6, 3, 4, 5]]
        return bodies[:, :3] + turned(turns, self.positions), (SO3(turns) @ SO3(self.rotations)).wxyz


def turned(q: Floats, v: Floats) -> Floats:
    """Return the rows of `v`, shape (n, 3), rotated by the quaternions in the rows of `q`, shape (n, 4)."""
    t = 2.0 * np.cross(q[:, 1:], v)
    found: Floats = v + q[:, :1] * t + np.cross(q[:, 1:], t)
    return found
