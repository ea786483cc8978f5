"""Computes the likelihood field of a map, with which nav2_amcl's `likelihood_field` model scores the beams of a scan.

If a beam ends at distance z from the nearest obstacle, AMCL gives it the score
p = z_hit exp(-z^2 / (2 sigma_hit^2)) + z_rand / range. The score of a scan is 1 + the sum of p^3 over its beams; beams without a
return do not count. Distances are measured between centres of cells, and limited to 2 m.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Bools, Floats, Indices
from graphengine.physics.occupancy.occupancy_map import OCCUPIED, OccupancyMap

Singles = NDArray[np.float32]

Z_HIT, Z_RAND, SIGMA_HIT, MAX_DISTANCE = 0.5, 0.5, 0.2, 2.0
"""Default parameters of nav2_amcl: weights of its hit and random models, standard deviation (m) and distance limit (m)."""


@dataclass(frozen=True, slots=True)
class LikelihoodField:
    """The contribution of a beam to the score of a scan, for each cell in which the beam can end.

    The map has padding, because `shift` moves the flat index of a cell in all directions.

    Attributes:
        cell: side of a cell, m.
        pad: number of cells of padding on each side of the map.
        occupied: whether a cell is an obstacle, shape (rows, columns) with padding.
        distance: distance from the centre of a cell to the centre of the nearest obstacle cell, at most MAX_DISTANCE, m.
        score: p^3 of a beam that ends in the cell, with p as in the description of this module.
    """

    cell: float
    pad: int
    occupied: Bools
    distance: Floats
    score: Singles

    def index(self, rows: Indices, columns: Indices) -> Indices:
        """Return flat indices of map cells; cells outside the map get indices in the padding, where no obstacle is near."""
        edge, (high, wide) = self.pad // 2, self.score.shape
        flat: Indices = np.clip(rows + self.pad, edge, high - 1 - edge) * wide
        flat += np.clip(columns + self.pad, edge, wide - 1 - edge)
        return flat

    def shift(self, rows: Indices, columns: Indices) -> Indices:
        """Return the difference of flat indices for a displacement by rows and columns."""
        moved: Indices = rows * self.score.shape[1] + columns
        return moved


def likelihood_field(chart: OccupancyMap, max_range: float) -> LikelihoodField:
    """Return the likelihood field of a map for a lidar with the given maximum range, m."""
    cell = chart.grid.cell
    pad = 2 * (math.ceil(MAX_DISTANCE / cell) + 1)
    occupied = np.pad(chart.cells == OCCUPIED, pad)
    distance = distances(occupied, math.ceil(MAX_DISTANCE / cell)) * cell
    np.minimum(distance, MAX_DISTANCE, out=distance)
    hit = Z_HIT * np.exp(-(distance**2) / (2 * SIGMA_HIT**2)) + Z_RAND / max_range
    return LikelihoodField(cell, pad, occupied, distance, (hit**3).astype(np.float32))


def distances(occupied: Bools, most: int) -> Floats:
    """Return the distance of each cell from the nearest occupied cell, in cells.

    Distances up to `most` are exact; for a greater distance, the result is some number above `most`. The squared distance of a
    cell is the minimum, over the columns of its row, of the squared step to the column plus the squared distance in the column.
    """
    rows, columns = occupied.shape
    number = np.arange(rows)[:, None]
    far = 4 * (most + 1)
    below = np.maximum.accumulate(np.where(occupied, number, -far), axis=0)
    above = np.minimum.accumulate(np.where(occupied, number, rows + far)[::-1], axis=0)[::-1]
    vertical = np.minimum(np.minimum(number - below, above - number), far).astype(np.float64) ** 2
    wide = np.pad(vertical, ((0, 0), (most, most)), constant_values=float(far) ** 2)
    least = vertical.copy()
    for step in range(-most, most + 1):
        np.minimum(least, wide[:, most + step : most + step + columns] + step**2, out=least)
    return np.sqrt(least)
