"""The radar: casts rays into the collision geometry, and measures distance and radial velocity of the points that they hit.

Its rays hit the same geoms as the rays of a lidar. Every hit in range is one detection. The radial velocity is that of the
surface point relative to the radar, along the ray.

The noise model is this project's own: independent normal errors of distance, radial velocity and angles. It is not that of a
data sheet or of Isaac Sim's RTX radar; multipath, clutter, ambiguity and the radar cross-section of materials are not
simulated. The intensity follows the radar equation, in which power falls with the fourth power of the distance.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphengine.descriptions.engine import Floats
from graphengine.devices.lidar import beam_directions
from graphengine.devices.radar import Detections, Radar
from graphengine.format.spec import NotNegative
from graphengine.physics.implementations import Deviation, implements
from graphengine.physics.ray_casting.casters import Integers
from graphengine.physics.sensors.lidar import LidarProfile, RaySensor, rounded

_NEAREST = 1e-3
"""Distance below which the received power no longer grows, m."""


class RadarProfile(LidarProfile):
    """The parameters of a radar: its rays, described by beams and rings as for a lidar, and its errors."""

    velocity_std: Deviation = 0.0
    """Standard deviation of radial velocity noise, m/s."""
    angle_std_deg: float = Field(default=0.0, ge=0.0, le=45.0)
    """Standard deviation of azimuth and elevation noise, degrees."""
    velocity_resolution: NotNegative = 0.0
    """Radial velocities are rounded to multiples of this value, m/s; with 0, they are not rounded."""

    def facts(self) -> dict[str, Any]:
        """Return the values for the `facts` of a prim, with angles in rad."""
        kept = self.model_dump(include={"velocity_std", "velocity_resolution"})
        return super().facts() | kept | {"angle_std": math.radians(self.angle_std_deg)}


@implements(Radar, RadarProfile)
class RayRadar(RaySensor[Detections]):
    """The radar at a prim; the prim's `facts` are the values of the radar's profile."""

    def _set_up(self) -> None:
        facts = self._prim.facts
        self.directions = beam_directions(facts["angles"], np.array(facts["elevations"], float))
        self.directions.flags.writeable = False
        super()._set_up()

    def detections(self) -> Detections:
        """Return the newest sample; all callers get the same object."""
        return self.reading()

    def _make_sample(self, index: int) -> Detections:
        (near, far), facts = self.ranges, self._prim.facts
        distances, geoms = self.cast()
        hit = np.flatnonzero((distances >= near) & (distances <= far))
        distances, directions = distances[hit], self.directions[hit]
        velocities = self._radial_velocities(geoms[hit], directions, distances)
        # One error per ray, hit or not, so that a detection does not depend on the other rays.
        errors = self._noise_of(index).standard_normal((4, len(self.directions)))[:, hit]
        measured = rounded(distances + self.noise_std * errors[0], self._resolution).clip(near, far)
        velocities = rounded(velocities + facts["velocity_std"] * errors[1], facts["velocity_resolution"])
        points = measured[:, None] * _turned(directions, *(facts["angle_std"] * errors[2:]))
        power = 40.0 * np.log10(far / np.maximum(distances, _NEAREST))
        arrays = (array.astype(np.float32) for array in (points, velocities, power))
        return Detections(self._simulation.time, index, *arrays)

    def _radial_velocities(self, geoms: Integers, directions: Floats, distances: Floats) -> Floats:
        """Return the rate of change of the distance to the surface point that each ray hits, m/s.

        Args:
            geoms: id of the geom that each ray hits.
            directions: unit vectors of the rays in the radar's frame.
            distances: distances along the rays, m.
        """
        model, data = self._simulation.model, self._simulation.data
        (position, rotation), (own, _) = self.frame(), self.velocity()
        along = directions @ rotation.T
        bodies = model.geom_bodyid[geoms]
        # Velocities are about the centre of mass of a body's whole tree.
        arms = np.add(position, along * distances[:, None]) - data.subtree_com[model.body_rootid[bodies]]
        turning, moving = np.hsplit(data.cvel[bodies], 2)
        surface = moving + np.cross(turning, arms)
        rates: Floats = np.sum((surface - own) * along, axis=1)
        return rates


def _turned(directions: Floats, azimuths: Floats, elevations: Floats) -> NDArray[np.float64]:
    """Return unit vectors after adding angles (rad) to their azimuths and elevations."""
    azimuth = np.arctan2(directions[:, 1], directions[:, 0]) + azimuths
    elevation = np.arcsin(directions[:, 2].clip(-1.0, 1.0)) + elevations
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=1)
