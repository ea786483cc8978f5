"""Whichever rays walk the tree of a mesh together, each finds the first of all triangles, bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco, sort_geoms
from graphengine.physics.ray_casting.own_colliders import OwnColliders
from tests.physics.ray_casting.casters import fan, needs_numba, turned

FAR = 9.0
Floats = NDArray[np.float64]


def land(cells: int, heights: Floats) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The same height field twice at the same place, of `cells` x `cells` cells on 6 x 6 m."""
    geom = '<geom type="hfield" hfield="land" pos=".1 .2 -.3" euler="4 5 6"/>'
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><asset><hfield name="land" nrow="{cells + 1}" ncol="{cells + 1}" size="3 3 1 .2"/></asset>
        <worldbody>{geom}{geom}</worldbody></mujoco>"""
    )
    model.hfield_data[:] = heights
    sort_geoms(model)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def by_axis(a: Any, b: Any) -> Any:
    """Scalar product, summed from x to z as the kernel does."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Any, b: Any) -> Any:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def first_of_all(rays: Any, origin: Floats, rotation: Floats, directions: Floats) -> Floats:
    """Distances by the method of Moller and Trumbore for every ray and every triangle."""
    turn, place = rays.table["rotation"][0], rays.table["position"][0]
    axes = [turn[axis::3] for axis in range(3)]
    world = [by_axis(rotation[axis], directions.T) for axis in range(3)]
    way = [by_axis(axis, world)[:, None] for axis in axes]
    start = [by_axis(axis, origin - place) for axis in axes]
    corner, one, other = rays.corners.T.reshape(3, 3, -1)
    across, offset = cross(way, other), [start[axis] - corner[axis] for axis in range(3)]
    turned_offset = cross(offset, one)
    with np.errstate(all="ignore"):
        volume = by_axis(one, across)
        u, v = by_axis(offset, across) / volume, by_axis(way, turned_offset) / volume
        distance = by_axis(other, turned_offset) / volume
        met = (np.abs(volume) >= 1e-15) & (u >= -1e-12) & (u <= 1 + 1e-12) & (v >= -1e-12) & (u + v <= 1 + 1e-12)
    nearest = np.where(met & (distance >= 0.0), distance, np.inf).min(axis=1)
    result: Floats = np.where(nearest <= FAR, nearest, -1.0)
    return result


BUNDLES: dict[str, Callable[[np.random.Generator, int], Floats]] = {
    "dense": lambda generator, count: fan(20000)[:count],
    "a degree apart": lambda generator, count: fan(360)[:count],
    "ten degrees apart": lambda generator, count: np.tile(fan(36), (2, 1))[:count],
    "the same": lambda generator, count: np.repeat(fan(1), count, axis=0),
    "narrow": lambda generator, count: generator.normal((-1.0, 0.0, 0.0), 0.1, (count, 3)),
    "all around": lambda generator, count: generator.normal(size=(count, 3)),
}


@needs_numba
@pytest.mark.parametrize("name", BUNDLES)
@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1), cells=st.sampled_from([1, 4, 12, 24]), count=st.sampled_from([1, 3, 16, 33, 70]))
def test_every_ray_finds_the_first_triangle_bit_for_bit(name: str, seed: int, cells: int, count: int) -> None:
    from graphengine.physics.ray_casting.fast.rays import FastRays

    generator = np.random.default_rng(seed)
    heights = generator.uniform(0, 1, (cells + 1) ** 2) * generator.choice([0.0, 0.2, 1.0])
    model, data = land(cells, heights)
    rays = FastRays(model, data)
    directions = BUNDLES[name](generator, count)
    directions = directions / np.linalg.norm(directions, axis=1)[:, None]
    caster = rays.caster(directions, FAR, OwnColliders(model, data))
    corner = data.geom_xpos[0] + data.geom_xmat[0].reshape(3, 3) @ generator.uniform((-3, -3, 0), (3, 3, 0))
    for origin in (generator.uniform(-4, 4, 3), corner, generator.uniform((-1, -1, 0), (1, 1, 2))):
        rotation = turned(*generator.uniform(-3, 3, 3))
        distances, geoms = caster.cast(origin, rotation)
        assert distances.tobytes() == first_of_all(rays, origin, rotation, directions).tobytes()
        assert geoms.tolist() == np.where(distances >= 0, 0, -1).tolist()


@needs_numba
def test_packets_are_divided_when_their_rays_do_not_agree() -> None:
    from graphengine.physics.ray_casting.fast import kernel, mesh_tree, mesh_walk
    from graphengine.physics.ray_casting.fast.rays import FastRays

    model, data = land(60, np.random.default_rng(2).uniform(0, 1, 61**2))
    rays = FastRays(model, data)
    turn, place = rays.table["rotation"][0].reshape(3, 3), rays.table["position"][0]
    start = tuple((turn.T @ (np.array([0.0, 0.0, 3.0]) - place)).tolist())
    stack, left = mesh_tree.new_stack(), []
    for angle in (1e-4, 0.02, 1.0):
        lanes = np.full((5, kernel.PACKET), FAR)
        way = np.stack([angle * np.arange(16), np.zeros(16), np.full(16, -1.0)], axis=1)
        lanes[:3, :16] = turn.T @ (way / np.linalg.norm(way, axis=1)[:, None]).T
        stack[0]["node"] = 0
        whole = mesh_walk._walk_mesh(rays.triangles, rays.corners, stack, lanes, start, 0, 16, 0, 1, mesh_walk.TESTS)
        few = mesh_walk._walk_mesh(rays.triangles, rays.corners, stack, lanes, start, 0, 4, 1, whole, mesh_walk.TESTS)
        left.append((whole > 1, few > whole))
    assert left == [(False, False), (True, False), (True, True)]
