"""A raycast sensor, whose rays have individual origins and directions.

The rays hit the same geoms as the rays of a lidar. All rays are cast when the sensor is read.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from graphengine.descriptions.engine import body_names
from graphengine.devices.raycast import RaycastReading, RaycastSensor
from graphengine.format.spec import NotNegative, Positive
from graphengine.physics.implementations import Offsets, Profile, check_less, implements
from graphengine.physics.sensors.ray_bundle import RayBundle

MAX_RAYS = 10_000
"""Maximum number of rays of a raycast sensor."""
_Rows = Annotated[tuple[Offsets, ...], Field(strict=False, min_length=1, max_length=MAX_RAYS)]


class RaycastProfile(Profile):
    """The parameters of a raycast sensor: the origins, directions and ranges of its rays, and its output."""

    casts_rays = True

    ray_origins: _Rows = ((0.0, 0.0, 0.0),)
    """Origin of each ray in the sensor's frame, m; a single origin applies to all rays."""
    ray_directions: _Rows = ((1.0, 0.0, 0.0),)
    """Direction of each ray in the sensor's frame; any length except zero."""
    min_range: NotNegative = 0.4
    """Distance from a ray's origin at which the ray starts, m."""
    max_range: Positive = Field(default=100.0, le=1_000_000)
    """Distance from a ray's origin at which the ray ends, m."""
    output_frame: Literal["SENSOR", "WORLD"] = "SENSOR"
    """Frame of hit positions and normals: the sensor's or the world frame."""
    report_hit_prim_paths: bool = False
    """Whether readings contain the paths of the prims hit."""

    @model_validator(mode="after")
    def _one_origin_a_ray(self) -> RaycastProfile:
        check_less(min_range=self.min_range, max_range=self.max_range)
        if len(self.ray_origins) not in (1, len(self.ray_directions)):
            raise ValueError(
                f"{len(self.ray_origins)} ray_origins do not fit {len(self.ray_directions)} ray_directions; "
                "write one origin, or one for each direction"
            )
        if not all(math.hypot(*direction) > 0.0 for direction in self.ray_directions):
            raise ValueError("ray_directions: (0, 0, 0) is not a direction")
        return self


@implements(RaycastSensor, RaycastProfile)
class RaySet(RayBundle):
    """The raycast sensor at a prim; the prim's `facts` are the values of its profile."""

    def _set_up(self) -> None:
        directions = np.array(self._prim.facts["ray_directions"], float)
        self._directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        self._origins = np.broadcast_to(np.array(self._prim.facts["ray_origins"], float), directions.shape)
        super()._set_up()

    def bind(self) -> None:
        """Look up the prims of all bodies, and create the rays."""
        super().bind()
        bodies = [prim for prim in self._simulation.stage.prims() if prim.body is not None and prim.kind != "robot"]
        paths = {prim.body: prim.path for prim in bodies}
        self._paths = [paths.get(name, "") for name in body_names(self._simulation.model)]

    def reading(self) -> RaycastReading:
        """Cast the rays; return depth (m), hit position, normal and hit prim of each ray."""
        facts, simulation, (position, rotation) = self._prim.facts, self._simulation, self.frame()
        hits = self.cast(position, rotation)
        origins = position + self._origins @ rotation.T
        ends = origins + hits.depths[:, None] * (self._directions @ rotation.T)
        positions, normals = np.where(hits.found[:, None], ends, 0.0), hits.normals
        if facts["output_frame"] == "SENSOR":
            positions = np.where(hits.found[:, None], (ends - position) @ rotation, 0.0)
            normals = normals @ rotation
        met = ("",) * len(origins)
        if facts["report_hit_prim_paths"]:
            bodies = simulation.model.geom_bodyid[hits.geoms].tolist()
            met = tuple(self._paths[body] if hit else "" for body, hit in zip(bodies, hits.found, strict=True))
        return RaycastReading(simulation.step_time, hits.depths, positions, normals, met, origins, ends)
