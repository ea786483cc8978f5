"""The motion of movers as pieces of constant velocity: along a route, or at random between free points."""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from graphengine.descriptions.routes import Route
from graphengine.devices.random_streams import key_of

TURN = math.pi
"""Speed at which a mover turns to its new direction while it walks on, rad/s."""

_AT_REST = (0.0, 0.0, 0.0, 0.0)

Point = tuple[float, float, float, float]
"""Time (s) and position (m)."""
Coordinates = tuple[float, float, float, float]


class Piece(NamedTuple):
    """A stretch of time in which a mover has constant velocity; its coordinates are x, y (m), heading (rad) and z (m)."""

    begin: float
    end: float
    at: Coordinates
    """Coordinates at the beginning."""
    velocity: Coordinates

    def later(self, by: float) -> Piece:
        """Return the same piece at a later time, s."""
        return self._replace(begin=self.begin + by, end=self.end + by)


def _ordered(position: Sequence[float], heading: float) -> Coordinates:
    x, y, z = position
    return x, y, heading, z


def _headings(points: Sequence[Point], *, closed: bool) -> list[float]:
    """Return the heading between each two points; without horizontal motion, that of the next motion, or else of the last one."""
    steps = [(u - x, v - y) for (_, x, y, _), (_, u, v, _) in itertools.pairwise(points)]
    found = [math.atan2(y, x) if x or y else None for x, y in steps]
    known = [heading for heading in found if heading is not None] or [0.0]
    following = known[0] if closed else known[-1]
    headings: list[float] = []
    for heading in reversed(found):
        following = heading if heading is not None else following
        headings.append(following)
    return headings[::-1] or known


def _pieces(points: Sequence[Point], headings: Iterable[float], before: float) -> Iterator[Piece]:
    """Yield the pieces of a motion between points.

    Args:
        points: points of the motion; two at the same time are a jump.
        headings: heading between each two points, rad.
        before: heading at the first point, rad.
    """
    for ((begin, *here), (end, *there)), heading in zip(itertools.pairwise(points), headings, strict=False):
        if end <= begin:
            continue
        velocity = tuple((goal - start) / (end - begin) for start, goal in zip(here, there, strict=True))
        turn = math.remainder(heading - before, math.tau)
        turned = min(begin + abs(turn) / TURN, end)
        if turned > begin:
            yield Piece(begin, turned, _ordered(here, before), _ordered(velocity, turn / (turned - begin)))
            here = [start + speed * (turned - begin) for start, speed in zip(here, velocity, strict=True)]
        if end > turned:
            yield Piece(turned, end, _ordered(here, heading), _ordered(velocity, 0.0))
        before = heading


class Track:
    """The motion along a route; a function of time."""

    def __init__(self, route: Route) -> None:
        points = route.points
        headings = _headings(points, closed=route.period > 0.0)
        self._start, self._period = route.start, route.period
        self._first = list(_pieces(points, headings, headings[0]))
        self._later = list(_pieces(points, headings, headings[-1]))
        self._waiting = Piece(0.0, route.start, _ordered(points[0][1:], headings[0]), _AT_REST)
        over = route.start + points[-1][0]
        self._over = Piece(over, math.inf, _ordered(points[-1][1:], headings[-1]), _AT_REST)

    def at(self, time: float, seed: int) -> Piece:
        """Return the piece of the motion at a time, s."""
        if time < self._start:
            return self._waiting
        if not self._period:
            return _at(self._first, time, self._start) if time < self._over.begin else self._over
        lap = math.floor((time - self._start) / self._period)
        lap += (self._start + (lap + 1) * self._period <= time) - (self._start + lap * self._period > time)  # rounding
        begin, end = (self._start + number * self._period for number in (lap, lap + 1))
        pieces = self._later if lap else self._first
        found = _at(pieces, time, begin)
        return found._replace(end=min(found.end, end))


def _at(pieces: Sequence[Piece], time: float, offset: float = 0.0) -> Piece:
    """Return the piece at a time, if the motion begins at `offset`; the first or last one outside of all pieces."""
    found = bisect.bisect_right(pieces, time, key=lambda piece: piece.begin + offset) - 1
    return pieces[max(found, 0)].later(offset)


class Walk:
    """A random walk between points; a function of time and seed.

    Args:
        route: route with the speed, the start and the height.
        name: name of the mover, which has random numbers of its own.
        ways: points (x, y, m), each with the points to which the straight way is free.
    """

    def __init__(
        self, route: Route, name: str, ways: Mapping[tuple[float, float], Sequence[tuple[float, float]]]
    ) -> None:
        self._route, self._name, self._ways = route, name, ways
        self._seed: int | None = None

    def at(self, time: float, seed: int) -> Piece:
        """Return the piece of the motion at a time, s."""
        if seed != self._seed:
            self._seed, self._known = seed, list[Piece]()
            self._rest = self._walk(np.random.Generator(np.random.Philox(key=key_of(seed, self._name))))
        while not self._known or self._known[-1].end <= time:
            self._known.append(next(self._rest))
        return _at(self._known, time)

    def _walk(self, random: np.random.Generator) -> Iterator[Piece]:
        """Yield the pieces of the walk without end."""
        ways, height, time, before = self._ways, self._route.points[0][3], self._route.start, math.nan
        here = list(ways)[int(random.integers(len(ways)))]
        while True:
            there = ways[here][int(random.integers(len(ways[here])))]
            step = (time, *here, height), (time + math.dist(here, there) / self._route.speed, *there, height)
            (heading,) = _headings(step, closed=False)
            if math.isnan(before):
                yield Piece(0.0, time, (*here, heading, height), _AT_REST)
                before = heading
            yield from _pieces(step, [heading], before)
            here, time, before = there, step[1][0], heading
