"""The colliders of a sensor's own robot, and the colliders that the sensor's rays pass through.

The rays of a sensor with `sees_own_robot: false` pass through its whole robot. The rays of all other sensors hit the robot.
However, they pass through the sensor's own link and housing, and through the links that the key `ignores` names. They also pass
through each collider in which they start, and each collider nearer than the sensor's least distance. A link is one of the
description: a fixed joint separates two links. Colliders include the visuals of links without colliders, because rays hit these
too.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import Floats, Indices, mujoco
from graphengine.descriptions.geoms import triangles_of
from graphengine.devices.stage import Prim, housing_of

FOREIGN, VISIBLE, PASSED = 0, 1, 2
"""Roles of geoms for the rays of a sensor: of something else, of the own robot, or one that the rays pass through."""

_GEOM = mujoco.mjtGeom


class OwnColliders:
    """The geoms of a sensor's own robot.

    Args:
        model: model with the robot.
        data: state of the simulation.
        tree: root body of the robot; 0 if the sensor has no robot.
        body: body that carries the sensor.
        passed: bodies whose geoms the rays always pass through; None for all bodies of the robot.
        near: distance nearer than which the rays pass through colliders of the robot, m.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        tree: int = 0,
        *,
        body: int = 0,
        passed: NDArray[np.intp] | None = None,
        near: float = 0.0,
    ) -> None:
        self.near = near
        self.roles = np.zeros(model.ngeom, np.uint8)
        """Role of each geom, for the origin of the last call of `start_at`."""
        self._model, self._data = model, data
        bodies = model.geom_bodyid
        own = (model.body_rootid[bodies] == tree) & (tree > 0)
        self.roles[own] = PASSED if passed is None else np.where(np.isin(bodies[own], passed), PASSED, VISIBLE)
        self.seen = bool((self.roles == VISIBLE).any())
        """Whether rays hit any geom of the robot."""
        self.always_passed = np.flatnonzero(self.roles == PASSED)
        """Ids of the geoms that the rays pass through at every pose; `start_at` adds the geoms that contain every origin."""
        weld = model.body_weldid
        rigid = weld[bodies] == weld[body]
        self._rigid = np.flatnonzero((self.roles == VISIBLE) & rigid)
        self._moving = np.flatnonzero((self.roles == VISIBLE) & ~rigid)

    def start_at(self, origin: Floats) -> None:
        """Update `roles` for rays that start at a point (m, world frame): they pass through the colliders that contain it.

        The colliders that cannot move relative to the sensor are tested only in the first call.
        """
        if len(self._rigid):
            self.roles[self._containing(self._rigid, origin)] = PASSED
            self._rigid, self.always_passed = self._rigid[:0], np.flatnonzero(self.roles == PASSED)
        if len(self._moving):
            self.roles[self._moving] = VISIBLE
            self.roles[self._containing(self._moving, origin)] = PASSED

    def _containing(self, geoms: Indices, origin: Floats) -> list[int]:
        away = self._data.geom_xpos[geoms] - origin
        near = geoms[np.einsum("gi,gi->g", away, away) <= self._model.geom_rbound[geoms] ** 2]
        return [geom for geom in near.tolist() if contains(self._model, self._data, geom, origin)]


def own_colliders(
    model: mujoco.MjModel, data: mujoco.MjData, sees_own_robots: bool, prim: Prim, body: int, near: float
) -> OwnColliders:
    """Return the colliders of the robot that carries a sensor.

    Args:
        model: model with the robot.
        data: state of the simulation.
        sees_own_robots: whether sensors without `sees_own_robot` in the facts of their prim see their robot.
        prim: prim of the sensor.
        body: body that carries the sensor.
        near: least distance of the sensor, m.
    """
    tree = int(model.body_rootid[body])
    sees = prim.facts.get("sees_own_robot")
    if not (sees_own_robots if sees is None else sees):
        return OwnColliders(model, data, tree)
    ancestors = list(prim.ancestors())
    link = next((above for above in ancestors if above.kind == "link"), None)
    robot = next((above for above in ancestors if above.kind == "robot"), None)
    names = [housing_of(above) for above in itertools.takewhile(lambda above: above is not link, ancestors)]
    names += [link.body] if link is not None and link.body is not None else []
    names += [f"{robot.entity_name}/{link}" for link in prim.facts.get("ignores", ())] if robot is not None else []
    ids = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) for name in names]
    return OwnColliders(model, data, tree, body=body, passed=np.array(ids, np.intp), near=near)


def contains(model: mujoco.MjModel, data: mujoco.MjData, geom: int, point: Floats) -> bool:
    """Return whether a geom contains a point of the world frame, m. A plane or an open surface contains nothing."""
    x, y, z = local = data.geom_xmat[geom].reshape(3, 3).T @ (point - data.geom_xpos[geom])
    kind, (a, b, c) = model.geom_type[geom], model.geom_size[geom].tolist()
    if kind == _GEOM.mjGEOM_SPHERE:
        return bool(local @ local < a * a)
    if kind == _GEOM.mjGEOM_ELLIPSOID:
        return bool((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2 < 1.0)
    if kind == _GEOM.mjGEOM_BOX:
        return bool(abs(x) < a and abs(y) < b and abs(z) < c)
    if kind == _GEOM.mjGEOM_CYLINDER:
        return bool(x * x + y * y < a * a and abs(z) < b)
    if kind == _GEOM.mjGEOM_CAPSULE:
        return bool(x * x + y * y + max(abs(z) - b, 0.0) ** 2 < a * a)
    triangles = triangles_of(model, geom)
    return triangles is not None and _winds_round(triangles, local)


def _winds_round(triangles: Floats, point: Floats) -> bool:
    """Return whether triangles, shape (n, 3, 3), surround a point: their solid angles sum up to more than half of all directions.

    The sum is exact for closed surfaces, and robust against holes and inverted meshes.
    """
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    x, y, z = (np.linalg.norm(corner, axis=1) for corner in (a, b, c))
    volume = np.einsum("ni,ni->n", a, np.cross(b, c))
    dots = [np.einsum("ni,ni->n", one, other) for one, other in ((a, b), (b, c), (c, a))]
    halves = np.arctan2(volume, x * y * z + dots[0] * z + dots[1] * x + dots[2] * y)
    return abs(float(halves.sum())) > np.pi
