"""What pictures show: distances as rays measure them, points where the intrinsics project them, prims by their numbers."""

from __future__ import annotations

import os
import re
import signal
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, closing, suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.diagnostics import RenderError
from graphengine.rotation import from_rpy, multiply, rotate
from graphengine.world import opengl, views
from graphengine.world.captures import Lens
from graphengine.world.engine import mujoco
from graphengine.world.rendering import Renderer, distances
from graphengine.world.simulation import Simulation
from tests.world.harness import Project
from tests.world.pictures import EYE, FORWARD, camera_of, directions, needs_opengl, simulation_of, take_opengl_away

ROOM = """
  <geom type="plane" size="0 0 1"/>
  <body name="crate" pos="3 .6 .5"><geom type="box" size=".5 .4 .5" euler="0 0 20" rgba="1 0 0 1"/></body>
  <body name="ball" pos="2.5 -.8 .6"><geom type="sphere" size=".4" rgba="0 1 0 1"/></body>
  <body name="shelf" pos="8 0 1"><geom type="box" size=".2 5 2"/></body>
"""
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
def test_depths_are_what_rays_measure_whatever_the_worlds_extent(extent: float, clip: tuple[float, float]) -> None:
    simulation = simulation_of(ROOM, pose=TILTED, extent=extent, size=(160, 120), clip=clip)
    camera = camera_of(simulation)
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
def test_all_that_a_profile_may_say_can_be_drawn(fov: float, clip: tuple[float, float]) -> None:
    wall = '<geom type="box" size=".1 400 400" pos="3.1 0 1"/>'
    depth = camera_of(simulation_of(wall, size=(9, 7), fov_deg=(fov, 50.0), clip=clip)).picture().depth
    expected = 3.0 if clip[0] < 3.0 < clip[1] else np.inf
    np.testing.assert_allclose(depth, expected, rtol=1e-4)


@needs_opengl
@settings(max_examples=15, deadline=None)
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
def test_what_is_nearer_than_the_clip_range_hides_what_is_behind_it() -> None:
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
@settings(max_examples=25, deadline=None)
@given(st.floats(1.0, 6.0), st.floats(-0.8, 0.8), st.floats(-0.6, 0.6))
def test_a_known_point_is_where_the_intrinsics_project_it(depth: float, right: float, down: float) -> None:
    x, y, z = depth, -right * depth, EYE[2] - down * depth
    radius = 0.02 * depth
    simulation = simulation_of(
        f'<body name="mark" pos="{x} {y} {z}"><geom type="box" size="{radius} {radius} {radius}"/></body>',
        size=(320, 240),
    )
    camera = camera_of(simulation)
    picture = camera.picture(segmentation=True)
    assert picture.segmentation is not None
    fx, fy, cx, cy = camera.intrinsics
    number = next(number for number, path in camera.labels.items() if path == "/World/mark")
    # The corners of the cube's image are those of its faces; their middle is that of the silhouette.
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * radius
    u = cx + fx * (right * depth + corners[:, 0]) / (depth + corners[:, 2])
    v = cy + fy * (down * depth + corners[:, 1]) / (depth + corners[:, 2])
    rows, columns = np.nonzero(picture.segmentation == number)
    assert (columns.min() + columns.max()) / 2 == pytest.approx((u.min() + u.max()) / 2, abs=0.5)
    assert (rows.min() + rows.max()) / 2 == pytest.approx((v.min() + v.max()) / 2, abs=0.5)


@needs_opengl
def test_the_intrinsics_have_no_bias_of_half_a_pixel() -> None:
    spots = np.random.default_rng(1).uniform((2.0, -0.7, -0.5), (5.0, 0.7, 0.5), (40, 3))
    off = []
    for depth, right, down in spots.tolist():
        where = f"{depth + 0.1} {-right * depth} {1 - down * depth}"
        simulation = simulation_of(
            f'<geom type="box" size=".1 {0.03 * depth} {0.03 * depth}" pos="{where}"/>', size=(160, 120)
        )
        camera = camera_of(simulation)
        fx, fy, cx, cy = camera.intrinsics
        near = np.abs(camera.picture().depth - depth) < 1e-4
        rows, columns = np.nonzero(near)
        off.append((columns.mean() - (cx + fx * right), rows.mean() - (cy + fy * down)))
    assert np.abs(np.mean(off, axis=0)).max() < 0.1  # where cx is half the width it is 0.5


@needs_opengl
def test_a_segmentation_counts_the_pixels_of_named_bodies() -> None:
    simulation = simulation_of(
        '<body name="near" pos="2.1 .8 1"><geom type="box" size=".1 .5 .3"/></body>'
        '<body name="far" pos="4.1 -1 1"><geom type="box" size=".1 .5 .5"/></body>'
        '<geom type="box" size=".1 9 9" pos="9 0 1"/>',
        size=(320, 240),
    )
    camera = camera_of(simulation)
    picture = camera.picture(segmentation=True)
    assert picture.segmentation is not None
    focal, counts = camera.intrinsics[0], dict(zip(*np.unique(picture.segmentation, return_counts=True), strict=True))
    numbers = {path: number for number, path in camera.labels.items()}
    assert set(counts) == {numbers["/World"], numbers["/World/near"], numbers["/World/far"]}
    front = np.abs(picture.depth - 2.0) < 1e-3  # a side of it is seen, too
    assert (front & (picture.segmentation == numbers["/World/near"])).sum() == pytest.approx(
        (focal / 2) ** 2 * 0.6, abs=1.6 * focal / 2
    )
    assert (np.abs(picture.depth - 4.0) < 1e-3).sum() == pytest.approx((focal / 4) ** 2, abs=2 * focal / 4)
    assert camera.picture().segmentation is None


JUMBLE = """</worldbody>
  <asset><mesh name="tent" vertex="0 0 0 .9 0 0 0 .9 0 0 0 2.9"/></asset>
<worldbody><geom type="plane" size="0 0 1"/>"""


@needs_opengl
@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_what_is_out_of_sight_is_left_out_and_the_picture_is_the_same(seed: int) -> None:
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


@needs_opengl
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


@needs_opengl
def test_pictures_show_visuals_and_not_the_colliders_behind_them() -> None:
    simulation = simulation_of(
        '<body name="robot" pos="2 0 1">'
        '<geom type="box" size=".1 .2 .2" rgba="1 0 0 1" contype="0" conaffinity="0" group="2"/>'
        '<geom type="box" size=".1 .6 .6" rgba="0 1 0 1" group="3"/></body>'
    )
    rgb = camera_of(simulation).picture().rgb.astype(int)
    assert (rgb[..., 0] > 100).any()
    assert not (rgb[..., 1] > 100).any()


@needs_opengl
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


@needs_opengl
def test_the_points_of_a_depth_image_lie_on_a_box_through_tf(project: Project) -> None:
    world = (
        '<body name="wall" pos="2 0 .5"><geom type="box" size=".1 2 .6" euler="0 0 25"/></body></worldbody></mujoco>'
    )
    project.write("world.xml", (project.folder / "world.xml").read_text().replace("</worldbody></mujoco>", world))
    project.write(
        "bot.yaml",
        "robot: bot\nurdf: bot.urdf\nsensors:\n"
        "  eye: {type: camera, parent: base_link, position: [.2, .1, .3], orientation: {rpy_deg: [3, 8, -5]}}\n",
    )
    loaded = project.load()
    simulation, prim = loaded.simulation, loaded.stage.find("/bot/base_link/eye/Camera")
    camera = simulation.camera(prim)
    picture = camera.picture(segmentation=True)
    assert picture.segmentation is not None
    number = next(number for number, path in camera.labels.items() if path == "/World/wall")
    v, u = np.nonzero(picture.segmentation == number)
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


@needs_opengl
def test_a_sensors_body_is_seen_by_others_and_not_by_rays(project: Project) -> None:
    project.write(
        "bot.yaml",
        "robot: bot\nurdf: bot.urdf\nsensors:\n"
        "  scanner: {type: lidar, profile: microscan3_light, parent: base_link, position: [0, 0, .3]}\n"
        "  eye: {type: camera, parent: base_link, position: [-1, 0, .3]}\n",
    )
    simulation = project.load().simulation
    camera = simulation.camera(simulation.stage.find("/bot/base_link/eye/Camera"))
    picture = camera.picture(segmentation=True)
    assert picture.segmentation is not None
    numbers = {path: number for number, path in camera.labels.items()}
    seen = picture.segmentation == numbers["/bot/Geometry/base_link/scanner"]
    assert seen.sum() > 500
    assert np.median(picture.depth[seen]) == pytest.approx(0.945, abs=0.01)
    scan = simulation.lidar(simulation.stage.find("/bot/base_link/scanner/Lidar")).scan()
    assert np.isinf(scan.ranges).all()


@needs_opengl
def test_prims_keep_their_numbers_when_the_model_is_exchanged() -> None:
    simulation = simulation_of('<body name="first" pos="3 0 1"><geom type="sphere" size=".5"/></body>')
    camera = camera_of(simulation)
    before = camera.picture(segmentation=True)
    labels = dict(camera.labels)
    simulation.stage.add("/World/zero", "body", body="zero")
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="zero" pos="3 1 1"><geom type="sphere" size=".3"/></body>'
        '<body name="first" pos="3 -1 1"><geom type="sphere" size=".5"/></body></worldbody></mujoco>'
    )
    simulation.rebind(model, mujoco.MjData(model))
    after = camera.picture(segmentation=True)
    assert labels.items() <= camera.labels.items()
    assert before.segmentation is not None
    assert after.segmentation is not None
    number = next(number for number, path in labels.items() if path == "/World/first")
    middle = np.nonzero(before.segmentation == number)[1].mean()
    assert np.nonzero(after.segmentation == number)[1].mean() > middle + 5
    assert len(np.unique(after.segmentation)) == 3


@needs_opengl
@pytest.mark.parametrize("wall", ["", '<geom type="box" size=".05 2 2" euler="0 0 35" pos=".7 .5 0"/>'])
def test_a_view_at_an_angle_shows_the_robot_from_where_nothing_hides_it(project: Project, wall: str) -> None:
    world = (project.folder / "world.xml").read_text().replace("</worldbody>", f"{wall}</worldbody>")
    simulation = project.write("world.xml", world).load().simulation
    view = views.find_view(simulation, "perspective", (160, 120))
    image = views.draw(simulation, view, segmentation=True)
    assert image.segmentation is not None
    robot = [number for number, path in simulation.studio.labels.items() if path.startswith("/bot")]
    seen = np.isin(image.segmentation, robot)
    rows, columns = np.nonzero(seen)
    assert 0.02 < seen.mean() < 0.3
    assert 40 < columns.mean() < 120
    assert 30 < rows.mean() < 110


@needs_opengl
def test_a_view_from_above_fits_the_world() -> None:
    corners = [(-4.0, -9.0), (-4.0, 9.0), (4.0, -9.0), (4.0, 9.0)]
    posts = "".join(
        f'<body name="post_{index}" pos="{x} {y} .5"><geom type="box" size=".3 .3 .5"/></body>'
        for index, (x, y) in enumerate(corners)
    )
    simulation = simulation_of(posts)
    view = views.find_view(simulation, "top", (200, 100))
    image = views.draw(simulation, view, segmentation=True)
    assert image.segmentation is not None
    numbers = {path: number for number, path in simulation.studio.labels.items()}
    for index, (x, y) in enumerate(corners):  # x is up and y to the left, as that way the picture is filled
        rows, columns = np.nonzero(image.segmentation == numbers[f"/World/post_{index}"])
        assert np.sign(49.5 - rows.mean()) == np.sign(x)
        assert np.sign(99.5 - columns.mean()) == np.sign(y)
        assert len(rows) == pytest.approx((0.6 * 100 / (2 * view.lens.half_height)) ** 2, rel=0.25)
    assert views.names(simulation) == ["top", "perspective"]


@needs_opengl
def test_shadows_fall_where_a_light_is_kept_off() -> None:
    simulation = simulation_of(
        '<light type="directional" pos="0 0 30" dir="0 0 -1" castshadow="true" diffuse=".8 .8 .8"/>'
        '<geom type="plane" size="0 0 1"/><body name="roof" pos="0 0 1"><geom type="box" size=".5 .5 .05"/></body>'
        '<body name="post" pos="3 3 1"><geom type="box" size=".1 .1 1"/></body>'
    )
    view = views.find_view(simulation, "perspective", (160, 120))
    lit = views.draw(simulation, view).rgb.astype(int).sum(axis=2)
    shot = simulation.studio.capture(view.pose, view.lens)
    with opengl.context(), closing(Renderer(simulation.model, view.lens.size, view.lens.far)) as sensor:
        plain = sensor.draw(shot)
    darker = plain.rgb.astype(int).sum(axis=2) - lit > 60
    assert 0.001 < darker.mean() < 0.2


@given(st.floats(0.01, 1.0), st.floats(2.0, 500.0), st.floats(0.0, 1.0))
def test_distances_invert_the_depth_buffer(near: float, far: float, share: float) -> None:
    distance = near + share * (far - near)
    lens = Lens((4, 3), 0.5, near, far)
    buffer = np.array([near * (far - distance) / (distance * (far - near))], np.float32)
    assert distances(lens, buffer)[0] == pytest.approx(distance, rel=far / near * 1e-6)
    plan = Lens((4, 3), 0.5, near, far, parallel=True)
    linear = np.array([(far - distance) / (far - near)], np.float32)
    assert distances(plan, linear)[0] == pytest.approx(distance, abs=far * 1e-6)


@pytest.fixture
def no_libraries(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    take_opengl_away(monkeypatch)
    yield
    opengl._platform.cache_clear()


@pytest.mark.usefixtures("no_libraries")
def test_without_opengl_the_packages_to_install_are_told() -> None:
    camera = camera_of(simulation_of(ROOM))
    with pytest.raises(RenderError) as caught:
        camera.picture()
    told = str(caught.value).splitlines()
    assert told[0] == "pictures need OpenGL, and none works here"
    assert "EGL: libEGL.so.1: cannot open shared object file: No such file or directory" in told
    assert any(line.startswith("OSMesa: libOSMesa") for line in told)
    assert any("apt-get install libegl1 libgl1-mesa-dri libopengl0" in line for line in told)
    assert any("apt-get install libosmesa6" in line for line in told)


@pytest.mark.usefixtures("no_libraries")
def test_without_opengl_everything_but_pictures_works() -> None:
    simulation = simulation_of(ROOM)
    camera = camera_of(simulation)
    simulation.begin_tick(1)
    assert camera.due
    assert camera.delivered() is None
    simulation.step()
    simulation.close()


@needs_opengl
def test_opengl_serves_several_threads_one_after_another_and_at_once() -> None:
    simulations = [simulation_of(ROOM, size=(160, 120)) for _ in range(3)]
    seen: list[bytes] = []

    def look(simulation: Simulation) -> None:
        seen.append(camera_of(simulation).picture().rgb.tobytes())
        simulation.close()

    threads = [threading.Thread(target=look, args=(simulation,)) for simulation in simulations]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(seen) == 3
    assert len(set(seen)) == 1


@needs_opengl
def test_a_picture_that_mujoco_cannot_draw_is_told() -> None:
    camera = camera_of(simulation_of(ROOM, size=(40_000, 1)))
    with pytest.raises(RenderError, match="MuJoCo cannot draw"):
        camera.picture()


@needs_opengl
def test_after_a_picture_that_could_not_be_drawn_the_next_one_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise mujoco.FatalError("no")

    camera = camera_of(simulation_of(ROOM))
    before = camera.picture().rgb.tobytes()
    with monkeypatch.context() as patch:
        patch.setattr(mujoco, "mjr_render", refuse)
        with pytest.raises(RenderError, match="MuJoCo cannot draw: no"):
            camera.picture()
    assert camera.picture().rgb.tobytes() == before


@needs_opengl
def test_opengl_stays_open_over_an_exchange_of_the_model(monkeypatch: pytest.MonkeyPatch) -> None:
    opened, context = [], opengl.context

    def counted() -> AbstractContextManager[None]:
        opened.append(threading.current_thread().name)
        return context()

    monkeypatch.setattr(opengl, "context", counted)
    simulation = simulation_of(ROOM)
    camera_of(simulation).picture()
    model = mujoco.MjModel.from_xml_string('<mujoco><worldbody><geom size="1" pos="3 0 1"/></worldbody></mujoco>')
    simulation.rebind(model, mujoco.MjData(model))
    depth = camera_of(simulation).picture().depth
    assert depth[24, 32] == pytest.approx(2.0, abs=0.01)
    assert opened == ["render"]


@needs_opengl
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_in_the_copy_that_a_fork_makes_a_picture_is_an_error_and_not_a_wait_for_ever() -> None:
    simulation = simulation_of(ROOM)
    camera = camera_of(simulation)
    camera.picture()
    child = os.fork()
    if child == 0:
        signal.alarm(30)
        told = ""
        with suppress(BaseException):
            try:
                camera.picture()
            except RenderError as error:
                told = str(error)
        os._exit("'spawn' or 'forkserver'" in told)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1
    assert camera.picture().rgb.any()


@needs_opengl
def test_the_driver_tells_its_renderer_and_the_version_of_opengl() -> None:
    assert re.fullmatch(r"\S.*, [1-9]\.\d.*", opengl.driver())
