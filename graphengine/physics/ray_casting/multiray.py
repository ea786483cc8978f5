"""Ray casting with `mj_multiRay`. This function tests every geom for every ray.

Its argument `bodyexclude` excludes only a single body. So during a cast, the geoms that the rays pass through are moved to a
separate geom group. Rays that hit a collider of the sensor's own robot nearer than the sensor's least distance are cast again
without this collider. If all rays are in one plane, the plane intersects only a part of the world. Then rays are cast into a
small model of this part (`plane_culling`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import OWN, Floats, Indices, mujoco
from graphengine.physics.ray_casting.casters import GROUPS_SEEN, Integers, visible_geoms
from graphengine.physics.ray_casting.own_colliders import PASSED, VISIBLE, OwnColliders
from graphengine.physics.ray_casting.plane_culling import PlaneSlice


class MultiRays:
    """Ray casting by MuJoCo; implements `casters.Rays`."""

    name = "mujoco"

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data

    def caster(self, directions: Floats, far: float, own: OwnColliders) -> MultiRayCaster:
        """Return a caster for the rays of a sensor; see `Rays.caster`."""
        return MultiRayCaster(self._model, self._data, directions, far, own)


class MultiRayCaster:
    """Casts the rays of one sensor by MuJoCo; implements `casters.Caster`."""

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, directions: Floats, far: float, own: OwnColliders
    ) -> None:
        self._model, self._data = model, data
        self._directions, self._far = directions, far
        self._own = own
        self._visible = visible_geoms(model)
        self._slice: PlaneSlice | None = None
        self._sliceable = not directions[:, 2].any()
        self._rays = np.empty_like(directions)
        self._distances = np.empty(len(directions))
        self._geoms = np.empty(len(directions), np.int32)

    def cast(self, origin: Floats, rotation: Floats) -> tuple[Floats, Integers]:
        """Return distance (m) and geom id of the first hit of each ray; see `Caster.cast`."""
        np.matmul(self._directions, rotation.T, out=self._rays)
        self._own.start_at(origin)
        part = self._slice_at(origin, rotation[:, 2])
        passed = np.flatnonzero(self._own.roles == PASSED)
        if part is None:
            self._cast_into_all(origin, self._rays, passed, self._distances, self._geoms)
        else:
            part.refresh(self._data)
            rays, hits = self._rays.reshape(-1), (self._geoms, self._distances, None, len(self._rays), self._far)
            mujoco.mj_multiRay(part.model, part.data, origin, rays, None, True, -1, *hits)
            self._geoms[:] = part.geoms[self._geoms]  # of misses anything: they are not looked up
        if self._own.seen:
            self._pass_through_own(origin, passed)
        return self._distances, self._geoms

    def _slice_at(self, origin: Floats, normal: Floats) -> PlaneSlice | None:
        """Return a small model with all geoms that rays can hit from this pose; None if the whole model must be used."""
        if self._slice is None and self._sliceable:
            seen: list[int] = np.setdiff1d(self._visible, self._own.always_passed).tolist()
            self._sliceable = PlaneSlice.serves(self._model, seen)
            if self._sliceable:
                self._slice = PlaneSlice(self._model, self._data, seen, origin, normal)
        return self._slice if self._slice is not None and self._slice.covers(origin, normal) else None

    def _pass_through_own(self, origin: Floats, passed: Indices) -> None:
        """Cast the rays that hit own colliders which they pass through again without these colliders."""
        roles, near = self._own.roles, self._own.near
        pending = [(np.arange(len(self._rays)), passed)]
        while pending:
            rays, without = pending.pop()
            distances, geoms = self._distances[rays], self._geoms[rays]
            of = roles[np.where(distances >= 0.0, geoms, 0)]
            through = (distances >= 0.0) & ((of == PASSED) | ((of == VISIBLE) & (distances < near)))
            for geom in np.unique(geoms[through]):
                again, more = rays[through & (geoms == geom)], np.append(without, geom)
                found, met = np.empty(len(again)), np.empty(len(again), np.int32)
                self._cast_into_all(origin, self._rays[again], more, found, met)
                self._distances[again], self._geoms[again] = found, met
                pending.append((again, more))

    def _cast_into_all(
        self, origin: Floats, rays: Floats, passed: Indices, distances: Floats, geoms: NDArray[np.int32]
    ) -> None:
        """Cast rays into the whole model, through the geoms `passed`."""
        groups = self._model.geom_group[passed]
        self._model.geom_group[passed] = OWN
        try:
            hits = geoms, distances, None, len(rays), self._far
            mujoco.mj_multiRay(self._model, self._data, origin, rays.reshape(-1), GROUPS_SEEN, True, -1, *hits)
        finally:
            self._model.geom_group[passed] = groups
