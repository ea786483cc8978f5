"""Contact points between the bodies of a world."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Contacts:
    """The points at which bodies touch, one row each; vectors are in the world frame.

    Attributes:
        points: position, shape (n, 3), m.
        normals: unit vector from the first body to the second, shape (n, 3).
        forces: force of the first body on the second, shape (n, 3), N.
        bodies: first and second body, as rows of `World.poses` and of `Bodies.names`, shape (n, 2).
    """

    points: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    normals: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    forces: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    bodies: NDArray[np.intp] = field(default_factory=lambda: np.zeros((0, 2), np.intp))
