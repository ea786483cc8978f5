"""Both ways to cast rays, and what they are compared with: `mj_ray`, one ray at a time."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.descriptions.engine import OWN, mujoco
from graphengine.physics.ray_casting.casters import GROUPS_SEEN
from graphengine.physics.ray_casting.own_colliders import OwnColliders

Floats = NDArray[np.float64]

needs_numba = pytest.mark.skipif(importlib.util.find_spec("numba") is None, reason="the extra 'fast' is not installed")
either_rays = pytest.mark.parametrize("rays", ["mujoco", pytest.param("fast", marks=needs_numba)])


def one_by_one(
    model: mujoco.MjModel, data: mujoco.MjData, origin: Floats, rays: Floats, tree: int = 0
) -> tuple[Floats, NDArray[np.int32]]:
    """What `mj_ray` finds for rays in the world frame, with the robot of a root body taken out."""
    own, groups = OwnColliders(model, data, tree).always_passed, model.geom_group.copy()
    distances, geoms = np.empty(len(rays)), np.empty(len(rays), np.int32)
    model.geom_group[own] = OWN
    for index, ray in enumerate(rays):
        distances[index] = mujoco.mj_ray(
            model, data, origin, ray, GROUPS_SEEN, True, -1, geoms[index : index + 1], None
        )
    model.geom_group[:] = groups
    return distances, geoms


def fan(beams: int) -> Floats:
    """Beams all around in the xy plane."""
    azimuth = np.linspace(-np.pi, np.pi, beams, endpoint=False)
    return np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(beams)], axis=1)


def sphere(rings: int, beams: int) -> Floats:
    """Beams in all directions, ring after ring."""
    elevation = np.linspace(-1.5, 1.5, rings)[:, None, None]
    level = fan(beams)
    rays: Floats = level * np.cos(elevation) + np.array([0.0, 0.0, 1.0]) * np.sin(elevation)
    return rays.reshape(-1, 3)


def turned(roll: float, pitch: float, yaw: float) -> Floats:
    """Rotation matrix of turns about fixed axes."""
    quaternion, matrix = np.empty(4), np.empty(9)
    mujoco.mju_euler2Quat(quaternion, np.array([roll, pitch, yaw]), "XYZ")
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)
