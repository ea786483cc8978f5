"""The interface between sensors and the code that casts their rays.

Rays hit colliders, and the visuals of bodies without colliders (see `engine.sort_geoms`). They pass through fully transparent
geoms, and through parts of the sensor's own robot (see `own_colliders`).
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import RAYS, RAYS_AND_PICTURES, Floats, Indices, mujoco
from graphengine.descriptions.geoms import geom_colours
from graphengine.physics.ray_casting.own_colliders import OwnColliders

Integers = NDArray[np.signedinteger]

GROUPS_SEEN = np.array([group in (RAYS_AND_PICTURES, RAYS) for group in range(6)], np.uint8)
"""Whether rays hit the geoms of each geom group, 1 or 0."""


class Caster(Protocol):
    """Casts the rays of one sensor."""

    def cast(self, origin: Floats, rotation: Floats) -> tuple[Floats, Integers]:
        """Return distance (m) and geom id of the first hit of each ray; the distance is -1 without a hit.

        Hits beyond the sensor's range may or may not be returned. The next cast overwrites both arrays.

        Args:
            origin: origin of all rays in the world frame, m.
            rotation: rotation of the sensor in the world, a 3 x 3 matrix.
        """


class Rays(Protocol):
    """A ray casting method for a model, shared by all sensors."""

    @property
    def name(self) -> str:
        """Name of the method: `mujoco` or `fast`."""

    def caster(self, directions: Floats, far: float, own: OwnColliders) -> Caster:
        """Return a caster for the rays of a sensor.

        Args:
            directions: unit vectors in the sensor's frame, shape (n, 3); the array must not change afterwards.
            far: range of the sensor, m.
            own: colliders of the sensor's own robot; no other caster may use the same object.
        """


def visible_geoms(model: mujoco.MjModel) -> Indices:
    """Return the ids of the geoms that rays can hit."""
    return np.flatnonzero((GROUPS_SEEN[model.geom_group] > 0) & (geom_colours(model)[:, 3] > 0))
