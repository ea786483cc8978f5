"""Ellipsoids (including spheres) and cylinders, and the cells that they occupy, computed in closed form.

A row of cells and the height range cut a body by planes of constant y and z. The largest x of the cut body is at one of a few
points: the extreme points of ellipses, and of the sections of these ellipses by the planes. All candidates are computed.
Candidates outside the cut body are dropped, and the largest remaining x counts. Rounding errors can only drop candidates, so a
point that counts is always inside the body.

An ellipsoid is given by its centre c and the matrix Q = A A^T, where A maps the unit ball onto the ellipsoid. Its extreme points
along x are c +- Q e / sqrt(e^T Q e), where e is the x axis. A section of an ellipsoid by a plane of constant coordinate has the
scaled Schur complement of that coordinate as its matrix. The same formulae hold for a disc, which is an ellipsoid with a Q of
rank two.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from graphengine.descriptions.engine import Bools, Floats, Indices
from graphengine.physics.occupancy.grid import MARGIN, Canvas, Window, expand

Ellipses = tuple[Floats, Floats]
"""Centres (n, 3) and matrices Q (n, 3, 3) of ellipsoids, some of which may be flat."""

_X, _Y, _Z = range(3)


class _Quadrics(ABC):
    """Convex round bodies that can be cut by planes of constant y and z."""

    centres: Floats
    """Centres of the bodies in the world frame, shape (n, 3), m."""

    @abstractmethod
    def reach(self) -> Floats:
        """Return how far each body extends from its centre along x, y and z, shape (n, 3), m."""

    @abstractmethod
    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """Yield arrays of one candidate point per body; the points of smallest and largest x of each cut body are among them.

        Args:
            which: indices of the n bodies; a body may occur several times.
            ys: y of the planes that cut each body.
            zs: z of the planes that cut each body.
        """

    @abstractmethod
    def holds(self, which: Indices, points: Floats) -> Bools:
        """Return whether each body in `which` contains its point, up to the margin."""

    def bounds(self) -> tuple[Floats, Floats]:
        """Return smallest x and y, and largest x and y, m."""
        plan, reach = self.centres[:, :2], self.reach()[:, :2]
        return (plan - reach).min(axis=0), (plan + reach).max(axis=0)

    def draw(self, canvas: Canvas, window: Window) -> None:
        """Occupy the cells that the bodies intersect within the height range."""
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
    """Ellipsoids; the columns of `axes`, shape (n, 3, 3), are their half axes in the world frame, m."""

    centres: Floats
    axes: Floats

    def reach(self) -> Floats:
        """Return how far each ellipsoid extends: the norms of the rows of its axes."""
        extent: Floats = np.linalg.norm(self.axes, axis=2)
        return extent

    def holds(self, which: Indices, points: Floats) -> Bools:
        """Return whether each ellipsoid contains its point; in the frame of its half axes, an ellipsoid is the unit ball."""
        radii = np.linalg.norm(self.axes, axis=1)
        unit = np.einsum("nij,ni->nj", (self.axes / radii[:, None] ** 2)[which], points - self.centres[which])
        within: Bools = np.linalg.norm(unit, axis=1) <= 1 + MARGIN / radii.min(axis=1)[which]
        return within

    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """Yield the extreme points of the ellipsoids, and of their sections by the planes."""
        matrices = self.axes @ self.axes.transpose(0, 2, 1)
        whole = self.centres[which], matrices[which]
        for ellipse in _sections(whole, ys, zs):
            yield from _farthest(ellipse)


@dataclass(frozen=True, slots=True)
class Cylinders(_Quadrics):
    """Cylinders, each between two discs.

    Attributes:
        centres: centres in the world frame, shape (n, 3), m.
        axes: unit vectors along the cylinders, shape (n, 3).
        radii: radii of the discs, shape (n,), m.
        halves: half lengths, shape (n,), m.
    """

    centres: Floats
    axes: Floats
    radii: Floats
    halves: Floats

    def reach(self) -> Floats:
        """Return how far each cylinder extends: the extents of its half axis plus the extents of a disc."""
        slant = np.sqrt(np.maximum(1 - self.axes**2, 0.0))
        return self.halves[:, None] * np.abs(self.axes) + self.radii[:, None] * slant

    def holds(self, which: Indices, points: Floats) -> Bools:
        """Return whether each cylinder contains its point: between the discs, and close enough to the axis."""
        offsets, axes = points - self.centres[which], self.axes[which]
        along = np.einsum("ni,ni->n", offsets, axes)
        away = np.linalg.norm(offsets - along[:, None] * axes, axis=1)
        within: Bools = (np.abs(along) <= self.halves[which] + MARGIN) & (away <= self.radii[which] + MARGIN)
        return within

    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """Yield extreme points of both discs, and of the ellipses in which the planes cut the cylinder's side.

        An ellipse of this kind is the projection of a disc, along the axis, onto the plane.
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
    """Yield ellipsoids, and their sections by planes of constant y, of constant z, and of both."""
    for cut in (ellipse, *(_section(ellipse, _Y, y) for y in ys)):
        yield cut
        yield from (_section(cut, _Z, z) for z in zs)


def _section(ellipse: Ellipses, axis: int, values: Floats) -> Ellipses:
    """Return the sections of ellipsoids at given values of a coordinate; undefined where a plane misses its ellipsoid."""
    centres, matrices = ellipse
    column = matrices[:, :, axis]
    offset = values - centres[:, axis]
    ratio = (offset / column[:, axis])[:, None]
    rest = matrices - column[:, :, None] * column[:, None, :] / column[:, axis, None, None]
    return centres + column * ratio, rest * (1 - offset[:, None, None] * ratio[:, None])


def _farthest(ellipse: Ellipses) -> Iterator[Floats]:
    """Yield the point of smallest x, the centre and the point of largest x of each ellipse.

    The centre is needed for a thin ellipse, because rounding errors may drop both other points.
    """
    centres, matrices = ellipse
    step = matrices[:, :, _X] / np.sqrt(matrices[:, _X, _X, None])
    yield from (centres - step, centres, centres + step)
