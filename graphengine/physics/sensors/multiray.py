"""Ray casting with `mj_multiRay`, which tests every geom for every ray.

Its argument `bodyexclude` excludes only a single body. So during a cast, the geoms of the sensor's own robot are moved to a
separate geom group. If all rays are in one plane, which intersects only a part of the world, they are cast into a small model of
that part (`plane_culling`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from graphengine.physics.engine import OWN, Floats, mujoco
from graphengine.physics.sensors.plane_culling import PlaneSlice
from graphengine.physics.sensors.rays import GROUPS_SEEN, Integers, own_geoms, visible_geoms


class MultiRays:
    """Ray casting by MuJoCo; implements `sensors.rays.Rays`."""

    name = "mujoco"

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data

    def caster(self, directions: Floats, far: float, tree: int) -> MultiRayCaster:
        """Return a caster for the rays of a sensor; see `Rays.caster`."""
        return MultiRayCaster(self._model, self._data, directions, far, tree)


class MultiRayCaster:
    """Casts the rays of one sensor by MuJoCo; implements `sensors.rays.Caster`."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, directions: Floats, far: float, tree: int) -> None:
        self._model, self._data = model, data
        self._directions, self._far = directions, far
        self._own = own_geoms(model, tree)
        self._visible: list[int] = np.setdiff1d(visible_geoms(model), self._own).tolist()
        self._sliceable = not directions[:, 2].any() and PlaneSlice.serves(model, self._visible)
        self._slice: PlaneSlice | None = None
        self._rays = np.empty_like(directions)
        self._distances = np.empty(len(directions))
        self._geoms = np.empty(len(directions), np.int32)

    def cast(self, origin: Floats, rotation: Floats) -> tuple[Floats, Integers]:
        """Return distance (m) and geom id of the first hit of each ray; see `Caster.cast`."""
        np.matmul(self._directions, rotation.T, out=self._rays)
        part = self._slice_at(origin, rotation[:, 2])
        if part is None:
            self._cast_into_all(origin)
        else:
            part.refresh(self._data)
            self._multi_ray(part.model, part.data, origin, None)
            self._geoms[:] = part.geoms[self._geoms]  # of misses anything: they are not looked up
        return self._distances, self._geoms

    def _slice_at(self, origin: Floats, normal: Floats) -> PlaneSlice | None:
        """Return a small model with all geoms that rays can hit from this pose; None if the whole model must be used."""
        if self._slice is None and self._sliceable:
            self._slice = PlaneSlice(self._model, self._data, self._visible, origin, normal)
        return self._slice if self._slice is not None and self._slice.covers(origin, normal) else None

    def _cast_into_all(self, origin: Floats) -> None:
        groups = self._model.geom_group[self._own]
        self._model.geom_group[self._own] = OWN
        try:
            self._multi_ray(self._model, self._data, origin, GROUPS_SEEN)
        finally:
            self._model.geom_group[self._own] = groups

    def _multi_ray(
        self, model: mujoco.MjModel, data: mujoco.MjData, origin: Floats, groups: NDArray[np.uint8] | None
    ) -> None:
        rays, count = self._rays.reshape(-1), len(self._rays)
        distances, geoms = self._distances, self._geoms
        mujoco.mj_multiRay(model, data, origin, rays, groups, True, -1, geoms, distances, None, count, self._far)
