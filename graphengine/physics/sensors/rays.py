"""The seam between a sensor and the code that finds what its rays meet.

Rays meet what collides, and of a body without colliders what is drawn (`engine.sort_geoms`); they pass through what is wholly
transparent and through the sensor's own robot. There are two casters: MuJoCo's own, which always works, and one of ours, compiled
by numba, which takes a tenth of the time or less.
"""

from __future__ import annotations

from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from graphengine.format.errors import UsageError
from graphengine.physics.engine import RAYS, RAYS_AND_PICTURES, Floats, Indices, mujoco

Integers = NDArray[np.signedinteger]
RaysChoice = Literal["auto", "mujoco", "fast"]

GROUPS_SEEN = np.array([group in (RAYS_AND_PICTURES, RAYS) for group in range(6)], np.uint8)
"""For each geom group whether rays meet what is in it."""


class Caster(Protocol):
    """The rays of one sensor."""

    def cast(self, origin: Floats, rotation: Floats) -> tuple[Floats, Integers]:
        """What each ray meets first: the distance (m) and the number of the geom; -1 for the distance where there is nothing.

        What is farther than the sensor sees may come back or not. Both arrays are written again by the next cast.

        Args:
            origin: of all rays, world frame, m.
            rotation: of the sensor in the world, a 3 x 3 matrix.
        """


class Rays(Protocol):
    """What rays meet in a model, for all its sensors."""

    @property
    def name(self) -> str:
        """`mujoco` or `fast`."""

    def caster(self, directions: Floats, far: float, tree: int) -> Caster:
        """Cast the rays of a sensor.

        Args:
            directions: unit vectors in the sensor's frame, shape (n, 3); an array that is not written again.
            far: how far the sensor sees, m.
            tree: root body of the sensor's own robot, which rays pass through; 0 for none.
        """


def select_rays(choice: RaysChoice, model: mujoco.MjModel, data: mujoco.MjData) -> Rays:
    """The faster rays, where numba works and they know every shape of the model, unless others are asked for.

    Raises:
        UsageError: `fast` was asked for and cannot be.
    """
    obstacle = "" if choice == "mujoco" else _obstacle(model)
    if obstacle and choice == "fast":
        raise UsageError(obstacle)
    if obstacle or choice == "mujoco":
        from graphengine.physics.sensors.multiray import MultiRays

        return MultiRays(model, data)
    from graphengine.physics.sensors.fast.rays import FastRays

    return FastRays(model, data)


def _obstacle(model: mujoco.MjModel) -> str:
    """What keeps the faster rays from serving a model, and what helps; empty if nothing does."""
    try:
        from graphengine.physics.sensors.fast.rays import trouble, why_not  # numba takes 0.4 s to import
    except Exception as error:  # numba is not there, or one of its libraries does not fit
        return f"rays 'fast' need numba: {error}\n  pip install 'graphengine[fast]'"
    if why := trouble():
        return f"rays 'fast' cannot be cast here: {why}\n  rays 'mujoco' can"
    if unknown := why_not(model):
        return f"rays 'fast' do not meet {unknown}\n  rays 'mujoco' do"
    return ""


def own_geoms(model: mujoco.MjModel, tree: int) -> Indices:
    """Geoms of the bodies below a root body; none for the world's own."""
    return np.flatnonzero(model.body_rootid[model.geom_bodyid] == tree) if tree else np.empty(0, np.intp)


def visible_geoms(model: mujoco.MjModel) -> Indices:
    """Geoms that some ray may meet."""
    return np.flatnonzero((GROUPS_SEEN[model.geom_group] > 0) & (geom_colours(model)[:, 3] > 0))


def geom_colours(model: mujoco.MjModel) -> NDArray[np.float32]:
    """Red, green, blue and opacity of each geom, 0 to 1: its material's, else its own."""
    of_materials = model.mat_rgba[model.geom_matid] if model.nmat else model.geom_rgba
    colours: NDArray[np.float32] = np.where((model.geom_matid < 0)[:, None], model.geom_rgba, of_materials)
    return colours
