"""The interface between sensors and the code that casts their rays.

Rays hit colliders, and the visuals of bodies without colliders (see `engine.sort_geoms`). They pass through fully transparent
geoms, and through parts of the sensor's own robot (see `own_colliders`). There are two implementations: `mujoco`, which always
works, and `fast`, which is compiled by numba and takes a tenth of the time or less.
"""

from __future__ import annotations

import contextlib
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.descriptions.engine import RAYS, RAYS_AND_PICTURES, Floats, Indices, mujoco
from graphengine.descriptions.geoms import geom_colours
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError
from graphengine.physics.ray_casting.own_colliders import OwnColliders

Integers = NDArray[np.signedinteger]
RaysChoice = Literal["auto", "mujoco", "fast"]

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


def select_rays(choice: RaysChoice, model: mujoco.MjModel, data: mujoco.MjData) -> Rays:
    """Return the requested ray casting method; `auto` is `fast` if numba works and supports all shapes of the model.

    Raises:
        UsageError: `fast` was requested but cannot be used.
    """
    obstacle = "" if choice == "mujoco" else _obstacle(model)
    if obstacle and choice == "fast":
        raise UsageError(obstacle)
    if obstacle or choice == "mujoco":
        from graphengine.physics.ray_casting.multiray import MultiRays

        return MultiRays(model, data)
    from graphengine.physics.ray_casting.fast.rays import FastRays

    return FastRays(model, data)


def compile_kernels(choice: RaysChoice) -> None:
    """Compile the kernels of the fast method if it can be selected; the first time, this takes up to a minute."""
    if choice != "mujoco":
        with contextlib.suppress(Exception):  # of numba; `select_rays` reports it
            from graphengine.physics.ray_casting.fast.rays import trouble

            trouble()


def _obstacle(model: mujoco.MjModel) -> str:
    """Return the reason why the fast method cannot be used with a model, with a remedy; empty if it can be used."""
    try:
        from graphengine.physics.ray_casting.fast.rays import trouble, why_not  # numba takes 0.4 s to import
    except Exception as error:  # numba is not there, or one of its libraries does not fit
        return f"rays 'fast' need numba: {error}\n  {install_command('fast')}"
    if why := trouble():
        return f"rays 'fast' cannot be cast here: {why}\n  use rays 'mujoco' instead"
    if unknown := why_not(model):
        return f"rays 'fast' do not support {unknown}\n  use rays 'mujoco' instead"
    return ""


def visible_geoms(model: mujoco.MjModel) -> Indices:
    """Return the ids of the geoms that rays can hit."""
    return np.flatnonzero((GROUPS_SEEN[model.geom_group] > 0) & (geom_colours(model)[:, 3] > 0))
