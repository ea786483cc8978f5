"""Finds the pose in a map, other than the true pose, at which a scan fits best.

A coarse search compares a scan with all places of the map at once. The table of a scan has rays and range bins of half a metre,
with a 1 in the bin of each ray's range. The table of a place has the likelihood field at the point of each ray and bin. The
circular correlation of the two tables over the rays, computed by Fourier transforms, scores all rotations of the scan at the
place. Then the best places, at most one per square of TILE metres, are refined with the scores of the likelihood field.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from graphengine.bringup.maps.likelihood_field import LikelihoodField, Singles
from graphengine.descriptions.engine import Bools, Floats, Indices

Spectra = NDArray[np.complex64]

FARTHEST, BIN = 10.0, 0.5
"""Largest range in the coarse search, and width of its range bins, m."""
BLUR = 0.3
"""Distance by which the coarse search widens maxima of the likelihood field in all directions, m."""
TILE, CANDIDATES = 1.5, 6
NEAR, TURNED = 1.0, 0.15
"""Distance (m) and angle (rad) from the true pose up to which the search excludes poses."""
_BLOCK = 32


class ScanMatcher:
    """Finds the best other pose for the scan of each place."""

    def __init__(self, field: LikelihoodField, rows: Indices, columns: Indices, ranges: Floats, window: Floats) -> None:
        """Compute the tables of all places and scans.

        Args:
            field: likelihood field of the map.
            rows: rows of the places.
            columns: columns of the places.
            ranges: ranges of the rays of a full circle, m, NaN for no return, shape (places, rays).
            window: 1 for each ray in the field of view at a heading, else 0, shape (rays, headings).
        """
        self._field, self._rows, self._columns, self._ranges, self._window = field, rows, columns, ranges, window
        self._rays = ranges.shape[1]
        self._skip = 2 if self._rays % 2 == 0 else 1
        tile = max(1, round(TILE / field.cell))
        keys = (rows // tile) * (int(columns.max()) // tile + 1) + columns // tile
        self._order = np.argsort(keys, kind="stable")
        self._starts = np.flatnonzero(np.diff(keys[self._order], prepend=-1))
        self._places, self._scans = self._transforms()
        self._first, self._found = 0, self._search(0)

    def best_other(self, place: int) -> tuple[Floats, Floats]:
        """Return, for each heading at a place, the best other pose and the likelihood ratio of one scan at that pose.

        The caller must proceed in ascending order of places.

        Returns:
            Ratios, shape (headings,), and poses as column, row and heading (rad), shape (headings, 3); NaN without another pose.
        """
        if not self._first <= place < self._first + _BLOCK:
            self._first = place - place % _BLOCK
            self._found = self._search(self._first)
        headings = self._window.shape[1]
        met = np.isfinite(self._ranges[place])
        window = self._window[met]
        true = 1.0 + float(self._field.score.max()) * window.sum(axis=0)
        rows, columns, turns, found = self._refined(place, met)
        if not len(rows):
            return 1.0 / true, np.full((headings, 3), np.nan)
        likelihood = 1.0 + found @ window
        best = np.argmax(likelihood, axis=0)
        angle = (turns[best] + np.arange(headings) * math.tau / headings) % math.tau
        return likelihood[best, np.arange(headings)] / true, np.stack([columns[best], rows[best], angle], axis=1)

    def _transforms(self) -> tuple[Spectra, Spectra]:
        """Return the Fourier transforms over the rays of all places' tables, and the conjugates of those of all scans' tables.

        Both have the shape (frequencies, places, bins).
        """
        field, rays = self._field, self._rays // self._skip
        bins = round(FARTHEST / BIN)
        blurred = _spread(field.score, round(BLUR / field.cell)).ravel()
        angle = np.arange(rays) * math.tau / rays
        middle = (np.arange(bins) + 0.5) * BIN / field.cell
        places = np.empty((len(self._rows), rays, bins), np.float32)
        for number in range(rays):
            down = np.rint(middle * math.sin(angle[number])).astype(np.intp)
            right = np.rint(middle * math.cos(angle[number])).astype(np.intp)
            places[:, number] = blurred[field.index(self._rows[:, None] + down, self._columns[:, None] + right)]
        ranges = self._ranges[:, :: self._skip]
        scans = np.zeros_like(places)
        which, ray = np.nonzero(ranges < FARTHEST)
        scans[which, ray, (ranges[which, ray] / BIN).astype(np.intp)] = 1.0
        spectra = (np.fft.rfft(values, axis=1).transpose(1, 0, 2).astype(np.complex64) for values in (places, scans))
        first, second = (np.ascontiguousarray(values) for values in spectra)
        return first, np.conj(second)

    def _search(self, first: int) -> tuple[Indices, Indices]:
        """Return the candidate poses of the coarse search for a block of scans, best first.

        Args:
            first: index of the first scan of the block.

        Returns:
            Indices of places (-1 for no candidate) and rotations in coarse rays, both of shape (scans, candidates).
        """
        scans = self._scans[:, first : first + _BLOCK]
        spectrum = scans @ self._places.transpose(0, 2, 1)
        match = np.fft.irfft(spectrum, self._rays // self._skip, axis=0)  # (turns, scans, places)
        x, y = self._columns * self._field.cell, self._rows * self._field.cell
        own = np.arange(first, first + scans.shape[1])
        close = np.hypot(x[own, None] - x, y[own, None] - y) <= NEAR
        turns = np.arange(len(match)) * math.tau / len(match)
        small = np.minimum(turns, math.tau - turns) <= TURNED
        match[small] = np.where(close, -1.0, match[small])
        turn = match.argmax(axis=0)
        best = np.take_along_axis(match, turn[None], axis=0)[0]
        tiles = np.maximum.reduceat(best[:, self._order], self._starts, axis=1)
        top = np.argsort(-tiles, axis=1, kind="stable")[:, :CANDIDATES]
        ends = np.append(self._starts[1:], len(self._order))
        chosen = np.zeros(top.shape, np.intp)
        for scan, tile in np.ndindex(*top.shape):
            members = self._order[self._starts[top[scan, tile]] : ends[top[scan, tile]]]
            chosen[scan, tile] = members[np.argmax(best[scan, members])]
        valid = np.take_along_axis(best, chosen, axis=1) > 0.0
        chosen[~valid] = -1
        return chosen, np.take_along_axis(turn, np.maximum(chosen, 0), axis=1)

    def _refined(self, place: int, met: Bools) -> tuple[Indices, Indices, Floats, Singles]:
        """Return the refined rows, columns and rotations (rad) of a scan's candidates, and the scores of their rays.

        Each refinement compares poses that are up to `reach` steps of `step` cells and up to `count` rotations of `turn` (rad)
        away.
        """
        field = self._field
        chosen, coarse = (found[place - self._first] for found in self._found)
        coarse, chosen = coarse[chosen >= 0], chosen[chosen >= 0]
        rows, columns = self._rows[chosen], self._columns[chosen]
        turns = coarse * (math.tau * self._skip / self._rays)
        angle = (np.arange(self._rays) * math.tau / self._rays)[met]
        along = self._ranges[place, met] / field.cell
        tenth = max(1, round(0.1 / field.cell))
        pose = np.arange(len(chosen))
        scores = np.zeros((len(chosen), len(along)), np.float32)
        for step, reach, turn, count in ((tenth, 2, 0.02, 4), (1, 1, 0.005, 2)):
            turned = turns[:, None] + turn * np.arange(-count, count + 1)
            direction = turned[:, :, None] + angle
            down = np.rint(rows[:, None, None] + along * np.sin(direction)).astype(np.intp)
            right = np.rint(columns[:, None, None] + along * np.cos(direction)).astype(np.intp)
            axis = step * np.arange(-reach, reach + 1)
            down_by, right_by = (values.ravel() for values in np.meshgrid(axis, axis, indexing="ij"))
            ends = field.index(down, right)[:, :, None, :] + field.shift(down_by, right_by)[:, None]
            compared = field.score.ravel().take(ends)  # (poses, turns, offsets, rays)
            best = compared.sum(axis=3).reshape(len(rows), turned.shape[1] * len(down_by)).argmax(axis=1)
            which, offset = np.divmod(best, len(down_by))
            rows, columns, turns = rows + down_by[offset], columns + right_by[offset], turned[pose, which]
            scores = compared[pose, which, offset]
        return rows, columns, turns, scores


def _spread(values: Singles, cells: int) -> Singles:
    """Return, for each cell, the largest value within the square that extends `cells` cells from it in each direction."""
    for axis in (0, 1):
        wide = np.pad(values, [(cells, cells) if one == axis else (0, 0) for one in (0, 1)], mode="edge")
        size = values.shape[axis]
        parts = [np.take(wide, np.arange(step, step + size), axis=axis) for step in range(2 * cells + 1)]
        values = np.maximum.reduce(parts)
    return values
