"""Flood fill: the free cells that are connected to given cells by their sides.

Cells are grouped into runs along rows. Runs of neighbouring rows touch where their columns overlap; runs are sorted, so those
that touch a given run are consecutive.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graphengine.physics.engine import Bools


def reached(free: Bools, seeds: Sequence[tuple[int, int]]) -> Bools:
    """Return the free cells that are connected to a seed; seeds are (row, column)."""
    rows, columns = free.shape
    steps = np.diff(free.astype(np.int8), axis=1, prepend=0, append=0)
    row, start = np.nonzero(steps == 1)
    _, stop = np.nonzero(steps == -1)
    width = columns + 1
    starts, stops = row * width + start, row * width + stop

    def touching(shift: int) -> tuple[list[int], list[int]]:
        """Return for each run the range of runs that it touches in a neighbouring row: first index, and index after the last."""
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
