"""Finds the free points of a region, and the straight ways between them, for movers that walk at random.

Points and ways depend on the scene only: robots and movable bodies are no obstacles. So a walk depends only on scene and seed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.routes import Route
from graphengine.physics.dynamics.overlaps import distances
from graphengine.physics.dynamics.tracks import Track, Walk
from graphengine.physics.model.surface_joints import SUFFIX

POINTS = 40
"""Number of points of a region that are tried."""
NEIGHBOURS = 6
"""Number of nearest points to which a straight way is tried."""
CLEARANCE = 0.1
"""Smallest distance of a walking mover from obstacles, m."""
_STEP = 0.25
"""Distance of the places on a straight way at which obstacles are searched, m."""

Point = tuple[float, float]


def track_of(model: mujoco.MjModel, name: str, route: Route) -> Track | Walk:
    """Return the motion of a mover; a mover stands still in a region without ways between free points."""
    ways = free_ways(model, name, route) if route.region is not None else {}
    return Walk(route, name, ways) if ways else Track(route)


def free_ways(model: mujoco.MjModel, name: str, route: Route) -> dict[Point, list[Point]]:
    """Return the free points (x, y, m) of the region of a route, each with the points to which the straight way is free."""
    assert route.region is not None
    (west, south), (east, north) = route.region
    spread = ((_spread(number, 2), _spread(number, 3)) for number in range(1, POINTS + 1))
    within = [(west + across * (east - west), south + along * (north - south)) for across, along in spread]
    is_free = _Checker(model, name).is_free
    points = [point for point in within if is_free(point)]
    found: dict[Point, list[Point]] = {point: [] for point in points}
    for point in points:
        for other in sorted(points, key=lambda other: math.dist(point, other))[1 : NEIGHBOURS + 1]:
            if other not in found[point] and all(map(is_free, _between(point, other))):
                found[point].append(other)
                found[other].append(point)
    return {point: others for point, others in found.items() if others}


def _spread(number: int, base: int) -> float:
    """Return a number from 0 to 1 of van der Corput's sequence, whose numbers are spread evenly."""
    found, share = 0.0, 1.0
    while number:
        number, digit = divmod(number, base)
        share /= base
        found += digit * share
    return found


def _between(start: Point, end: Point) -> Iterator[Point]:
    """Yield points on the straight way between two points."""
    count = math.ceil(math.dist(start, end) / _STEP)
    for step in range(1, count):
        x, y = (one + (other - one) * step / count for one, other in zip(start, end, strict=True))
        yield x, y


class _Checker:
    """Checks places for obstacles, in a state of its own."""

    def __init__(self, model: mujoco.MjModel, name: str) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._root = int(model.body(name).id)
        self._place = int(model.joint(f"{name}{SUFFIX}0").qposadr[0])
        self._fixed = model.body_weldid[model.geom_bodyid] == 0

    def is_free(self, point: Point) -> bool:
        """Return whether the mover is far enough from all bodies that are fixed to the world."""
        model, data = self._model, self._data
        data.qpos[self._place : self._place + 2] = np.subtract(point, model.body_pos[self._root][:2])
        mujoco.mj_kinematics(model, data)
        return not any(self._fixed[geom] for geom in distances(model, data, self._root, CLEARANCE))
