"""What pictures show: points where the intrinsics project them, prims by their numbers, colours and textures."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.descriptions.engine import mujoco
from graphengine.physics.pictures import opengl
from graphengine.physics.pictures.rendering import Renderer
from graphengine.physics.sensors.camera import PinholeCamera
from graphengine.physics.sensors.lidar import RayLidar
from tests.physics.harness import Project
from tests.physics.pictures.harness import EYE, camera_of, filming, needs_opengl, segmented, simulation_of

pytestmark = needs_opengl


@settings(max_examples=25)
@given(st.floats(1.0, 6.0), st.floats(-0.8, 0.8), st.floats(-0.6, 0.6))
def test_a_known_point_is_where_the_intrinsics_project_it(depth: float, right: float, down: float) -> None:
    x, y, z = depth, -right * depth, EYE[2] - down * depth
    radius = 0.02 * depth
    _, camera = filming(
        f'<body name="mark" pos="{x} {y} {z}"><geom type="box" size="{radius} {radius} {radius}"/></body>',
        size=(320, 240),
    )
    _, mark = segmented(camera, "/World/mark")
    fx, fy, cx, cy = camera.intrinsics
    # The corners of the cube's image are those of its faces; their middle is that of the silhouette.
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * radius
    u = cx + fx * (right * depth + corners[:, 0]) / (depth + corners[:, 2])
    v = cy + fy * (down * depth + corners[:, 1]) / (depth + corners[:, 2])
    rows, columns = np.nonzero(mark)
    assert (columns.min() + columns.max()) / 2 == pytest.approx((u.min() + u.max()) / 2, abs=0.5)
    assert (rows.min() + rows.max()) / 2 == pytest.approx((v.min() + v.max()) / 2, abs=0.5)


def test_the_intrinsics_have_no_bias_of_half_a_pixel() -> None:
    spots = np.random.default_rng(1).uniform((2.0, -0.7, -0.5), (5.0, 0.7, 0.5), (40, 3))
    off = []
    for depth, right, down in spots.tolist():
        where = f"{depth + 0.1} {-right * depth} {1 - down * depth}"
        _, camera = filming(
            f'<geom type="box" size=".1 {0.03 * depth} {0.03 * depth}" pos="{where}"/>', size=(160, 120)
        )
        fx, fy, cx, cy = camera.intrinsics
        near = np.abs(camera.picture().depth - depth) < 1e-4
        rows, columns = np.nonzero(near)
        off.append((columns.mean() - (cx + fx * right), rows.mean() - (cy + fy * down)))
    assert np.abs(np.mean(off, axis=0)).max() < 0.1  # where cx is half the width it is 0.5


def test_a_segmentation_counts_the_pixels_of_named_bodies() -> None:
    _, camera = filming(
        '<body name="near" pos="2.1 .8 1"><geom type="box" size=".1 .5 .3"/></body>'
        '<body name="far" pos="4.1 -1 1"><geom type="box" size=".1 .5 .5"/></body>'
        '<geom type="box" size=".1 9 9" pos="9 0 1"/>',
        size=(320, 240),
    )
    picture, near = segmented(camera, "/World/near")
    assert picture.segmentation is not None
    focal, counts = camera.intrinsics[0], dict(zip(*np.unique(picture.segmentation, return_counts=True), strict=True))
    numbers = {path: number for number, path in camera.labels.items()}
    assert set(counts) == {numbers["/World"], numbers["/World/near"], numbers["/World/far"]}
    front = np.abs(picture.depth - 2.0) < 1e-3  # a side of it is seen, too
    assert (front & near).sum() == pytest.approx((focal / 2) ** 2 * 0.6, abs=1.6 * focal / 2)
    assert (np.abs(picture.depth - 4.0) < 1e-3).sum() == pytest.approx((focal / 4) ** 2, abs=2 * focal / 4)
    assert camera.picture().segmentation is None


JUMBLE = """</worldbody>
  <asset><mesh name="tent" vertex="0 0 0 .9 0 0 0 .9 0 0 0 2.9"/></asset>
<worldbody><geom type="plane" size="0 0 1"/>"""


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_geoms_out_of_sight_are_left_out_and_the_image_is_the_same(seed: int) -> None:
    generator, parts = np.random.default_rng(seed), JUMBLE
    for index in range(30):
        shape = ("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")[index % 6]
        size = 'mesh="tent"' if shape == "mesh" else f'size="{" ".join(map(str, generator.uniform(0.05, 1.0, 3)))}"'
        drawn = generator.uniform(-5, 5, 3), generator.normal(size=4), generator.uniform(0, 1, 3)
        place, turn, colour = (" ".join(map(str, values)) for values in drawn)
        geom = f'<geom type="{shape}" {size} rgba="{colour} 1"/>'
        parts += f'<body name="b{index}" pos="{place}" quat="{turn}">{geom}</body>'
    looking = generator.normal(size=4)
    x, y, z, w = (looking / np.linalg.norm(looking)).tolist()
    pose = (EYE, (x, y, z, w))
    simulation = simulation_of(parts, pose=pose, size=(48, 32), fov_deg=(generator.uniform(10, 140), 1.0))
    lens, studio = camera_of(simulation)._lens, simulation.studio
    part, whole = (studio.capture(pose, lens, segmentation=True, whole=whole) for whole in (False, True))
    assert part.scene.ngeom < whole.scene.ngeom == 31
    with opengl.context(), closing(Renderer(simulation.model, lens.size, lens.far)) as renderer:
        one, other = renderer.draw(part), renderer.draw(whole)
    assert one.rgb.tobytes() == other.rgb.tobytes()
    assert one.depth.tobytes() == other.depth.tobytes()
    segments, expected = (image.segmentation for image in (one, other))
    assert segments is not None
    assert expected is not None
    assert segments.tobytes() == expected.tobytes()
    assert set(simulation.model.geom_group.tolist()) == {0}


def test_the_textures_of_the_floor_and_of_the_sky_are_drawn() -> None:
    textured = """</worldbody><asset>
      <texture name="sky" type="skybox" builtin="flat" rgb1="0 1 0" rgb2="0 1 0" width="32" height="32"/>
      <texture name="tiles" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 0 1" width="64" height="64"/>
      <material name="tiles" texture="tiles" texrepeat="1 1" texuniform="true"/>
    </asset><worldbody><geom type="plane" size="0 0 1" material="tiles"/>"""
    rgb = camera_of(simulation_of(textured)).picture().rgb.astype(int)
    assert (rgb[:20, :, 1] > rgb[:20, :, [0, 2]].max(axis=2) + 50).all()
    red, _, blue = np.moveaxis(rgb[32:], 2, 0)
    assert 0.3 < np.mean(red > 4 * blue) < 0.6
    assert 0.3 < np.mean(blue > 4 * red) < 0.6


def test_pictures_show_visuals_and_not_the_colliders_behind_them() -> None:
    simulation = simulation_of(
        '<body name="robot" pos="2 0 1">'
        '<geom type="box" size=".1 .2 .2" rgba="1 0 0 1" contype="0" conaffinity="0" group="2"/>'
        '<geom type="box" size=".1 .6 .6" rgba="0 1 0 1" group="3"/></body>'
    )
    rgb = camera_of(simulation).picture().rgb.astype(int)
    assert (rgb[..., 0] > 100).any()
    assert not (rgb[..., 1] > 100).any()


def test_row_0_is_up_and_column_0_is_left() -> None:
    colours = simulation_of(
        '<geom type="box" size=".1 1 1" pos="3 1 2" rgba="1 0 0 1"/>'  # ahead on the left, above
        '<geom type="box" size=".1 1 1" pos="3 -1 0" rgba="0 0 1 1"/>'  # on the right, below
    )
    rgb = camera_of(colours).picture().rgb.astype(int)
    red, _, blue = rgb[10, 15]
    assert red > blue
    red, _, blue = rgb[40, 50]
    assert blue > red


def test_a_sensors_body_is_seen_by_others_and_not_by_its_own_rays(project: Project) -> None:
    scanner = (
        "scanner: {type: lidar, profile: microscan3_light, parent: base_link, position: [0, 0, .3], ignores: [arm]}"
    )
    project.robot(f"sensors:\n  {scanner}\n  eye: {{type: camera, parent: base_link, position: [-1, 0, .3]}}")
    simulation = project.load().simulation
    camera = simulation.device(PinholeCamera, simulation.stage.find("/bot/base_link/eye/Camera"))
    picture, seen = segmented(camera, "/bot/Geometry/base_link/scanner")
    assert seen.sum() > 500
    assert np.median(picture.depth[seen]) == pytest.approx(0.945, abs=0.01)
    scan = simulation.device(RayLidar, simulation.stage.find("/bot/base_link/scanner/Lidar")).scan()
    assert np.isinf(scan.ranges).all()


def test_prims_keep_their_numbers_when_the_model_is_exchanged() -> None:
    simulation, camera = filming('<body name="first" pos="3 0 1"><geom type="sphere" size=".5"/></body>')
    _, before = segmented(camera, "/World/first")
    labels = dict(camera.labels)
    simulation.stage.add("/World/zero", "body", body="zero")
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="zero" pos="3 1 1"><geom type="sphere" size=".3"/></body>'
        '<body name="first" pos="3 -1 1"><geom type="sphere" size=".5"/></body></worldbody></mujoco>'
    )
    simulation.rebind(model, mujoco.MjData(model))
    picture, after = segmented(camera, "/World/first")
    assert labels.items() <= camera.labels.items()
    assert np.nonzero(after)[1].mean() > np.nonzero(before)[1].mean() + 5
    assert picture.segmentation is not None
    assert len(np.unique(picture.segmentation)) == 3
