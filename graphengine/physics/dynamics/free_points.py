"""Finds the free points of a region, and the straight ways between them, for movers that walk at random.

Places and ways depend on the scene only: robots and movable bodies are no obstacles. So a walk depends only on scene and seed.
"""

from __future__ import annotations

import math

import numpy as np

from graphengine.descriptions.engine import Floats, mujoco
from graphengine.descriptions.routes import Route
from graphengine.physics.dynamics.mover_motion import MoverMotion, Place, along, random_walk
from graphengine.physics.dynamics.overlaps import distances
from graphengine.physics.model.surface_joints import SUFFIX

POINTS = 40
"""Number of points of a region that are tried."""
NEIGHBOURS = 6
"""Number of nearest points to which a straight way is tried."""
CLEARANCE = 0.1
"""Smallest distance of a walking mover from obstacles, m."""
_STEP = 0.25
"""Distance of the places on a straight way at which obstacles are searched, m."""


def motion_of(model: mujoco.MjModel, name: str, route: Route) -> MoverMotion:
    """Return the motion of a mover; it stands still in a region without ways between free points."""
    ways = free_ways(model, name, route) if route.region is not None else {}
    if ways:
        return MoverMotion(lambda seed: random_walk(route, name, ways, seed))
    return MoverMotion(lambda _: along(route), stuck=route.region is not None)


def free_ways(model: mujoco.MjModel, name: str, route: Route) -> dict[Place, list[Place]]:
    """Return the free points (x, y, m) of the region of a route, each with the points to which the straight way is free."""
    assert route.region is not None
    is_free = _Checker(model, name).is_free
    spread = np.random.Generator(np.random.Philox(key=0)).uniform(*route.region, (POINTS, 2))
    points = [point for point in map(_place, spread) if is_free(point)]
    found: dict[Place, list[Place]] = {point: [] for point in points}
    for point in points:
        for other in sorted(points, key=lambda other: math.dist(point, other))[1 : NEIGHBOURS + 1]:
            between = np.linspace(point, other, math.ceil(math.dist(point, other) / _STEP) + 1)[1:-1]
            if other not in found[point] and all(map(is_free, map(_place, between))):
                found[point].append(other)
                found[other].append(point)
    return {point: others for point, others in found.items() if others}


def _place(values: Floats) -> Place:
    x, y = values.tolist()
    return x, y


class _Checker:
    """Checks places for obstacles, in a state of its own."""

    def __init__(self, model: mujoco.MjModel, name: str) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._root = int(model.body(name).id)
        self._place = int(model.joint(f"{name}{SUFFIX}0").qposadr[0])
        self._fixed = model.body_weldid[model.geom_bodyid] == 0

    def is_free(self, point: Place) -> bool:
        """Return whether the mover is far enough from all bodies that are fixed to the world."""
        model, data = self._model, self._data
        data.qpos[self._place : self._place + 2] = np.subtract(point, model.body_pos[self._root][:2])
        mujoco.mj_kinematics(model, data)
        return not any(self._fixed[geom] for geom in distances(model, data, self._root, CLEARANCE))
