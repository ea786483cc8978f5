"""The motion of movers as pieces of constant velocity: along a route, or at random between free points."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from graphengine.descriptions.routes import Route
from graphengine.devices.random_streams import key_of

TURN = math.pi
"""Speed at which a mover turns to its new direction while it walks on, rad/s."""
SHORTEST_LAP = 0.1
"""Shortest time in which a mover returns to its first point, s; otherwise it stands at the last one."""
_AT_REST = (0.0, 0.0, 0.0, 0.0)

Place = tuple[float, float]
Timed = tuple[float, float, float, float]
"""Time (s) and position (m)."""
Coordinates = tuple[float, float, float, float]
"""x, y (m), heading (rad) and z (m), or their rates."""


class Piece(NamedTuple):
    """A stretch of time in which a mover has constant velocity."""

    begin: float
    end: float
    at: Coordinates
    """Coordinates at the beginning."""
    velocity: Coordinates


class MoverMotion:
    """The motion of a mover, a function of time and seed.

    Args:
        pieces: function that yields the pieces for a seed in their order, from time 0 without end.
        stuck: whether the mover stands still because no obstacle-free straight path connects two free points of its region.
    """

    def __init__(self, pieces: Callable[[int], Iterator[Piece]], *, stuck: bool = False) -> None:
        self.stuck = stuck
        self._pieces = pieces
        self._rest: Iterator[Piece] = iter(())
        self._seed, self._now = 0, Piece(math.inf, math.inf, _AT_REST, _AT_REST)

    def at(self, time: float, seed: int) -> Piece:
        """Return the piece of the motion at a time, s."""
        if time < self._now.begin or seed != self._seed:
            self._seed, self._rest = seed, self._pieces(seed)
            self._now = next(self._rest)
        while self._now.end <= time:
            self._now = next(self._rest)
        return self._now


def along(route: Route) -> Iterator[Piece]:
    """Yield the pieces of the motion along a route."""
    points, start = route.points, route.start
    period = route.period if route.period >= SHORTEST_LAP else 0.0
    headings = _headings(points, closed=period > 0.0)
    before = headings[0]
    yield Piece(0.0, start, _coordinates(points[0][1:], before), _AT_REST)
    for lap in itertools.count() if period else range(1):
        begin = start + lap * period
        yield from _pieces([(begin + time, x, y, z) for time, x, y, z in points], headings, before)
        before = headings[-1]
    yield Piece(start + points[-1][0], math.inf, _coordinates(points[-1][1:], before), _AT_REST)


def random_walk(route: Route, name: str, ways: Mapping[Place, Sequence[Place]], seed: int) -> Iterator[Piece]:
    """Yield the pieces of a random walk.

    Args:
        route: route with the speed, the start and the height.
        name: name of the mover; each mover has its own random stream.
        ways: free points (x, y, m), each with the points to which the straight path is free of obstacles.
        seed: seed of the session.
    """
    random = np.random.Generator(np.random.Philox(key=key_of(seed, name)))
    here, height, time = list(ways)[int(random.integers(len(ways)))], route.points[0][3], route.start
    before: float | None = None
    while True:
        there = ways[here][int(random.integers(len(ways[here])))]
        step = (time, *here, height), (time + math.dist(here, there) / route.speed, *there, height)
        (heading,) = _headings(step, closed=False)
        if before is None:
            yield Piece(0.0, time, (*here, heading, height), _AT_REST)
        yield from _pieces(step, [heading], heading if before is None else before)
        here, time, before = there, step[1][0], heading


def _coordinates(position: Sequence[float], heading: float) -> Coordinates:
    x, y, z = position
    return x, y, heading, z


def _headings(points: Sequence[Timed], *, closed: bool) -> list[float]:
    """Return the heading between each two points; without horizontal motion there, the next heading, or else the last one."""
    steps = [(u - x, v - y) for (_, x, y, _), (_, u, v, _) in itertools.pairwise(points)]
    known = [math.atan2(y, x) for x, y in steps if x or y] or [0.0]
    headings = [known[0] if closed else known[-1]]
    for x, y in reversed(steps):
        headings.append(math.atan2(y, x) if x or y else headings[-1])
    return headings[:0:-1] or known


def _pieces(points: Sequence[Timed], headings: Sequence[float], before: float) -> Iterator[Piece]:
    """Yield the pieces of constant velocity in which a mover goes from point to point.

    After each point, the mover turns to its next heading while it moves on. It turns at the rate `TURN`, or faster if the next
    point is near.

    Args:
        points: time (s) and position (x, y, z, m) of each point, in ascending order of the times. The mover jumps between two
            points with the same time.
        headings: heading of the mover from each point to the next point, rad.
        before: heading of the mover before it turns at the first point, rad.
    """
    for ((begin, *here), (end, *there)), heading in zip(itertools.pairwise(points), headings, strict=False):
        if end <= begin:
            continue
        velocity = [(goal - start) / (end - begin) for start, goal in zip(here, there, strict=True)]
        turn = math.remainder(heading - before, math.tau)
        turned = min(begin + abs(turn) / TURN, end)
        if turned > begin:
            rate = turn / (turned - begin)
            yield Piece(begin, turned, _coordinates(here, before), _coordinates(velocity, rate))
            here = [start + speed * (turned - begin) for start, speed in zip(here, velocity, strict=True)]
        yield Piece(turned, end, _coordinates(here, heading), _coordinates(velocity, 0.0))
        before = heading
