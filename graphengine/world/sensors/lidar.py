"""A lidar that casts rays into the collision geometry.

A sample (`sampling`) is cast when somebody first asks in its tick, and what is cast does not depend on who asks.

Rays meet what collides, and of a body without colliders what is drawn (`engine.sort_geoms`). The sensor's own robot is put
into a geom group of its own for the time of a cast, as `bodyexclude` takes out a single body and a robot has many. Where the
plane of the beams meets only a part of the world, they are cast into that part (`slice`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graphengine.context import Scan
from graphengine.stage import Prim
from graphengine.world.engine import OWN, RAYS, RAYS_AND_PICTURES, mujoco
from graphengine.world.handles import CarriedPrim, Handle
from graphengine.world.sensors.sampling import Sampling
from graphengine.world.sensors.slice import PlaneSlice

if TYPE_CHECKING:
    from graphengine.world.simulation import Simulation

Floats = NDArray[np.float64]

_SEEN = np.array([group in (RAYS_AND_PICTURES, RAYS) for group in range(6)], np.uint8)
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class RayLidar(Handle):
    """The ray-casting sensor at a lidar prim, whose facts are its profile."""

    def __init__(self, simulation: Simulation, prim: Prim) -> None:
        facts = prim.facts
        self.rate: float = facts["rate"]
        self.angles: tuple[float, float, float] = facts["angles"]
        self.ranges: tuple[float, float] = facts["ranges"]
        first, last, increment = self.angles
        beams = round((last - first) / increment) + 1
        azimuth = first + increment * np.arange(beams)
        self.directions = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(beams)], axis=1)
        self.directions.flags.writeable = False
        self._sampling = Sampling(self.rate, simulation.tick_period, simulation.seed, prim.path)
        self._noise: float = facts.get("noise_std", 0.0)
        self._rays = np.empty((beams, 3))
        self._distances = np.empty(beams)
        self._geoms = np.empty(beams, np.int32)
        self._newest: Scan | None = None
        self._mount = CarriedPrim(simulation, prim)
        super().__init__(simulation, prim)

    def bind(self) -> None:
        """Find the geoms of the sensor's own robot, and how bright all are."""
        self._mount.bind()
        model = self._simulation.model
        tree = model.body_rootid[self._mount.body]
        self._own = np.flatnonzero(model.body_rootid[model.geom_bodyid] == tree) if tree else np.empty(0, np.intp)
        colours = np.where((model.geom_matid < 0)[:, None], model.geom_rgba, _material_colours(model))
        visible = (_SEEN[model.geom_group] > 0) & (colours[:, 3] > 0)  # rays pass through what is wholly transparent
        visible[self._own] = False
        self._visible = np.flatnonzero(visible).tolist()
        self._slice: PlaneSlice | None = None
        self._brightness = (255 * (colours[:, :3] @ _LUMINANCE)).astype(np.float32)

    def reset(self) -> None:
        """Forget the newest sample."""
        self._newest = None

    @property
    def due(self) -> bool:
        """Whether a new sample falls into this tick; the first tick has one."""
        return self._sampling.due(self._simulation.tick)

    def scan(self) -> Scan:
        """The newest sample, cast when first asked for in its tick and shared by all who ask.

        If nobody asked then, what is cast now has the sample's number and this tick's time, and is not kept.
        """
        index = self._sampling.newest(self._simulation.tick)
        if self._newest is not None and self._newest.index == index:
            return self._newest
        scan = self._cast(index)
        if self.due:
            self._newest = scan
        return scan

    def _cast(self, index: int) -> Scan:
        near, far = self.ranges
        position, rotation = self._mount.pose()
        matrix, origin = _matrix(rotation), np.array(position)
        np.matmul(self.directions, matrix.T, out=self._rays)
        part = self._slice_at(origin, matrix[:, 2])
        if part is None:
            self._cast_into_all(origin, far)
        else:
            part.refresh(self._simulation.data)
            self._multi_ray(part.model, part.data, origin, None, far)
            self._geoms[:] = part.geoms[self._geoms]  # of misses anything: they are not looked up
        hit = (self._distances >= near) & (self._distances <= far)
        distances = self._distances
        if self._noise:
            generator = self._sampling.random(index)
            distances = np.clip(distances + generator.normal(0.0, self._noise, len(distances)), near, far)
        ranges = np.where(hit, distances, np.inf).astype(np.float32)
        intensities = np.where(hit, self._brightness[self._geoms], np.float32(0))
        return Scan(self._simulation.time, index, ranges, intensities)

    def _slice_at(self, origin: Floats, normal: Floats) -> PlaneSlice | None:
        """The part of the world that holds all that the rays can meet; None where only the whole world does."""
        if self._slice is None and PlaneSlice.serves(self._simulation.model, self._visible):
            self._slice = PlaneSlice(self._simulation.model, self._simulation.data, self._visible, origin, normal)
        return self._slice if self._slice is not None and self._slice.covers(origin, normal) else None

    def _cast_into_all(self, origin: Floats, far: float) -> None:
        model = self._simulation.model
        groups = model.geom_group[self._own]
        model.geom_group[self._own] = OWN
        try:
            self._multi_ray(model, self._simulation.data, origin, _SEEN, far)
        finally:
            model.geom_group[self._own] = groups

    def _multi_ray(
        self, model: mujoco.MjModel, data: mujoco.MjData, origin: Floats, groups: NDArray[np.uint8] | None, far: float
    ) -> None:
        rays, count = self._rays.reshape(-1), len(self._rays)
        mujoco.mj_multiRay(model, data, origin, rays, groups, True, -1, self._geoms, self._distances, None, count, far)


def _matrix(rotation: tuple[float, float, float, float]) -> NDArray[np.float64]:
    """Rotation matrix of a unit quaternion (x, y, z, w)."""
    x, y, z, w = rotation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _material_colours(model: mujoco.MjModel) -> NDArray[np.float32]:
    """For each geom the colour of its material, or of any where it has none."""
    colours: NDArray[np.float32] = model.mat_rgba[model.geom_matid] if model.nmat else model.geom_rgba
    return colours
