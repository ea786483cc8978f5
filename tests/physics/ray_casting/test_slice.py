"""A slice of the world gives the distances that the whole world gives, bit for bit, or says that it does not serve."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from graphengine.format.files import shipped
from graphengine.physics.ray_casting.plane_culling import PlaneSlice

BEAMS = 720
FAR = 64.0


@pytest.fixture(scope="module")
def warehouse() -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_path(str(shipped() / "scenes" / "worlds" / "full_warehouse.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def cast(
    model: mujoco.MjModel, data: mujoco.MjData, origin: np.ndarray, rotation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    azimuth = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
    rays: np.ndarray = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(BEAMS)], axis=1) @ rotation.T
    distances, geoms = np.empty(BEAMS), np.empty(BEAMS, np.int32)
    mujoco.mj_multiRay(model, data, origin, rays.reshape(-1), None, True, -1, geoms, distances, None, BEAMS, FAR)
    return distances, geoms


def turned(yaw: float, pitch: float) -> np.ndarray:
    turn = np.array([[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]])
    dip = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    turned: np.ndarray = turn @ dip
    return turned


def test_a_slice_gives_the_same_distances_and_geoms_as_the_whole_model(
    warehouse: tuple[mujoco.MjModel, mujoco.MjData],
) -> None:
    model, data = warehouse
    generator = np.random.default_rng(7)
    part = PlaneSlice(model, data, range(model.ngeom), np.array([-3.0, 6.0, 0.165]), np.array([0.0, 0.0, 1.0]))
    assert part.model.ngeom < 0.8 * model.ngeom
    served = 0
    for _ in range(60):
        origin = np.array(
            [generator.uniform(-25, 4), generator.uniform(-22, 29), 0.165 + generator.uniform(-0.02, 0.02)]
        )
        rotation = turned(generator.uniform(-math.pi, math.pi), float(generator.choice([0.0, 1e-4, 0.01])))
        if not part.covers(origin, rotation[:, 2]):
            continue
        served += 1
        part.refresh(data)
        distances, geoms = cast(part.model, part.data, origin, rotation)
        expected, expected_geoms = cast(model, data, origin, rotation)
        assert distances.tobytes() == expected.tobytes()
        assert np.array_equal(np.where(geoms >= 0, part.geoms[geoms], -1), expected_geoms)
    assert served >= 20


def test_moving_bodies_are_seen_at_their_present_pose(warehouse: tuple[mujoco.MjModel, mujoco.MjData]) -> None:
    model, data = warehouse[0], mujoco.MjData(warehouse[0])
    mujoco.mj_forward(model, data)
    origin, level = np.array([-3.0, 6.0, 0.165]), np.eye(3)
    part = PlaneSlice(model, data, range(model.ngeom), origin, level[:, 2])
    before, _ = cast(model, data, origin, level)
    joint = next(joint for joint in range(model.njnt) if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE)
    data.qpos[model.jnt_qposadr[joint] :][:3] = (-2.0, 6.0, 0.2)
    mujoco.mj_forward(model, data)
    part.refresh(data)
    distances, _ = cast(part.model, part.data, origin, level)
    expected, _ = cast(model, data, origin, level)
    assert distances.tobytes() == expected.tobytes()
    assert distances.tobytes() != before.tobytes()


def test_a_plane_that_meets_a_left_out_geom_is_refused(warehouse: tuple[mujoco.MjModel, mujoco.MjData]) -> None:
    model, data = warehouse
    origin = np.array([-3.0, 6.0, 0.165])
    part = PlaneSlice(model, data, range(model.ngeom), origin, np.array([0.0, 0.0, 1.0]))
    assert part.covers(origin, np.array([0.0, 0.0, 1.0]))
    assert not part.covers(np.array([-3.0, 6.0, 1.6]), np.array([0.0, 0.0, 1.0]))
    assert not part.covers(origin, turned(0.0, 0.3)[:, 2])


def test_a_world_with_meshes_is_not_sliced(tmp_path: Path) -> None:
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><asset><mesh name='m' vertex='0 0 0 1 0 0 0 1 0 0 0 1'/></asset>"
        "<worldbody><geom type='mesh' mesh='m'/><geom type='box' size='1 1 1'/></worldbody></mujoco>"
    )
    assert not PlaneSlice.serves(model, range(model.ngeom))
    assert PlaneSlice.serves(model, [1])
