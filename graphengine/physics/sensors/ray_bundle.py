"""Casts rays with individual origins and directions, and computes the normals of the surfaces that they hit.

Rays with the same origin are cast together. A ray starts at the least distance from its origin. If this starting point is inside
a body, the ray hits the body at this point, as in PhysX.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graphengine.descriptions.engine import Bools, Floats, Indices, mujoco
from graphengine.physics.handles.motion_handles import CarriedPrim
from graphengine.physics.ray_casting.casters import Caster
from graphengine.physics.ray_casting.own_colliders import own_colliders

_KINDS = mujoco.mjtGeom
_SOLIDS = [_KINDS.mjGEOM_PLANE, _KINDS.mjGEOM_SPHERE, _KINDS.mjGEOM_CAPSULE]
_SOLIDS += [_KINDS.mjGEOM_ELLIPSOID, _KINDS.mjGEOM_CYLINDER, _KINDS.mjGEOM_BOX]


class Hits(NamedTuple):
    """Hits of a bundle's rays, one entry per ray."""

    found: Bools
    """Whether each ray hits a surface within the range."""
    depths: Floats
    """Distance from each ray's origin to its hit, m; the greatest distance if there is no hit."""
    normals: Floats
    """Unit normal of each hit in the world frame, shape (n, 3); zero without a hit."""
    geoms: Indices
    """Id of the geom that each ray hits; -1 if there is no hit."""


class RayBundle(CarriedPrim):
    """Base class of sensors whose rays have individual origins and directions.

    The `facts` of the sensor's prim contain `min_range` and `max_range`. In `_set_up`, a subclass sets `_origins` (m) and
    `_directions` (unit vectors) in the sensor's frame, of shape (n, 3).
    """

    casts_rays = True

    _origins: Floats
    _directions: Floats

    def _set_up(self) -> None:
        self._ranges: tuple[float, float] = (self._prim.facts["min_range"], self._prim.facts["max_range"])

    def bind(self) -> None:
        """Look up the body that carries the sensor, and create the casters of its rays."""
        super().bind()
        places, group = np.unique(self._origins, axis=0, return_inverse=True)
        members = [np.flatnonzero(group.ravel() == number) for number in range(len(places))]
        self._groups = [(rays, self._caster(self._directions[rays], self._ranges[0])) for rays in members]
        self._single: dict[int, Caster] = {}
        """A dict from the index of a ray to a caster for this ray alone; used for rays with a hit nearer than the least
        distance."""

    def cast(self, position: Floats, rotation: Floats) -> Hits:
        """Cast all rays for a sensor's position (m) and rotation matrix in the world frame."""
        near, far = self._ranges
        count = len(self._origins)
        origins, directions = position + self._origins @ rotation.T, self._directions @ rotation.T
        begins, normals = origins.copy(), np.zeros((count, 3))
        depths, geoms = np.full(count, far), np.full(count, -1)
        for rays, caster in self._groups:
            distances, met = caster.cast(origins[rays[0]], rotation)
            depths[rays], geoms[rays] = distances, np.where(distances >= 0.0, met, -1)
        for ray in np.flatnonzero((geoms >= 0) & (depths < near)).tolist():
            if ray not in self._single:
                self._single[ray] = self._caster(self._directions[ray][None], 0.0)
            begins[ray] += near * directions[ray]
            (distance,), (geom,) = self._single[ray].cast(begins[ray], rotation)
            depths[ray], geoms[ray] = near + distance, geom if distance >= 0.0 else -1
        found = (geoms >= 0) & (depths <= far)
        depths[~found], geoms[~found] = far, -1
        for ray in np.flatnonzero(found).tolist():
            normal = self._normal(int(geoms[ray]), begins[ray], directions[ray])
            if normal @ directions[ray] > 0.0:  # the ray leaves a body inside which it starts
                depths[ray], normal = near, -directions[ray]
            normals[ray] = normal
        return Hits(found, depths, normals, geoms)

    def _caster(self, directions: Floats, near: float) -> Caster:
        world = self._simulation
        own = own_colliders(world.model, world.data, world.sees_own_robots, self._prim, self.body, near)
        return world.rays.caster(directions, self._ranges[1], own)

    def _normal(self, geom: int, begin: Floats, direction: Floats) -> Floats:
        """Return a geom's outward unit normal where a ray hits it; for shapes without normals, the ray's reverse direction."""
        model, data, normal = self._simulation.model, self._simulation.data, -direction
        kind = int(model.geom_type[geom])
        if kind in _SOLIDS:
            place, axes = data.geom_xpos[geom], data.geom_xmat[geom]
            mujoco.mju_rayGeom(place, axes, model.geom_size[geom], begin, direction, kind, normal)
        elif kind == _KINDS.mjGEOM_MESH:
            mujoco.mj_rayMesh(model, data, geom, begin, direction, normal)
        elif kind == _KINDS.mjGEOM_HFIELD:
            mujoco.mj_rayHfield(model, data, geom, begin, direction, normal)
        return normal
