"""A range sensor that casts a cone of rays and measures the smallest distance.

The rays hit the same geoms as the rays of a lidar. They form rings around the sensor's x axis; the outermost ring is the edge of
the cone. Objects between two rings are not detected. The sensor detects a surface even if it does not reflect towards the sensor,
unlike real ultrasonic sensors.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from pydantic import Field, model_validator

from graphengine.descriptions.engine import Floats
from graphengine.devices.range import RangeReading, RangeSensor
from graphengine.format.spec import NotNegative, Positive
from graphengine.physics.implementations import Deviation, Profile, Rate, implements
from graphengine.physics.sensors.lidar import RaySensor, check_distances


class RangeProfile(Profile):
    """The parameters of an ultrasonic or infrared range sensor."""

    casts_rays = True

    radiation_type: Literal["ultrasound", "infrared"] = "ultrasound"
    """Kind of radiation that messages name."""
    rate: Rate
    """Measurements per second."""
    field_of_view: float = Field(gt=0.0, le=math.pi)
    """Angle from edge to edge of the cone, rad."""
    rings: int = Field(default=4, ge=1, le=32)
    """Number of rings of rays around the axis; ring n has 6 n rays."""
    min_range: NotNegative
    """Nearest distance measured, m; a closer object gives a reading of -inf."""
    max_range: Positive = Field(le=1_000_000)
    """Farthest distance measured, m; without a hit, the reading is inf."""
    noise_std: Deviation = 0.0
    """Standard deviation of distance noise, m."""
    resolution: NotNegative = 0.0
    """Distances are rounded to multiples of this value, m; with 0, they are not rounded."""

    @model_validator(mode="after")
    def _in_bounds(self) -> RangeProfile:
        check_distances(self.resolution, min_range=self.min_range, max_range=self.max_range)
        return self

    def facts(self) -> dict[str, Any]:
        """Return the values for the `facts` of a prim; `ranges` contains both `min_range` and `max_range`."""
        return self.model_dump(exclude={"min_range", "max_range"}) | {"ranges": (self.min_range, self.max_range)}


@implements(RangeSensor, RangeProfile)
class RayCone(RaySensor[RangeReading]):
    """The range sensor at a prim; the prim's `facts` are the values of its profile."""

    def _set_up(self) -> None:
        self.radiation_type: str = self._prim.facts["radiation_type"]
        self.field_of_view: float = self._prim.facts["field_of_view"]
        self.directions = cone_directions(self.field_of_view, self._prim.facts["rings"])
        super()._set_up()

    def _make_sample(self, index: int) -> RangeReading:
        near, far = self.ranges
        distances, _ = self.cast()
        nearest = np.min(distances[distances >= 0.0], initial=math.inf, keepdims=True)
        distance = float(self._measured(nearest, index)[0])
        if not near <= nearest[0] <= far:
            distance = -math.inf if nearest[0] < near else math.inf
        return RangeReading(self._simulation.time, index, distance)


def cone_directions(field_of_view: float, rings: int) -> Floats:
    """Return unit vectors in a cone around the x axis, shape (n, 3): the axis, then rings at equal angles up to the cone's edge.

    Ring n has 6 n vectors.
    """
    ring = np.repeat(np.arange(rings + 1), np.maximum(6 * np.arange(rings + 1), 1))
    around = 2.0 * np.pi * np.concatenate([np.arange(max(6 * n, 1)) / max(6 * n, 1) for n in range(rings + 1)])
    away = field_of_view / 2.0 * ring / rings
    return np.stack([np.cos(away), np.sin(away) * np.cos(around), np.sin(away) * np.sin(around)], axis=1)
