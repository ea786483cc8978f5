"""The lidar, and the base class of sensors that sample by casting rays into the collision geometry.

The rays of a sample (see `sampling`) are cast when the sample is first requested in its tick; all callers get the same sample.
The module `rays` finds the surfaces that the rays hit.

The intensity of a hit is the relative luminance of the surface's colour, 0 to 255. It is independent of distance and angle, as
for a sensor that compensates for both. The colour is that of the geom's material, or of the geom itself; textures, reflectance
and shininess are ignored.
"""

from __future__ import annotations

import itertools
import math
from typing import Annotated, Any

import numpy as np
from pydantic import Field, model_validator

from graphengine.descriptions.engine import Floats
from graphengine.descriptions.geoms import geom_colours
from graphengine.devices.lidar import Lidar, Scan, beam_directions
from graphengine.format.spec import NotNegative, Positive, Spec
from graphengine.physics.implementations import Deviation, Profile, Rate, check_less, implements
from graphengine.physics.ray_casting.casters import Integers
from graphengine.physics.ray_casting.own_colliders import own_colliders
from graphengine.physics.sensors.sampling import S, TickSampled

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
MAX_BEAMS = 500_000
"""Maximum number of beams of a lidar, in all rings."""
Elevation = Annotated[float, Field(ge=-90, le=90)]


class BeamsSpec(Spec):
    """Evenly spaced beams of a ring; their angles are counter-clockwise from the sensor's x axis."""

    first_deg: float = Field(ge=-360, le=360)
    """Azimuth of the first beam, degrees."""
    last_deg: float = Field(ge=-360, le=360)
    """Azimuth of the last beam, degrees."""
    count: int = Field(ge=2, le=MAX_BEAMS)
    """Number of beams of a ring."""

    @model_validator(mode="after")
    def _once_around(self) -> BeamsSpec:
        if not 0.0 < self.last_deg - self.first_deg <= 360.0:
            raise ValueError("beams go counter-clockwise: last_deg must be greater than first_deg, by at most 360")
        return self


class RingsSpec(Spec):
    """Rings of a 3D lidar from the lowest to the highest; either evenly spaced or listed."""

    first_deg: Elevation | None = None
    """Elevation of the lowest ring, degrees."""
    last_deg: Elevation | None = None
    """Elevation of the highest ring, degrees."""
    count: int | None = Field(default=None, ge=2, le=1024)
    """Number of rings."""
    each_deg: Annotated[tuple[Elevation, ...], Field(strict=False, min_length=1, max_length=1024)] | None = None
    """Angle of each ring above the sensor's xy plane, degrees; replaces first_deg, last_deg and count."""

    @model_validator(mode="after")
    def _upwards(self) -> RingsSpec:
        spaced = (self.first_deg, self.last_deg, self.count)
        if (self.each_deg is None) == (spaced == (None, None, None)) or (self.each_deg is None and None in spaced):
            raise ValueError("define rings either by first_deg, last_deg and count, or by each_deg")
        angles = self.each_deg or (self.first_deg, self.last_deg)
        if any(not low < high for low, high in itertools.pairwise(angles)):  # type: ignore[operator]
            raise ValueError("rings must be in ascending order")
        return self

    @property
    def degrees(self) -> tuple[float, ...]:
        """Angle of each ring above the sensor's xy plane, degrees."""
        if self.first_deg is None or self.last_deg is None or self.count is None:
            return self.each_deg or ()
        step = (self.last_deg - self.first_deg) / (self.count - 1)
        return tuple(self.first_deg + step * ring for ring in range(self.count))


def check_distances(resolution: float, **bounds: float) -> None:
    """Check the resolution of a sensor (m), and its nearest and farthest distance (m).

    Args:
        resolution: multiple to which distances are rounded, m; 0 for no rounding.
        bounds: nearest and farthest distance, under the names that messages use.

    Raises:
        ValueError: the nearest distance is not less than the farthest, or the resolution is too fine or too coarse.
    """
    check_less(**bounds)
    _, (farthest, far) = bounds.items()
    if resolution and not 1e-6 <= resolution < far:
        raise ValueError(f"resolution must be 0, or at least one micrometre and less than {farthest}")


class LidarProfile(Profile):
    """The parameters of a lidar."""

    casts_rays = True

    rate: Rate
    """Sweeps per second."""
    beams: BeamsSpec
    """Beams of a ring, as {first_deg: -90, last_deg: 90, count: 181}."""
    rings: RingsSpec | None = None
    """Rings of a 3D sensor; without this key, the sensor has one ring in its xy plane."""
    near: NotNegative
    """Nearest distance reported, m."""
    far: Positive = Field(le=1_000_000)
    """Farthest distance reported, m."""
    noise_std: Deviation = 0.0
    """Standard deviation of distance noise, m."""
    resolution: NotNegative = 0.0
    """Distances are rounded to multiples of this value, m; with 0, they are not rounded."""

    @model_validator(mode="after")
    def _in_bounds(self) -> LidarProfile:
        check_distances(self.resolution, near=self.near, far=self.far)
        rings = len(self.elevations)
        if rings * self.beams.count > MAX_BEAMS:
            text = f"{rings} rings of {self.beams.count} beams are too many"
            raise ValueError(f"{text}: at most {MAX_BEAMS} beams in all")
        return self

    @property
    def angles(self) -> tuple[float, float, float]:
        """Azimuths of the first and last beam of a ring, and the angle between two neighbouring beams, rad."""
        first, last = math.radians(self.beams.first_deg), math.radians(self.beams.last_deg)
        return first, last, (last - first) / (self.beams.count - 1)

    @property
    def elevations(self) -> tuple[float, ...]:
        """Angle of each ring above the sensor's xy plane, rad."""
        return tuple(map(math.radians, self.rings.degrees)) if self.rings is not None else (0.0,)

    def facts(self) -> dict[str, Any]:
        """Return the values for the `facts` of a prim, with angles in rad."""
        kept = self.model_dump(include={"rate", "noise_std", "resolution"})
        return kept | {"angles": self.angles, "elevations": self.elevations, "ranges": (self.near, self.far)}


class RaySensor(TickSampled[S]):
    """Base class of sensors that sample by casting rays.

    The `facts` of the sensor's prim contain `ranges`, and may contain `noise_std` and `resolution`. A subclass sets `directions`
    in `_set_up`, and makes a sample in `_make_sample`.
    """

    casts_rays = True

    directions: Floats

    def _set_up(self) -> None:
        self.ranges: tuple[float, float] = self._prim.facts["ranges"]
        self.noise_std: float = self._prim.facts.get("noise_std", 0.0)
        self._resolution: float = self._prim.facts.get("resolution", 0.0)
        super()._set_up()

    def bind(self) -> None:
        """Look up the body that carries the sensor, and create the caster."""
        super().bind()
        world = self._simulation
        own = own_colliders(world.model, world.data, world.sees_own_robots, self._prim, self.body, self.ranges[0])
        self._caster = world.rays.caster(self.directions, self.ranges[1], own)

    def cast(self) -> tuple[Floats, Integers]:
        """Return distance (m) and geom id of the first hit of each ray; see `casters.Caster.cast`."""
        return self._caster.cast(*self.frame())

    def _measured(self, distances: Floats, index: int) -> Floats:
        """Return distances with the noise of a sample, rounded to the resolution and clamped to the sensor's range.

        A sensor without noise and resolution gets the distances unchanged.
        """
        if self.noise_std:
            distances = distances + self._noise_of(index).normal(0.0, self.noise_std, len(distances))
        distances = rounded(distances, self._resolution)
        return np.clip(distances, *self.ranges) if self.noise_std or self._resolution else distances


def rounded(values: Floats, resolution: float) -> Floats:
    """Return values rounded to multiples of a resolution; with a resolution of 0, return them unchanged."""
    return np.round(values / resolution) * resolution if resolution else values


@implements(Lidar, LidarProfile)
class RayLidar(RaySensor[Scan]):
    """The lidar at a prim; the prim's `facts` are the values of the lidar's profile."""

    def _set_up(self) -> None:
        self.angles: tuple[float, float, float] = self._prim.facts["angles"]
        self.elevations: Floats = np.array(self._prim.facts.get("elevations", (0.0,)), float)
        self.directions = beam_directions(self.angles, self.elevations)
        self.elevations.flags.writeable = self.directions.flags.writeable = False
        super()._set_up()

    def bind(self) -> None:
        """Create the caster, and compute the intensity of a hit on each geom."""
        super().bind()
        brightness = 255 * (geom_colours(self._simulation.model)[:, :3] @ _LUMINANCE)
        self._brightness = np.append(brightness, 0.0).astype(np.float32)  # a miss has the number -1

    def scan(self) -> Scan:
        """Return the newest sample; all callers get the same object."""
        return self.reading()

    def _make_sample(self, index: int) -> Scan:
        near, far = self.ranges
        distances, geoms = self.cast()
        missed = (distances < near) | (distances > far)
        ranges = self._measured(distances, index).astype(np.float32)
        intensities = self._brightness.take(geoms)
        np.copyto(ranges, np.inf, where=missed)
        np.copyto(intensities, 0.0, where=missed)
        return Scan(self._simulation.time, index, ranges, intensities, self.directions)
