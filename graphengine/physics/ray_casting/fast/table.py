"""The geoms of a model as a table of records, which kernels read: shapes, poses and bounding boxes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Floats, Indices
from graphengine.physics.kernels.compiled import kernel

Records = NDArray[Any]

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = range(8)  # mjtGeom

GEOM = np.dtype(
    [
        ("kind", "i8"),  # one of the above
        ("mesh", "i8"),  # root of the tree of its triangles
        ("position", "f8", 3),
        ("rotation", "f8", 9),  # row after row
        ("size", "f8", 3),  # as MuJoCo means it for the kind
        ("centre", "f8", 3),  # of its box, in its own frame
        ("half", "f8", 3),  # sides of that box, halved
    ],
    align=True,
)

MARGIN = 1e-6
"""Margin of bounding boxes, m; it exceeds rounding errors. So no ray misses a box that it should hit."""


@kernel
def follow(table: Records, numbers: Indices, positions: Floats, rotations: Floats) -> bool:
    """Copy the current poses of some geoms to the table; return whether one of these poses has changed.

    Args:
        table: table of geoms.
        numbers: ids of the geoms.
        positions: positions of all geoms of the model, shape (geoms, 3).
        rotations: rotations of all geoms, shape (geoms, 9).
    """
    changed = False
    for number in numbers:
        geom = table[number]
        for axis in range(3):
            changed = changed or geom.position[axis] != positions[number, axis]
            geom.position[axis] = positions[number, axis]
        for entry in range(9):
            changed = changed or geom.rotation[entry] != rotations[number, entry]
            geom.rotation[entry] = rotations[number, entry]
    return changed


@kernel
def enclose(table: Records, numbers: Indices, low: Floats, high: Floats) -> None:
    """Write the corners of the bounding boxes of n geoms, along the world's axes, to `low` and `high`, of shape (n, 3)."""
    for row, number in enumerate(numbers):
        geom = table[number]
        for axis in range(3):
            centre, half = geom.position[axis], MARGIN
            for own in range(3):
                centre += geom.rotation[3 * axis + own] * geom.centre[own]
                half += abs(geom.rotation[3 * axis + own]) * geom.half[own]
            low[row, axis], high[row, axis] = centre - half, centre + half
