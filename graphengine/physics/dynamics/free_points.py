"""Finds the points and straight paths without obstacles in the region of a mover that walks at random.

Only bodies that are fixed to the world are obstacles, not robots or movable bodies. So a walk depends only on scene and seed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graphengine.descriptions.engine import Floats, collides, mujoco
from graphengine.descriptions.geoms import extents
from graphengine.descriptions.routes import Route
from graphengine.physics.dynamics.mover_motion import MoverMotion, Place, along, random_walk
from graphengine.physics.dynamics.overlaps import distances
from graphengine.physics.model.surface_joints import SUFFIX

POINTS = 40
"""Number of candidate points of a region."""
NEIGHBOURS = 6
"""Maximum number of nearest points to which the straight path is checked, for each free point."""
CLEARANCE = 0.1
"""Smallest distance of a walking mover from obstacles, m."""
_STEP = 0.25
"""Minimum length of a straight path, and maximum distance between the points of a path that are checked for obstacles, m."""
_HEADINGS = [step * math.pi / 4.0 for step in range(8)]
"""Headings in which a mover must be clear of obstacles at a free point, because it turns there, rad."""


def motion_of(model: mujoco.MjModel, name: str, route: Route) -> MoverMotion:
    """Return the motion of a mover. The mover stands still if no straight path connects two free points of its region."""
    ways = free_ways(model, name, route) if route.region is not None else {}
    if ways:
        return MoverMotion(lambda seed: random_walk(route, name, ways, seed))
    return MoverMotion(lambda _: along(route), stuck=route.region is not None)


def free_ways(model: mujoco.MjModel, name: str, route: Route) -> dict[Place, list[Place]]:
    """Return the free points (x, y, m) of the region of a route, each with the points to which the straight path is free."""
    assert route.region is not None
    is_free = _Checker(model, name).is_free
    spread = np.random.Generator(np.random.Philox(key=0)).uniform(*route.region, (POINTS, 2))
    points = [point for point in map(_place, spread) if is_free(point, _HEADINGS)]
    found: dict[Place, list[Place]] = {point: [] for point in points}
    for point in points:
        apart = [other for other in points if math.dist(point, other) >= _STEP]
        for other in sorted(apart, key=lambda other: math.dist(point, other))[:NEIGHBOURS]:
            heading = math.atan2(other[1] - point[1], other[0] - point[0])
            between = np.linspace(point, other, math.ceil(math.dist(point, other) / _STEP) + 1)[1:-1]
            if other in found[point] or not all(is_free(_place(on), (heading, heading + math.pi)) for on in between):
                continue
            found[point].append(other)
            found[other].append(point)
    return {point: others for point, others in found.items() if others}


def _place(values: Floats) -> Place:
    x, y = values.tolist()
    return x, y


class _Checker:
    """Checks points for bodies that are fixed to the world, in a separate MuJoCo state."""

    def __init__(self, model: mujoco.MjModel, name: str) -> None:
        self._model, self._data, self._root = model, mujoco.MjData(model), int(model.body(name).id)
        self._place = int(model.joint(f"{name}{SUFFIX}0").qposadr[0])
        mujoco.mj_kinematics(model, self._data)
        own = extents(model, self._data, np.flatnonzero(model.geom_bodyid == self._root).tolist())
        assert own is not None
        self._origin, self._fixed = model.body_pos[self._root][:2], model.body_weldid[model.geom_bodyid] == 0
        self._reach = float(np.linalg.norm(np.maximum(abs(own[0][:2] - self._origin), abs(own[1][:2] - self._origin))))
        boxes = [extents(model, self._data, [geom]) for geom in np.flatnonzero(self._fixed & collides(model)).tolist()]
        solid = [box for box in boxes if box is not None and box[0][2] < own[1][2] and box[1][2] > own[0][2]]
        self._low, self._high = (np.array([box[side][:2] for box in solid]).reshape(-1, 2) for side in (0, 1))

    def is_free(self, point: Place, headings: Sequence[float]) -> bool:
        """Return whether the mover is clear of all fixed bodies at a point, in each of some headings."""
        gaps = np.maximum(np.maximum(self._low - point, point - self._high), 0.0)
        is_far = bool((np.hypot(*gaps.T) > self._reach + CLEARANCE).all())
        return is_far or all(self._fits(point, heading) for heading in headings)

    def _fits(self, point: Place, heading: float) -> bool:
        model, data = self._model, self._data
        data.qpos[self._place : self._place + 3] = *np.subtract(point, self._origin), heading
        mujoco.mj_kinematics(model, data)
        return not any(self._fixed[geom] for geom in distances(model, data, self._root, CLEARANCE))
