"""Bodies with flat faces, given as triangles, and the cells that they occupy.

Two kinds of segments bound the part of a convex polyhedron that lies between two heights: its edges, clipped to these heights,
and the segments in which the two horizontal planes cut its faces. In each row of cells, the smallest and largest x of that part
are on the projections of these segments. So no hulls or polygons are needed: each segment is clipped to each row, and the ends
are compared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from graphengine.descriptions.engine import Floats, Indices
from graphengine.physics.occupancy.grid import MARGIN, Canvas, Grid, Window, expand

_BLOCK = 1 << 20
"""Number of pairs of a segment and a row that are processed at a time; it limits the memory used."""


@dataclass(frozen=True, slots=True)
class Triangles:
    """Convex bodies, each given by the triangles of its surface or by a single triangle.

    Attributes:
        corners: corners of the triangles in the world frame, shape (n, 3, 3), m.
        owner: index of the body of each triangle, shape (n,).
        margin: length by which cells are reduced, m; larger than MARGIN for less exact corners.
    """

    corners: Floats
    owner: Indices
    margin: float = MARGIN

    @staticmethod
    def skin(corners: Floats, margin: float = MARGIN) -> Triangles:
        """Return each triangle of a surface mesh as a polyhedron without volume.

        The triangles are moved inwards by twice the margin. So a triangle on the border of two cells occupies the cell on the
        side of the solid; without the displacement, it would occupy neither cell.
        """
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        inwards = -2 * margin * normals / np.where(lengths > 0, lengths, 1.0)
        return Triangles(corners + inwards[:, None], np.arange(len(corners)), margin)

    def bounds(self) -> tuple[Floats, Floats]:
        """Return smallest x and y, and largest x and y, m."""
        plan = self.corners[..., :2].reshape(-1, 2)
        return plan.min(axis=0), plan.max(axis=0)

    def draw(self, canvas: Canvas, window: Window) -> None:
        """Occupy the cells that the bodies intersect within the height range."""
        grid, margin = canvas.grid, self.margin
        segments, owner = self._outline(window[0] + margin, window[1] - margin)
        bodies, owner = np.unique(owner, return_inverse=True)
        south, north = np.full(len(bodies), np.inf), np.full(len(bodies), -np.inf)
        np.minimum.at(south, owner, segments[..., 1].min(axis=1))
        np.maximum.at(north, owner, segments[..., 1].max(axis=1))
        first, last = grid.rows_of(south, north, margin)
        rows, _ = expand(first, last)
        counts = np.maximum(last - first + 1, 0)
        start = np.cumsum(counts) - counts  # of each body's rows among all
        low, high = np.full(len(rows), np.inf), np.full(len(rows), -np.inf)
        for part in _blocks(counts[owner]):
            body = owner[part]
            row, ends, number = _cut(segments[part], first[body], last[body], grid, margin)
            place = start[body[number]] + row - first[body[number]]
            np.minimum.at(low, place, ends.min(axis=1))
            np.maximum.at(high, place, ends.max(axis=1))
        canvas.fill(rows, low, high, margin)

    def _outline(self, low: float, high: float) -> tuple[Floats, Indices]:
        """Return the segments that bound the parts of the bodies between two heights, and the body of each segment.

        The segments are projected to the floor plan, shape (m, 2, 2).
        """
        heights = self.corners[..., 2]
        near = (heights.min(axis=1) <= high) & (heights.max(axis=1) >= low)
        corners, owner = self.corners[near], self.owner[near]
        edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)  # (n, 3, 2, 3)
        flat = edges.reshape(-1, 2, 3)
        enter, leave = _within(flat[:, 0, 2], flat[:, 1, 2], low, high)
        inside = enter <= leave
        parts = [_between(flat[inside], enter[inside], leave[inside])]
        owners = [np.repeat(owner, 3)[inside]]
        for level in (low, high):
            above = edges[..., 2] > level
            crossing = above[..., 0] != above[..., 1]  # two edges of a triangle, or none
            crossed = edges[crossing]
            at = (level - crossed[:, 0, 2]) / (crossed[:, 1, 2] - crossed[:, 0, 2])
            parts.append(_between(crossed, at, at)[:, 0].reshape(-1, 2, 3))
            owners.append(owner[crossing.any(axis=1)])
        return np.concatenate(parts)[..., :2], np.concatenate(owners)


def _cut(segments: Floats, first: Indices, last: Indices, grid: Grid, margin: float) -> tuple[Indices, Floats, Indices]:
    """Clip each segment to the rows from `first` to `last`; return row, x of both ends and segment index of each part."""
    ys = segments[..., 1]
    lowest, highest = grid.rows_of(ys.min(axis=1), ys.max(axis=1), -margin)  # one too many does no harm
    rows, number = expand(np.maximum(first, lowest), np.minimum(last, highest))
    low, high = grid.bands(rows, margin)
    chosen = segments[number]
    enter, leave = _within(chosen[:, 0, 1], chosen[:, 1, 1], low, high)
    met = enter <= leave
    return rows[met], _between(chosen[met], enter[met], leave[met])[..., 0], number[met]


def _within(start: Floats, end: Floats, low: Floats | float, high: Floats | float) -> tuple[Floats, Floats]:
    """Return at which fractions of their length, 0 to 1, segments enter and leave a range of values.

    For a segment that does not intersect the range, the first fraction is greater than the second.

    Args:
        start: value at the start of each segment.
        end: value at its end.
        low: lower limit of the range.
        high: upper limit of the range.
    """
    run = end - start
    run = np.where(run == 0, 1e-300, run)
    with np.errstate(over="ignore"):
        one, other = (low - start) / run, (high - start) / run
    return np.maximum(np.minimum(one, other), 0.0), np.minimum(np.maximum(one, other), 1.0)


def _between(segments: Floats, start: Floats, end: Floats) -> Floats:
    """Return the part of each segment between two fractions of its length."""
    fractions = np.stack([start, end], axis=1)[..., None]
    return segments[:, :1] * (1 - fractions) + segments[:, 1:] * fractions


def _blocks(counts: Indices) -> Iterator[slice]:
    """Yield consecutive slices of an array; the counts in each slice add up to about _BLOCK."""
    total = np.cumsum(counts)
    whole = int(total[-1]) if len(total) else 0
    edges = [0, *np.searchsorted(total, np.arange(_BLOCK, whole, _BLOCK)).tolist(), len(counts)]
    yield from (slice(a, b) for a, b in pairwise(edges) if a < b)
