"""Bodies with flat faces, as triangle meshes.

Two kinds of segments bound the part of a convex polyhedron that lies between two heights: its edges between the heights, and the
segments in which the two planes cut its faces. In each row of cells, the smallest and largest x of the part are on the
projections of these segments. So no hulls or polygons are needed: each segment is clipped to each row, and its ends are compared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from graphengine.physics.engine import Floats, Indices
from graphengine.physics.occupancy.grid import MARGIN, Canvas, Grid, Window, expand

_BLOCK = 1 << 20
"""Pairs of a segment and a row that are worked on at a time, which bounds memory."""


@dataclass(frozen=True, slots=True)
class Triangles:
    """Convex bodies, each given by the triangles of its surface or by a single triangle.

    Attributes:
        corners: shape (n, 3, 3), m, in the world frame.
        owner: index of each triangle's body, shape (n,).
        margin: margin by which cells are reduced, m; larger than MARGIN for less exact corners.
    """

    corners: Floats
    owner: Indices
    margin: float = MARGIN

    @staticmethod
    def skin(corners: Floats, margin: float = MARGIN) -> Triangles:
        """Return triangles without volume, each a body.

        They are moved inwards by twice the margin. So a surface on the border of two cells occupies the cell on the side of its
        solid, not neither.
        """
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        inwards = -2 * margin * normals / np.where(lengths > 0, lengths, 1.0)
        return Triangles(corners + inwards[:, None], np.arange(len(corners)), margin)

    def bounds(self) -> tuple[Floats, Floats]:
        """Return smallest and largest x and y."""
        plan = self.corners[..., :2].reshape(-1, 2)
        return plan.min(axis=0), plan.max(axis=0)

    def draw(self, canvas: Canvas, window: Window) -> None:
        """Occupy the cells in which the bodies are."""
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
        """Return the segments in the plan that bound the part of the bodies in a slab, shape (m, 2, 2), and their owners."""
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
    """Clip segments to the given rows; return for each part the row, x of both ends, and the index of the segment."""
    ys = segments[..., 1]
    lowest, highest = grid.rows_of(ys.min(axis=1), ys.max(axis=1), -margin)  # one too many does no harm
    rows, number = expand(np.maximum(first, lowest), np.minimum(last, highest))
    low, high = grid.bands(rows, margin)
    chosen = segments[number]
    enter, leave = _within(chosen[:, 0, 1], chosen[:, 1, 1], low, high)
    met = enter <= leave
    return rows[met], _between(chosen[met], enter[met], leave[met])[..., 0], number[met]


def _within(start: Floats, end: Floats, low: Floats | float, high: Floats | float) -> tuple[Floats, Floats]:
    """Return where segments enter and leave a range, from 0 to 1; a segment that misses it leaves before it enters."""
    run = end - start
    run = np.where(run == 0, 1e-300, run)
    with np.errstate(over="ignore"):
        one, other = (low - start) / run, (high - start) / run
    return np.maximum(np.minimum(one, other), 0.0), np.minimum(np.maximum(one, other), 1.0)


def _between(segments: Floats, start: Floats, end: Floats) -> Floats:
    """Return parts of segments between two fractions of their length."""
    fractions = np.stack([start, end], axis=1)[..., None]
    return segments[:, :1] * (1 - fractions) + segments[:, 1:] * fractions


def _blocks(counts: Indices) -> Iterator[slice]:
    """Yield consecutive slices; the counts in each add up to about _BLOCK."""
    total = np.cumsum(counts)
    whole = int(total[-1]) if len(total) else 0
    edges = [0, *np.searchsorted(total, np.arange(_BLOCK, whole, _BLOCK)).tolist(), len(counts)]
    yield from (slice(a, b) for a, b in pairwise(edges) if a < b)
