"""The interface between a sensor and the code that finds what its rays meet.

Rays meet colliders, or the visuals of a body without colliders (`engine.sort_geoms`); they pass through fully transparent geoms
and the sensor's own robot. There are two implementations: MuJoCo's, which always works, and one compiled by numba, which takes
a tenth of the time or less.
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
"""For each geom group, whether rays meet its geoms."""


class Caster(Protocol):
    """Casts the rays of one sensor."""

    def cast(self, origin: Floats, rotation: Floats) -> tuple[Floats, Integers]:
        """Return distance (m) and geom id of what each ray meets first; the distance is -1 without a hit.

        Hits beyond the sensor's range may be returned or not. The next cast overwrites both arrays.

        Args:
            origin: origin of all rays in the world frame, m.
            rotation: rotation of the sensor in the world, a 3 x 3 matrix.
        """


class Rays(Protocol):
    """Casts rays into a model, for all its sensors."""

    @property
    def name(self) -> str:
        """`mujoco` or `fast`."""

    def caster(self, directions: Floats, far: float, tree: int) -> Caster:
        """Return a caster for the rays of a sensor.

        Args:
            directions: unit vectors in the sensor's frame, shape (n, 3); the array must not change afterwards.
            far: range of the sensor, m.
            tree: root body of the sensor's own robot, which rays pass through; 0 for none.
        """


def select_rays(choice: RaysChoice, model: mujoco.MjModel, data: mujoco.MjData) -> Rays:
    """Return the requested method; `auto` is the fast one if numba works and supports all shapes of the model.

    Raises:
        UsageError: `fast` was requested but cannot be used.
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
    """Return why the fast method cannot be used with a model, and a remedy; empty if it can."""
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
    """Return the geoms of the bodies below a root body; none for the world's own."""
    return np.flatnonzero(model.body_rootid[model.geom_bodyid] == tree) if tree else np.empty(0, np.intp)


def visible_geoms(model: mujoco.MjModel) -> Indices:
    """Return the geoms that rays can meet."""
    return np.flatnonzero((GROUPS_SEEN[model.geom_group] > 0) & (geom_colours(model)[:, 3] > 0))


def geom_colours(model: mujoco.MjModel) -> NDArray[np.float32]:
    """Return red, green, blue and opacity of each geom, 0 to 1: its material's, else its own."""
    of_materials = model.mat_rgba[model.geom_matid] if model.nmat else model.geom_rgba
    colours: NDArray[np.float32] = np.where((model.geom_matid < 0)[:, None], model.geom_rgba, of_materials)
    return colours
