"""Casts the scans of a planar lidar in an occupancy map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graphengine.bringup.maps.likelihood_field import LikelihoodField
from graphengine.descriptions.engine import Floats, Indices

_AT_ONCE = 64
"""Number of steps that all rays take before those that have hit an obstacle are finished."""


@dataclass(frozen=True, slots=True)
class PlanarLidar:
    """A lidar whose beams are parallel to the floor.

    Attributes:
        first: direction of the first beam, rad counter-clockwise from the front of the robot.
        field: angle from the first to the last beam, rad; 2 pi for a lidar that scans a full circle.
        near: smallest distance that the lidar reports, m.
        far: largest distance that the lidar reports, m.
    """

    first: float
    field: float
    near: float
    far: float

    def rays(self, beams: int, headings: int) -> int:
        """Return the number of rays of a full circle with about `beams` rays in the field of view: a multiple of `headings`."""
        return headings * max(1, round(beams * math.tau / self.field / headings))

    def window(self, rays: int, headings: int) -> Floats:
        """Return 1 for each ray of a full circle in the field of view at a heading, else 0, shape (rays, headings)."""
        count = min(rays, math.floor(self.field / math.tau * rays + 1e-6) + 1)
        first = round(self.first / math.tau * rays)
        seen = np.zeros((rays, headings))
        for heading in range(headings):
            seen[(first + heading * rays // headings + np.arange(count)) % rays, heading] = 1.0
        return seen


def cast(field: LikelihoodField, rows: Indices, columns: Indices, rays: int, lidar: PlanarLidar) -> Floats:
    """Return the distances at which the rays of a full circle hit obstacles, m; NaN for no return.

    Each ray is sampled in steps of half a cell. Ray k has the angle 2 pi k / rays from the x axis.

    Args:
        field: likelihood field of the map.
        rows: row of each cell from whose centre rays are cast.
        columns: column of each of these cells.
        rays: number of rays per cell.
        lidar: lidar that reports distances from its smallest to its largest distance.

    Returns:
        Distances, shape (cells, rays).
    """
    high, wide = field.occupied.shape
    reach = min(lidar.far, math.hypot(high, wide) * field.cell)
    angle = np.tile(np.arange(rays) * (math.tau / rays), len(rows))
    south, west = (np.repeat(cells + field.pad, rays) for cells in (rows, columns))
    ranges, pending = np.full(len(angle), np.nan), np.arange(len(angle))
    occupied = field.occupied.ravel()
    steps = np.arange(1, _AT_ONCE + 1) / 2
    begin = 0.0
    while len(pending) and begin * field.cell < reach:
        along = begin + steps
        sine, cosine = np.sin(angle[pending])[:, None], np.cos(angle[pending])[:, None]
        row = np.rint(south[pending, None] + along * sine).astype(np.intp)
        column = np.rint(west[pending, None] + along * cosine).astype(np.intp)
        outside = (row < 0) | (row >= high) | (column < 0) | (column >= wide)
        row[outside] = column[outside] = 0  # a cell of the padding
        met = occupied[row * wide + column]
        hit = met.any(axis=1)
        ranges[pending[hit]] = along[np.argmax(met[hit], axis=1)] * field.cell
        pending = pending[~hit & ~outside[:, -1]]
        begin = float(along[-1])
    ranges[(ranges < lidar.near) | (ranges > lidar.far)] = np.nan
    return ranges.reshape(len(rows), rays)
