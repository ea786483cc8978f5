"""The grid of cells of a floor plan, and a canvas on which bodies are drawn row by row.

A cell is occupied if a body intersects its prism: the cell extended over the height range, and reduced by MARGIN on each side. So
a body that only touches a prism does not occupy the cell. A wall whose face is on the border of two cells occupies only one cell,
despite rounding errors of its coordinates.

All bodies are convex, and so is the part of a body in a row of cells. So a body occupies the cells between its smallest and
largest x in each row, and a shape needs to compute only these two numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graphengine.descriptions.engine import Bools, Floats, Indices

Window = tuple[float, float]
"""Lowest and highest z of the height range in which a body counts as an obstacle, m."""

MARGIN = 1e-9
"""Length by which cells and the height range are reduced on each side, m; much greater than rounding errors."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Square cells, in rows from south to north and columns from west to east.

    Attributes:
        cell: side of a cell, m.
        west: x of the outer border of the first column, m.
        south: y of the outer border of the first row, m.
        columns: number of columns.
        rows: number of rows.
    """

    cell: float
    west: float
    south: float
    columns: int
    rows: int

    @staticmethod
    def around(low: tuple[float, float], high: tuple[float, float], cell: float, origin: tuple[float, float]) -> Grid:
        """Return the smallest grid that covers a rectangle; its lines, extended, pass through the point `origin`."""
        first = [math.floor((a - o + MARGIN) / cell) for a, o in zip(low, origin, strict=True)]
        last = [math.ceil((b - o - MARGIN) / cell) for b, o in zip(high, origin, strict=True)]
        west, south = (o + i * cell for o, i in zip(origin, first, strict=True))
        columns, rows = (max(j - i, 1) for i, j in zip(first, last, strict=True))
        return Grid(cell, west, south, columns, rows)

    @property
    def east(self) -> float:
        """X of the outer border of the last column, m."""
        return self.west + self.columns * self.cell

    @property
    def north(self) -> float:
        """Y of the outer border of the last row, m."""
        return self.south + self.rows * self.cell

    def locate(self, x: float, y: float) -> tuple[int, int] | None:
        """Return row and column of the cell that contains a point; None if the point is outside the grid."""
        row, column = math.floor((y - self.south) / self.cell), math.floor((x - self.west) / self.cell)
        return (row, column) if 0 <= row < self.rows and 0 <= column < self.columns else None

    def centre(self, row: int, column: int) -> tuple[float, float]:
        """Return x and y of a cell's centre, m."""
        return self.west + (column + 0.5) * self.cell, self.south + (row + 0.5) * self.cell

    def bands(self, rows: Indices, margin: float = MARGIN) -> tuple[Floats, Floats]:
        """Return the smallest and largest y of each given row, reduced by the margin, m."""
        edges: Floats = self.south + np.stack([rows, rows + 1]) * self.cell
        return edges[0] + margin, edges[1] - margin

    def rows_of(self, low: Floats, high: Floats, margin: float = MARGIN) -> tuple[Indices, Indices]:
        """Return the first and last row that each range of y intersects; first > last if a range intersects no row."""
        return _met(low - self.south + margin, high - self.south - margin, self.cell, self.rows)

    def columns_of(self, low: Floats, high: Floats, margin: float = MARGIN) -> tuple[Indices, Indices]:
        """Return the first and last column that each range of x intersects; first > last if a range intersects no column."""
        return _met(low - self.west + margin, high - self.west - margin, self.cell, self.columns)


def _met(low: Floats, high: Floats, cell: float, count: int) -> tuple[Indices, Indices]:
    first, last = np.ceil(low / cell) - 1, np.floor(high / cell)
    return np.clip(first, 0, count).astype(np.intp), np.clip(last, -1, count - 1).astype(np.intp)


def expand(first: Indices, last: Indices) -> tuple[Indices, Indices]:
    """Return all integers of the ranges `first..last`, and for each the index of its range."""
    counts = np.maximum(last - first + 1, 0)
    owner = np.repeat(np.arange(len(counts)), counts)
    within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return first[owner] + within, owner


class Canvas:
    """The occupied cells of a grid, collected from ranges of x in rows."""

    def __init__(self, grid: Grid) -> None:
        self.grid = grid
        self._steps = np.zeros((grid.rows, grid.columns + 1), np.int32)

    def fill(self, rows: Indices, low: Floats, high: Floats, margin: float = MARGIN) -> None:
        """Occupy the cells that a range of x intersects in each given row; the limits of a range may be infinite."""
        first, last = self.grid.columns_of(low, high, margin)
        met = first <= last
        np.add.at(self._steps, (rows[met], first[met]), 1)
        np.add.at(self._steps, (rows[met], last[met] + 1), -1)

    def occupied(self) -> Bools:
        """Return whether each cell is occupied, shape (rows, columns), southernmost row first."""
        return np.cumsum(self._steps, axis=1, dtype=np.int32)[:, :-1] > 0
