"""Routes links around placed boxes, with short routes and few bends.

Each box has a frame at half the minimum distance between boxes. Frames never overlap, so a link can follow the frames from every
port to every other port. The lines of the frames form the grid of an A* search. Links on the same grid line are then spread over
the free strip around this line.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from itertools import count, pairwise

import numpy as np
from numpy.typing import NDArray

from graphengine.drawing.geometry import GAP, LayoutBox, LayoutLink, Point, Route, ends, simplified

_FRAME = (GAP[0] / 2, GAP[1] / 2)
_SPREAD = 10.0
"""Maximum distance by which a link is moved from its grid line, px."""
_LANE = 5.0
_BEND = 60.0
"""Cost of a bend in the search, as a length in px."""
_HASTE = 2.0
"""Weight of the remaining distance in the A* search; with a weight of 1, routes are optimal but the search is slow."""


def routes(boxes: Sequence[LayoutBox], corners: Sequence[Point], links: Sequence[LayoutLink]) -> list[Route]:
    """Return a polyline for each link; the caller must place boxes at least `GAP` apart."""
    router = _Router(boxes, corners, links)
    ways = [router.lines(*pair) for pair in router.ends]
    drawn = [_drawn(*pair, way) for pair, way in zip(router.ends, ways, strict=True)]
    apart = _spread(links, ways, drawn)
    return [_drawn(*pair, way) for pair, way in zip(router.ends, apart, strict=True)]


Line = tuple[int, float]
"""A grid line: (0, x) for a column at x, (1, y) for a row at y."""
Step = tuple[int, int, int]
"""A state of the search: column and row of a grid point, and the axis of the line that leads to it."""


class _Router:
    """The search grid: a line along each side of each frame, and a row for each port."""

    def __init__(self, boxes: Sequence[LayoutBox], corners: Sequence[Point], links: Sequence[LayoutLink]) -> None:
        self.ends = [ends(boxes, corners, link) for link in links]
        low = np.array(corners, float).reshape(-1, 2) - np.array(_FRAME)
        high = low + np.array([(box.width, box.height) for box in boxes]).reshape(-1, 2) + np.array(GAP)
        self.frames = np.round(np.stack([low, high], axis=1), 2)
        self.columns = np.unique(self.frames[:, :, 0])
        shared = np.unique(self.frames[:, :, 1])
        self.rows = np.unique([*shared, *(y for pair in self.ends for _, y in pair)])
        self.shared = np.isin(self.rows, shared).tolist()
        """Whether all links may use a row, for each row; other rows are reserved for the links of the ports at these heights."""
        self.places = (self.columns.tolist(), self.rows.tolist())
        self.open = self._open(0, self.columns, self.rows), self._open(1, self.rows, self.columns)

    def _open(self, axis: int, lines: NDArray[np.float64], along: NDArray[np.float64]) -> list[list[bool]]:
        """Return, for each point of each grid line of an axis, whether no frame blocks the way to the next point."""
        free = np.ones((len(lines), len(along)), bool)
        for (low, high), (begin, end) in zip(self.frames[:, :, axis], self.frames[:, :, 1 - axis], strict=True):
            across = slice(np.searchsorted(lines, low, "right"), np.searchsorted(lines, high, "left"))
            free[across, np.searchsorted(along, begin) : np.searchsorted(along, end)] = False
        opened: list[list[bool]] = free.tolist()
        return opened

    def lines(self, begin: Point, end: Point) -> list[Line]:
        """Return the path of a link as alternating rows and columns, found by an A* search with a cost for bends."""
        start = self._column(begin[0] + _FRAME[0]), int(np.searchsorted(self.rows, begin[1]))
        goal = self._column(end[0] - _FRAME[0]), int(np.searchsorted(self.rows, end[1]))
        columns, rows = self.places
        goal_x, goal_y = columns[goal[0]], rows[goal[1]]
        best: dict[Step, float] = {(*start, 1): 0.0}
        before: dict[Step, Step] = {}
        queue = [(0.0, (*start, 1))]
        while queue:
            _, here = heapq.heappop(queue)
            if here[:2] == goal:
                return self._lines_to(here, before, goal[1])
            for step in self._steps(here, (start[1], goal[1])):
                axis = step[2]
                along = self.places[1 - axis]
                way = abs(along[step[1 - axis]] - along[here[1 - axis]])
                cost = best[here] + way + _BEND * (axis != here[2])
                if cost < best.get(step, np.inf):
                    best[step], before[step] = cost, here
                    left = abs(columns[step[0]] - goal_x) + abs(rows[step[1]] - goal_y)
                    heapq.heappush(queue, (cost + _HASTE * left, step))
        raise AssertionError("no route between two ports: frames of boxes overlap")

    def _column(self, x: float) -> int:
        """Return the index of the column nearest to `x`, which may have a rounding error."""
        return int(np.abs(self.columns - x).argmin())

    def _steps(self, here: Step, own: tuple[int, int]) -> Iterator[Step]:
        """Yield the states that can follow a state of the search, without rows of other ports."""
        column, row, _ = here
        for way in (-1, 1):
            other = row
            while 0 <= other + way < len(self.shared) and self.open[0][column][other + min(way, 0)]:
                other += way
                if self.shared[other] or other in own:
                    yield column, other, 0
                    break
        if column > 0 and self.open[1][row][column - 1]:
            yield column - 1, row, 1
        if column + 1 < len(self.columns) and self.open[1][row][column]:
            yield column + 1, row, 1

    def _lines_to(self, here: Step, before: Mapping[Step, Step], last: int) -> list[Line]:
        found: list[Line] = [(1, self.places[1][last])]
        while True:
            axis = here[2]
            line = (axis, self.places[axis][here[axis]])
            if line != found[-1]:
                found.append(line)
            if here not in before:
                return found[::-1]
            here = before[here]


def _drawn(begin: Point, end: Point, lines: Sequence[Line]) -> Route:
    """Return the polyline of a link along grid lines; the first and last line are the rows of its ports."""
    corners = [(other, place) if axis == 1 else (place, other) for (axis, place), (_, other) in pairwise(lines)]
    return simplified([begin, *corners, end])


def _spread(links: Sequence[LayoutLink], ways: Sequence[Sequence[Line]], routes: Sequence[Route]) -> list[list[Line]]:
    """Return the grid lines of each route, moved apart where routes of different ports share a line."""
    spread = [list(way) for way in ways]
    stretches: dict[Line, dict[tuple[int, float], list[tuple[int, int]]]] = {}
    for number, way in enumerate(ways):
        for position, line in enumerate(way[1:-1], 1):
            port = (links[number].source, links[number].source_y)
            stretches.setdefault(line, {}).setdefault(port, []).append((number, position))
    for (axis, place), users in sorted(stretches.items()):
        lanes = _lanes([_extent(axis, place, routes, members) for members in users.values()])
        middle = max(lanes) / 2
        distance = min(_LANE, _SPREAD / middle) if middle else 0.0
        for lane, members in zip(lanes, users.values(), strict=True):
            for number, position in members:
                spread[number][position] = (axis, place + (lane - middle) * distance)
    return spread


def _extent(
    axis: int, place: float, routes: Sequence[Route], members: Sequence[tuple[int, int]]
) -> tuple[float, float]:
    """Return the range of a grid line that the given links use, as its first and last coordinate."""
    along = [
        point[1 - axis]
        for number, _ in members
        for pair in pairwise(routes[number])
        if pair[0][axis] == pair[1][axis] == place
        for point in pair
    ]
    return (min(along), max(along)) if along else (0.0, 0.0)


def _lanes(extents: Sequence[tuple[float, float]]) -> list[int]:
    """Return a lane number for each range; overlapping ranges have different lanes."""
    lanes: list[int] = []
    for number, (low, high) in enumerate(extents):
        taken = {lane for lane, (a, b) in zip(lanes, extents[:number], strict=False) if a <= high and low <= b}
        lanes.append(next(lane for lane in count() if lane not in taken))
    return lanes
