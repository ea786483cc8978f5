"""Flood fill: finds the free cells that are connected to given cells by their sides.

Free cells are grouped into runs along rows. Two runs in neighbouring rows touch if their columns overlap. Runs are sorted, so the
runs of one row that touch a given run are consecutive.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graphengine.descriptions.engine import Bools


def reached(free: Bools, seeds: Sequence[tuple[int, int]]) -> Bools:
    """Return for each cell whether it is free and connected to a seed; seeds are (row, column)."""
    rows, columns = free.shape
    steps = np.diff(free.astype(np.int8), axis=1, prepend=0, append=0)
    row, start = np.nonzero(steps == 1)
    _, stop = np.nonzero(steps == -1)
    width = columns + 1
    starts, stops = row * width + start, row * width + stop

    def touching(shift: int) -> tuple[list[int], list[int]]:
        """Return, for each run, the first index and the index after the last of the runs that it touches `shift` rows away."""
        first = np.searchsorted(stops, starts + shift * width, side="right")
        last = np.searchsorted(starts, stops + shift * width, side="left")
        return first.tolist(), last.tolist()

    neighbours = touching(-1), touching(1)
    pending = [int(np.searchsorted(starts, r * width + c, side="right")) - 1 for r, c in seeds if free[r, c]]
    met = np.zeros(len(starts), np.bool_)
    met[pending] = True
    while pending:
        run = pending.pop()
        for first, last in neighbours:
            for other in range(first[run], last[run]):
                if not met[other]:
                    met[other] = True
                    pending.append(other)
    painted = np.zeros((rows, width), np.int8)
    painted[row[met], start[met]] = 1
    painted[row[met], stop[met]] = -1
    return np.cumsum(painted, axis=1, dtype=np.int8)[:, :-1] > 0
