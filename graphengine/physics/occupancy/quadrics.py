"""Ellipsoids (spheres included) and cylinders, rasterized in closed form.

The greatest x of a convex body, cut by planes of constant y and z, lies where its surfaces and those planes meet, and there are
few such places: the farthest points of ellipses, and of their sections by the planes. All of them are found, those that are
no part of the cut body are dropped, and what remains holds the farthest. What rounding spoils is dropped, too, so a place that
counts is a place where the body is.

An ellipsoid is kept as its centre c and the matrix Q = A A^T of an A that maps the unit ball onto it. Its farthest points along x
are c +- Q e / sqrt(e^T Q e). Its section by a plane of constant coordinate has the Schur complement of that coordinate as its
matrix, scaled; the same formulae hold for a disc, which is an ellipsoid with a Q of rank two.
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
    """Convex bodies that are cut by planes of constant y and z."""

    centres: Floats
    """(n, 3), m."""

    @abstractmethod
    def reach(self) -> Floats:
        """Extents of the bodies from their centres along x, y and z: (n, 3), m."""

    @abstractmethod
    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """Points (n, 3), among them those of least and greatest x of each body cut by planes."""

    @abstractmethod
    def holds(self, which: Indices, points: Floats) -> Bools:
        """Whether bodies contain points, within the margin."""

    def bounds(self) -> tuple[Floats, Floats]:
        """Least and greatest x and y."""
        plan, reach = self.centres[:, :2], self.reach()[:, :2]
        return (plan - reach).min(axis=0), (plan + reach).max(axis=0)

    def draw(self, canvas: Canvas, window: Window) -> None:
        """Occupy the cells that the bodies stand in."""
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
    """Ellipsoids, given by `axes`: (n, 3, 3), m, the half axes as columns."""

    centres: Floats
    axes: Floats

    def reach(self) -> Floats:
        """The norm of a row of the axes is the extent along that coordinate."""
        extent: Floats = np.linalg.norm(self.axes, axis=2)
        return extent

    def holds(self, which: Indices, points: Floats) -> Bools:
        """In the frame of the half axes an ellipsoid is the unit ball."""
        radii = np.linalg.norm(self.axes, axis=1)
        unit = np.einsum("nij,ni->nj", (self.axes / radii[:, None] ** 2)[which], points - self.centres[which])
        within: Bools = np.linalg.norm(unit, axis=1) <= 1 + MARGIN / radii.min(axis=1)[which]
        return within

    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """The ellipsoid's own farthest points, and those of its sections."""
        matrices = self.axes @ self.axes.transpose(0, 2, 1)
        whole = self.centres[which], matrices[which]
        for ellipse in _sections(whole, ys, zs):
            yield from _farthest(ellipse)


@dataclass(frozen=True, slots=True)
class Cylinders(_Quadrics):
    """Cylinders between two discs.

    Attributes:
        centres: (n, 3), m.
        axes: (n, 3), unit vectors.
        radii: (n,), m.
        halves: (n,), m, half the lengths.
    """

    centres: Floats
    axes: Floats
    radii: Floats
    halves: Floats

    def reach(self) -> Floats:
        """Extents of the axis and of the discs at its ends."""
        slant = np.sqrt(np.maximum(1 - self.axes**2, 0.0))
        return self.halves[:, None] * np.abs(self.axes) + self.radii[:, None] * slant

    def holds(self, which: Indices, points: Floats) -> Bools:
        """Points between the discs that are near enough to the axis."""
        offsets, axes = points - self.centres[which], self.axes[which]
        along = np.einsum("ni,ni->n", offsets, axes)
        away = np.linalg.norm(offsets - along[:, None] * axes, axis=1)
        within: Bools = (np.abs(along) <= self.halves[which] + MARGIN) & (away <= self.radii[which] + MARGIN)
        return within

    def places(self, which: Indices, ys: Sequence[Floats], zs: Sequence[Floats]) -> Iterator[Floats]:
        """Points of both discs, and of the ellipses in which the planes cut the side.

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
    """An ellipsoid, and its sections by planes of y, of z, and of both."""
    for cut in (ellipse, *(_section(ellipse, _Y, y) for y in ys)):
        yield cut
        yield from (_section(cut, _Z, z) for z in zs)


def _section(ellipse: Ellipses, axis: int, values: Floats) -> Ellipses:
    """Sections of ellipsoids at given values of a coordinate; undefined where a plane misses."""
    centres, matrices = ellipse
    column = matrices[:, :, axis]
    offset = values - centres[:, axis]
    ratio = (offset / column[:, axis])[:, None]
    rest = matrices - column[:, :, None] * column[:, None, :] / column[:, axis, None, None]
    return centres + column * ratio, rest * (1 - offset[:, None, None] * ratio[:, None])


def _farthest(ellipse: Ellipses) -> Iterator[Floats]:
    """The points of least and greatest x; and the centre, as rounding may lose those of an ellipse that is a point."""
    centres, matrices = ellipse
    step = matrices[:, :, _X] / np.sqrt(matrices[:, _X, _X, None])
    yield from (centres - step, centres, centres + step)
