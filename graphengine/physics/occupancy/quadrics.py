"""Ellipsoids (including spheres) and cylinders, rasterized in closed form.

The largest x of a convex body, cut by planes of constant y and z, is at one of few points: the extreme points of ellipses, and
of their sections by the planes. All candidates are computed, those outside the cut body are dropped, and the largest remains.
Rounding errors can only drop candidates, so a point that counts is always inside the body.

An ellipsoid is given by its centre c and the matrix Q = A A^T, where A maps the unit ball onto it. Its extreme points along x
are c +- Q e / sqrt(e^T Q e). The matrix of its section by a plane of constant coordinate is the Schur complement of that
coordinate, scaled; the same formulae hold for a disc, an ellipsoid with a Q of rank two.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from graphengine.physics.engine import Bools, Floats, Indices
from graphengine.physics.occupancy.grid import MARGIN, Canvas, Window, expand

Ellipses = tuple[Floats, Floats]
"""Centres (n, 3) and matrices (n, 3, 3) of ellipsoids, flat ones among them."""

_X, _Y, _Z = range(3)


class _Quadrics(ABC):
    """Convex bodies cut by planes of constant y and z."""

    centres: Floats
    """(n, 3), m."""

    @abstractmethod
    def reach(self) -> Floats:
        """Return extents of the bodies from their centres along x, y and z, shape (n, 3), m."""

    @abstractmethod
    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """Return points, shape (n, 3), which include those of smallest and largest x of each cut body."""

    @abstractmethod
    def holds(self, which: Indices, points: Floats) -> Bools:
        """Return whether bodies contain points, within the margin."""

    def bounds(self) -> tuple[Floats, Floats]:
        """Return smallest and largest x and y."""
        plan, reach = self.centres[:, :2], self.reach()[:, :2]
        return (plan - reach).min(axis=0), (plan + reach).max(axis=0)

    def draw(self, canvas: Canvas, window: Window) -> None:
        """Occupy the cells in which the bodies are."""
        low, high = window[0] + MARGIN, window[1] - MARGIN
        centres, reach = self.centres, self.reach()
        near = np.flatnonzero((centres[:, _Z] - reach[:, _Z] <= high) & (centres[:, _Z] + reach[:, _Z] >= low))
        y, half = centres[near, _Y], reach[near, _Y]
        rows, owner = expand(*canvas.grid.rows_of(y - half, y + half))
        south, north = canvas.grid.bands(rows)
        bottom, top = np.full(len(rows), low), np.full(len(rows), high)
        which = near[owner]
        least, greatest = np.full(len(rows), np.inf), np.full(len(rows), -np.inf)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for points in self.places(which, (south, north), (bottom, top)):
                there = _among(points[:, _Y], south, north) & _among(points[:, _Z], bottom, top)
                there &= self.holds(which, points)
                np.minimum(least, points[:, _X], out=least, where=there)
                np.maximum(greatest, points[:, _X], out=greatest, where=there)
        canvas.fill(rows, least, greatest)


@dataclass(frozen=True, slots=True)
class Ellipsoids(_Quadrics):
    """Ellipsoids; `axes` has the half axes as columns, shape (n, 3, 3), m."""

    centres: Floats
    axes: Floats

    def reach(self) -> Floats:
        """Return the extents: the norms of the rows of the axes."""
        extent: Floats = np.linalg.norm(self.axes, axis=2)
        return extent

    def holds(self, which: Indices, points: Floats) -> Bools:
        """Return whether ellipsoids contain points; in the frame of the half axes, an ellipsoid is the unit ball."""
        radii = np.linalg.norm(self.axes, axis=1)
        unit = np.einsum("nij,ni->nj", (self.axes / radii[:, None] ** 2)[which], points - self.centres[which])
        within: Bools = np.linalg.norm(unit, axis=1) <= 1 + MARGIN / radii.min(axis=1)[which]
        return within

    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """Return the extreme points of the ellipsoids, and of their sections."""
        matrices = self.axes @ self.axes.transpose(0, 2, 1)
        whole = self.centres[which], matrices[which]
        for ellipse in _sections(whole, ys, zs):
            yield from _farthest(ellipse)


@dataclass(frozen=True, slots=True)
class Cylinders(_Quadrics):
    """Cylinders between two discs.

    Attributes:
        centres: shape (n, 3), m.
        axes: unit vectors, shape (n, 3).
        radii: shape (n,), m.
        halves: half lengths, shape (n,), m.
    """

    centres: Floats
    axes: Floats
    radii: Floats
    halves: Floats

    def reach(self) -> Floats:
        """Return extents of the axis and of the discs at its ends."""
        slant = np.sqrt(np.maximum(1 - self.axes**2, 0.0))
        return self.halves[:, None] * np.abs(self.axes) + self.radii[:, None] * slant

    def holds(self, which: Indices, points: Floats) -> Bools:
        """Return whether points are between the discs and near enough to the axis."""
        offsets, axes = points - self.centres[which], self.axes[which]
        along = np.einsum("ni,ni->n", offsets, axes)
        away = np.linalg.norm(offsets - along[:, None] * axes, axis=1)
        within: Bools = (np.abs(along) <= self.halves[which] + MARGIN) & (away <= self.radii[which] + MARGIN)
        return within

    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """Return points of both discs, and of the ellipses in which the planes cut the side.

        Such an ellipse is a disc that was moved along the axis into the plane.
        """
        centres, axes = self.centres[which], self.axes[which]
        squares = self.radii[which, None, None] ** 2
        discs = squares * (np.eye(3) - axes[:, :, None] * axes[:, None, :])
        for end in (-1, 1):
            for ellipse in _sections((centres + end * self.halves[which, None] * axes, discs), ys, zs):
                yield from _farthest(ellipse)
        for axis, values in [(_Y, y) for y in ys] + [(_Z, z) for z in zs]:
            along = axes / axes[:, axis, None]
            into = np.eye(3) - along[:, :, None] * np.eye(3)[axis]
            cut = centres + along * (values - centres[:, axis])[:, None], into @ discs @ into.transpose(0, 2, 1)
            others = ((), zs) if axis == _Y else (ys, ())
            for ellipse in _sections(cut, *others):
                yield from _farthest(ellipse)


def _among(values: Floats, low: Floats, high: Floats) -> Bools:
    return (values >= low - MARGIN) & (values <= high + MARGIN)


def _sections(ellipse: Ellipses, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Ellipses]:
    """Return an ellipsoid, and its sections by planes of y, of z, and of both."""
    for cut in (ellipse, *(_section(ellipse, _Y, y) for y in ys)):
        yield cut
        yield from (_section(cut, _Z, z) for z in zs)


def _section(ellipse: Ellipses, axis: int, values: Floats) -> Ellipses:
    """Return sections of ellipsoids at given values of a coordinate; undefined if a plane misses the ellipsoid."""
    centres, matrices = ellipse
    column = matrices[:, :, axis]
    offset = values - centres[:, axis]
    ratio = (offset / column[:, axis])[:, None]
    rest = matrices - column[:, :, None] * column[:, None, :] / column[:, axis, None, None]
    return centres + column * ratio, rest * (1 - offset[:, None, None] * ratio[:, None])


def _farthest(ellipse: Ellipses) -> Iterator[Floats]:
    """Yield the points of smallest and largest x, and the centre, because rounding may rule out both for a thin ellipse."""
    centres, matrices = ellipse
    step = matrices[:, :, _X] / np.sqrt(matrices[:, _X, _X, None])
    yield from (centres - step, centres, centres + step)
