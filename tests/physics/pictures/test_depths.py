"""Distances in pictures: what rays measure, within the clip range and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco
from graphengine.devices.rotation import from_rpy, multiply, rotate
from graphengine.physics.pictures.frame_capture import Lens
from graphengine.physics.pictures.rendering import distances
from graphengine.physics.sensors.camera import PinholeCamera
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project
from tests.physics.pictures.harness import (
    EYE,
    FORWARD,
    ROOM,
    camera_of,
    directions,
    filming,
    needs_opengl,
    segmented,
    simulation_of,
)

TILTED = (EYE, multiply(from_rpy(0.05, 0.2, -0.1), FORWARD))


def measured(
    simulation: Simulation, rays: NDArray[np.float64], start: tuple[float, float, float]
) -> NDArray[np.float64]:
    """Depth along each ray, inf for a miss."""
    count = rays.size // 3
    geoms, found = np.empty(count, np.int32), np.empty(count)
    flat = np.ascontiguousarray(rays).reshape(-1)
    mujoco.mj_multiRay(
        simulation.model, simulation.data, np.array(start), flat, None, True, -1, geoms, found, None, count, 1e3
    )
    return np.where(found < 0, np.inf, found).reshape(rays.shape[:2])


@needs_opengl
@pytest.mark.parametrize("extent", [0.02, 1.0, 65.0])
@pytest.mark.parametrize("clip", [(0.01, 100.0), (0.5, 6.0)])
def test_depths_agree_with_rays_for_worlds_of_any_extent(extent: float, clip: tuple[float, float]) -> None:
    simulation, camera = filming(ROOM, pose=TILTED, extent=extent, size=(160, 120), clip=clip)
    depth = camera.picture().depth
    expected = measured(simulation, directions(camera, TILTED), EYE)
    expected[(expected < clip[0]) | (expected > clip[1])] = np.inf
    seen = np.isfinite(expected)
    assert np.mean(np.isfinite(depth) == seen) > 0.995  # but for edges
    both = seen & np.isfinite(depth)
    assert 0.2 < both.mean() < 0.95
    errors = np.abs(depth[both] - expected[both])
    assert np.median(errors) < 2e-6
    assert np.mean(errors < 1e-3) > 0.95  # a ball is drawn with flat faces


@needs_opengl
@pytest.mark.parametrize("fov", [0.1, 1.0, 120.0, 179.0])
@pytest.mark.parametrize("clip", [(0.001, 0.5), (0.001, 1e6), (2.9, 3.1), (1.0, 1e6), (999_999.0, 1e6)])
def test_depth_is_exact_for_extreme_fields_of_view_and_clipping_ranges(fov: float, clip: tuple[float, float]) -> None:
    wall = '<geom type="box" size=".1 400 400" pos="3.1 0 1"/>'
    depth = camera_of(simulation_of(wall, size=(9, 7), fov_deg=(fov, 50.0), clip=clip)).picture().depth
    expected = 3.0 if clip[0] < 3.0 < clip[1] else np.inf
    np.testing.assert_allclose(depth, expected, rtol=1e-4)


@needs_opengl
@settings(max_examples=15)
@given(st.floats(0.3, 20.0), st.floats(0.0005, 0.05))
def test_the_clip_range_is_exact(distance: float, margin: float) -> None:
    wall = f'<geom type="box" size=".1 50 50" pos="{distance + 0.1} 0 1"/>'

    def sees(near: float, far: float) -> bool:
        depth = camera_of(simulation_of(wall, size=(8, 6), clip=(near, far))).picture().depth
        assert np.isfinite(depth).all() or np.isinf(depth).all()
        return bool(np.isfinite(depth).all())

    assert sees(distance - margin, distance + margin)
    assert not sees(0.01, distance - margin)
    assert not sees(distance + margin, distance + 5.0)


@needs_opengl
def test_an_object_nearer_than_the_clip_range_hides_the_objects_behind_it() -> None:
    parts = '<geom type="box" size=".1 .1 2" pos=".4 0 1"/><geom type="box" size=".1 9 9" pos="3.1 0 1"/>'
    depth = camera_of(simulation_of(parts, clip=(0.6, 6.0))).picture().depth
    assert np.isinf(depth[24, 32])
    assert depth[24, 2] == pytest.approx(3.0, abs=1e-5)


@needs_opengl
def test_a_camera_within_a_shape_sees_out_of_it() -> None:
    parts = '<geom type="box" size=".5 .5 .5" pos="0 0 1"/><geom type="box" size=".1 9 9" pos="3.1 0 1"/>'
    depth = camera_of(simulation_of(parts)).picture().depth
    np.testing.assert_allclose(depth, 3.0, rtol=1e-5)


@needs_opengl
def test_the_sky_has_no_depth_even_in_the_corners_of_a_wide_picture() -> None:
    picture = camera_of(simulation_of("", fov_deg=(140.0, 120.0), clip=(0.05, 30.0))).picture()
    assert np.isinf(picture.depth).all()


@needs_opengl
def test_the_points_of_a_depth_image_lie_on_a_box_through_tf(project: Project) -> None:
    eye = "{type: camera, parent: base_link, position: [.2, .1, .3], orientation: {rpy_deg: [3, 8, -5]}}"
    project.world('<body name="wall" pos="2 0 .5"><geom type="box" size=".1 2 .6" euler="0 0 25"/></body>')
    loaded = project.robot(f"sensors: {{eye: {eye}}}").load()
    simulation, prim = loaded.simulation, loaded.stage.find("/bot/base_link/eye/Camera")
    camera = simulation.device(PinholeCamera, prim)
    picture, wall = segmented(camera, "/World/wall")
    v, u = np.nonzero(wall)
    assert len(v) > 10_000
    fx, fy, cx, cy = camera.intrinsics
    z = picture.depth[v, u].astype(float)
    optical = np.stack([z * (u - cx) / fx, z * (v - cy) / fy, z], axis=1)
    position, orientation = simulation.frame(prim).pose()
    frame = multiply(orientation, (1.0, 0.0, 0.0, 0.0))  # in TF: x to the right, y down, z ahead
    axes = np.array([rotate(frame, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))])
    points = np.array(position) + optical @ axes
    geom = int(simulation.model.body_geomadr[simulation.model.body("wall").id])
    local = (points - simulation.data.geom_xpos[geom]) @ simulation.data.geom_xmat[geom].reshape(3, 3)
    beyond = np.abs(local) - simulation.model.geom_size[geom]
    assert np.median(np.abs(beyond.max(axis=1))) < 1e-5
    assert np.abs(beyond.max(axis=1)).max() < 0.02  # at edges a pixel's centre may miss what it shows


@given(st.floats(0.01, 1.0), st.floats(2.0, 500.0), st.floats(0.0, 1.0))
def test_distances_invert_the_depth_buffer(near: float, far: float, share: float) -> None:
    distance = near + share * (far - near)
    lens = Lens((4, 3), 0.5, near, far)
    buffer = np.array([near * (far - distance) / (distance * (far - near))], np.float32)
    assert distances(lens, buffer)[0] == pytest.approx(distance, rel=far / near * 1e-6)
    plan = Lens((4, 3), 0.5, near, far, parallel=True)
    linear = np.array([(far - distance) / (far - near)], np.float32)
    assert distances(plan, linear)[0] == pytest.approx(distance, abs=far * 1e-6)
