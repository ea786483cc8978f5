"""The arrays in which a world returns the contact points between its bodies."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Contacts:
    """The n points at which bodies touch. Each array has one row per point; vectors are in the world frame.

    Attributes:
        points: positions, m, shape (n, 3).
        normals: unit vectors from the first body to the second, shape (n, 3).
        forces: forces of the first body on the second, N, shape (n, 3).
        bodies: indices of the first and second body in `World.poses` and `Bodies.names`, shape (n, 2).
    """

    points: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    normals: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    forces: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    bodies: NDArray[np.intp] = field(default_factory=lambda: np.zeros((0, 2), np.intp))
