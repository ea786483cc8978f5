"""A light beam sensor: one beam or a curtain of parallel beams; the sensor detects which beams are broken.

The beams hit the same geoms as the beams of a lidar. They are cast when the sensor is read.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field, model_validator

from graphengine.devices.light_beam import BeamReading, LightBeam
from graphengine.format.spec import NotNegative, Positive, Vector
from graphengine.physics.implementations import Profile, check_less, implements
from graphengine.physics.sensors.ray_bundle import RayBundle


class LightBeamProfile(Profile):
    """The parameters of a light barrier (one beam) or a light curtain (several beams)."""

    casts_rays = True

    num_rays: int = Field(default=1, ge=1, le=10_000)
    """Number of beams."""
    curtain_length: NotNegative = Field(default=0.0, le=1000.0)
    """Length of a light curtain, m; of N beams, beam n (from 0) is at n / N of this length along curtain_axis."""
    forward_axis: Vector = (1.0, 0.0, 0.0)
    """Direction of the beams in the sensor's frame."""
    curtain_axis: Vector = (0.0, 0.0, 1.0)
    """Direction along which beams are placed, in the sensor's frame."""
    min_range: NotNegative = 0.4
    """Distance from a beam's origin at which the beam starts, m."""
    max_range: Positive = Field(default=100.0, le=1_000_000)
    """Distance from a beam's origin at which an unbroken beam ends, m."""

    @model_validator(mode="after")
    def _side_by_side(self) -> LightBeamProfile:
        check_less(min_range=self.min_range, max_range=self.max_range)
        if self.num_rays > 1 and not self.curtain_length:
            raise ValueError("several beams need a curtain_length greater than 0")
        for name in ("forward_axis", "curtain_axis"):
            if not math.hypot(*getattr(self, name)) > 0.0:
                raise ValueError(f"{name}: (0, 0, 0) is not a direction")
        return self


@implements(LightBeam, LightBeamProfile)
class LightCurtain(RayBundle):
    """The light beam sensor at a prim; the prim's `facts` are the values of its profile."""

    def _set_up(self) -> None:
        facts, count = self._prim.facts, self._prim.facts["num_rays"]
        forward, aside = (np.array(facts[axis]) / math.hypot(*facts[axis]) for axis in ("forward_axis", "curtain_axis"))
        self._directions = np.tile(forward, (count, 1))
        self._origins = np.outer(np.arange(count) * facts["curtain_length"] / count, aside)
        super()._set_up()

    def reading(self) -> BeamReading:
        """Cast the beams; return for each beam whether it is broken, the depth (m), and the positions of both ends."""
        position, rotation = self.frame()
        hits = self.cast(position, rotation)
        ends = self._origins + hits.depths[:, None] * self._directions
        begins = self._origins + self._ranges[0] * self._directions
        in_world = (position + points @ rotation.T for points in (begins, ends))
        return BeamReading(self._simulation.step_time, hits.found, hits.depths, ends, *in_world)
