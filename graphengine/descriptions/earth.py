"""The place of a world on Earth: the keys of a scene, and the entry of a MuJoCo model that keeps the place."""

from __future__ import annotations

from graphengine.descriptions.engine import mujoco
from graphengine.format.scene_spec import EarthSpec

EARTH = "spherical_coordinates"
"""Name of a model's custom numbers for latitude, longitude (degrees), elevation (m) and heading (degrees)."""


def place_world(spec: mujoco.MjSpec, earth: EarthSpec) -> None:
    """Set the place of a world on Earth, in place of the one in the world's file."""
    for known in [each for each in spec.numerics if each.name == EARTH]:
        spec.delete(known)
    numbers = earth.latitude_deg, earth.longitude_deg, earth.elevation, earth.heading_deg
    spec.add_numeric(name=EARTH, size=4, data=numbers)


def earth_of(model: mujoco.MjModel) -> tuple[float, ...] | None:
    """Return latitude, longitude (degrees), elevation (m) and heading (degrees) of a world; None without a place on Earth."""
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, EARTH)
    return tuple(model.numeric(found).data.tolist()) if found >= 0 and model.numeric_size[found] == 4 else None
