"""A lidar that casts rays into the collision geometry.

A sample (`sampling`) is cast when somebody first asks in its tick, and what is cast does not depend on who asks. What rays meet
is the business of `rays`.

Intensity is the relative luminance of the surface's colour, 0 to 255, whatever its distance and however slanted it is, as of a
sensor that makes up for both. It knows the colour of a geom or of its material; textures, reflectance and shininess do not count.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from graphengine.devices.sensor import Quaternion, Scan, beam_directions
from graphengine.devices.stage import Prim
from graphengine.physics.dynamics.handles import CarriedPrim
from graphengine.physics.sensors.rays import geom_colours
from graphengine.physics.sensors.sampling import Sampled, Sampling

if TYPE_CHECKING:
    from graphengine.physics.core import SimulationCore

Floats = NDArray[np.float64]

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class RayLidar(Sampled):
    """The ray-casting sensor at a lidar prim, whose facts are its profile."""

    kept = ("_newest",)

    def __init__(self, simulation: SimulationCore, prim: Prim) -> None:
        facts = prim.facts
        self.rate: float = facts["rate"]
        self.angles: tuple[float, float, float] = facts["angles"]
        self.elevations: Floats = np.array(facts.get("elevations", (0.0,)), float)
        self.ranges: tuple[float, float] = facts["ranges"]
        self.directions = beam_directions(self.angles, self.elevations)
        self.elevations.flags.writeable = self.directions.flags.writeable = False
        self._sampling = Sampling(self.rate, simulation.tick_period, simulation.seed, prim.path)
        self._noise: float = facts.get("noise_std", 0.0)
        self._resolution: float = facts.get("resolution", 0.0)
        self._newest: Scan | None = None
        self._mount = CarriedPrim(simulation, prim)
        super().__init__(simulation, prim)

    def bind(self) -> None:
        """Find the sensor's own robot, which its rays pass through, and how bright all geoms are."""
        self._mount.bind()
        model = self._simulation.model
        tree = int(model.body_rootid[self._mount.body])
        self._caster = self._simulation.rays.caster(self.directions, self.ranges[1], tree)
        brightness = 255 * (geom_colours(model)[:, :3] @ _LUMINANCE)
        self._brightness = np.append(brightness, 0.0).astype(np.float32)  # a miss has the number -1

    def reset(self) -> None:
        """Forget the newest sample."""
        self._newest = None

    def scan(self) -> Scan:
        """The newest sample, cast when first asked for in its tick and shared by all who ask.

        If nobody asked then, what is cast now has the sample's number and this tick's time, and is not kept.
        """
        index = self.index
        if self._newest is not None and self._newest.index == index:
            return self._newest
        scan = self._cast(index)
        if self.due:
            self._newest = scan
        return scan

    def _cast(self, index: int) -> Scan:
        near, far = self.ranges
        position, rotation = self._mount.pose()
        distances, geoms = self._caster.cast(np.array(position), _matrix(rotation))
        hit = (distances >= near) & (distances <= far)
        if self._noise:
            distances = distances + self._sampling.random(index).normal(0.0, self._noise, len(distances))
        if self._resolution:
            distances = np.round(distances / self._resolution) * self._resolution
        if self._noise or self._resolution:
            distances = np.clip(distances, near, far)
        ranges = np.where(hit, distances, np.inf).astype(np.float32)
        intensities = np.where(hit, self._brightness[geoms], np.float32(0))
        return Scan(self._simulation.time, index, ranges, intensities)


def _matrix(rotation: Quaternion) -> Floats:
    """Rotation matrix of a unit quaternion (x, y, z, w)."""
    x, y, z, w = rotation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
