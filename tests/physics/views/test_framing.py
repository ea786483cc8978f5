"""Views of the robots: a camera that follows one, several robots in one image, and a world without sky and lights."""

from __future__ import annotations

import math
from contextlib import closing

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.devices.entity import Move
from graphengine.devices.rotation import Quaternion, rotate
from graphengine.physics.simulation import Simulation
from graphengine.physics.views import framing, tracking, views
from tests import arm_robot
from tests.physics.harness import SCENE, Project
from tests.physics.pictures.harness import camera_of, needs_opengl, simulation_of

pytestmark = needs_opengl
SIZE = (160, 90)
LOOKS_BACK: Quaternion = (0.0, 0.0, 1.0, 0.0)


def seen(simulation: Simulation, view: views.View, path: str = "/bot") -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the pixels of a robot."""
    with closing(views.ViewRenderer(simulation, shadow_map=64)) as renderer:
        image = renderer.draw(view, segmentation=True)
    assert image.segmentation is not None
    labels = simulation.studio.labels
    rows, columns = np.nonzero(np.isin(image.segmentation, [n for n, prim in labels.items() if prim.startswith(path)]))
    return rows, columns


def place(simulation: Simulation, **where: object) -> None:
    """Move the robot."""
    simulation.entities.place("bot", Move(**where))  # type: ignore[arg-type]
    simulation.refresh()


@pytest.mark.parametrize("turned", [(0.0, 0.0, 0.0, 1.0), LOOKS_BACK])
def test_a_camera_follows_from_behind_and_above(project: Project, turned: Quaternion) -> None:
    simulation = project.load().simulation
    place(simulation, position=(3.0, 2.0, 0.1), orientation=turned)
    view = views.find_view(simulation, "follow", SIZE)
    ahead = rotate(turned, (1.0, 0.0, 0.0))[0]
    x, y, z = view.pose[0]
    assert (x - 3.0) * ahead < -0.5
    assert y == pytest.approx(2.0, abs=0.05)
    assert z > 0.4
    assert rotate(view.pose[1], (0.0, 0.0, -1.0))[0] * ahead > 0.9
    rows, columns = seen(simulation, view)
    assert 0.25 <= np.ptp(rows) / 90 <= 0.4
    assert columns.mean() == pytest.approx(80, abs=4)
    assert rows.min() > 25  # its way is above it


@pytest.mark.parametrize("distance", [0.5, 0.8])
def test_a_camera_that_follows_comes_closer_before_a_wall(project: Project, distance: float) -> None:
    wall = f'<geom type="box" size=".02 3 3" pos="{-distance} 0 0"/>'
    free = views.find_view(project.load().simulation, "follow", SIZE)
    simulation = project.world(wall).load().simulation
    view = views.find_view(simulation, "follow", SIZE)
    assert free.pose[0][0] < -distance < view.pose[0][0]
    rows, _ = seen(simulation, view)
    assert len(rows) > len(seen(project.world().load().simulation, free)[0])


def test_a_camera_turns_and_moves_smoothly_in_the_time_of_the_simulation(project: Project) -> None:
    simulation = project.load().simulation
    camera = views.ViewCamera(simulation, "follow", SIZE)

    def azimuth(time: float) -> float:
        ahead = rotate(camera.view(time).pose[1], (0.0, 0.0, -1.0))
        return math.degrees(math.atan2(ahead[1], ahead[0]))

    assert azimuth(5.0) == pytest.approx(0.0, abs=0.01)
    quarter = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    place(simulation, orientation=quarter)
    left = math.exp(-0.1 / tracking.TURNING)
    assert azimuth(5.0) == pytest.approx(0.0, abs=0.01)
    assert azimuth(5.1) == pytest.approx(90 * (1 - left), abs=0.01)
    assert azimuth(5.2) == pytest.approx(90 * (1 - left**2), abs=0.01)
    assert azimuth(99.0) == pytest.approx(90.0, abs=0.01)
    before = camera.view(99.0)
    place(simulation, position=(1.0, 0.0, 0.1), orientation=quarter)
    moved = camera.view(99.1).centre[0] - before.centre[0]
    assert moved == pytest.approx(1 - math.exp(-0.1 / tracking.MOVING), abs=0.02)


def test_after_the_robot_was_removed_the_view_shows_the_world(project: Project) -> None:
    loaded = project.world('<geom type="box" size="1 1 1" pos="4 0 1"/>').load()
    camera = views.ViewCamera(loaded.simulation, "follow", SIZE)
    camera.view(0.0)
    loaded.remove("bot")
    assert camera.view(100.0).centre == pytest.approx((4.0, 0.0, 1.0), abs=1e-6)


def test_all_robots_of_a_scene_are_in_the_perspective_view(project: Project) -> None:
    more = "".join(
        f"  bot_{index}: {{use: bot.yaml, position: [{x}, {y}, 0.1]}}\n"
        for index, (x, y) in enumerate([(4, 0), (8, 1), (0, 5)])
    )
    simulation = project.scene(more).load().simulation
    view = views.find_view(simulation, "perspective", SIZE)
    places = [seen(simulation, view, f"/{robot.name}") for robot in simulation.stage.prims("robot")]
    assert len(places) == 4
    assert all(len(rows) > 15 for rows, _ in places)
    rows, columns = (np.concatenate(part) for part in zip(*places, strict=True))
    assert 0.8 < max(np.ptp(rows) / 90, np.ptp(columns) / 160) < 0.9


@pytest.mark.parametrize("name", ["perspective", "follow"])
def test_an_arm_is_shown_in_full_and_not_from_behind(project: Project, name: str) -> None:
    project.write("arm.urdf", arm_robot.urdf(shapes=True)).write("arm.yaml", arm_robot.robot_file())
    project.write("scene.yaml", SCENE.replace("bot: {use: bot.yaml", "arm: {use: arm.yaml"))
    simulation = project.load().simulation
    view = views.find_view(simulation, name, SIZE)
    assert view.pose[0][0] > 0.3  # the arm reaches along x
    rows, _ = seen(simulation, view, "/arm")
    assert 0.25 < np.ptp(rows) / 90 < 0.5


def test_the_view_frames_exactly_the_given_points() -> None:
    generator = np.random.default_rng(3)
    points, back = generator.normal(size=(50, 3)), framing.direction(0.7, 0.4)
    offset = framing.fitting_offset(points, np.zeros(3), back, (0.4, 0.2))
    seen = points @ framing.camera_axes(back).T - offset
    across = seen[:, :2] / -seen[:, 2:]
    assert (seen[:, 2] < 0).all()
    assert across.max(axis=0)[1] == pytest.approx(0.2)
    assert across.min(axis=0)[1] == pytest.approx(-0.2)
    assert np.abs(across[:, 0]).max() <= 0.4


def test_a_world_without_sky_and_lights_gets_both_in_views_only() -> None:
    plain = '<geom type="plane" size="2 2 1"/><body name="ball" pos="0 0 .5"><geom type="sphere" size=".5"/></body>'
    simulation = simulation_of(plain)
    picture = views.draw(simulation, views.find_view(simulation, "perspective", SIZE)).rgb.astype(int)
    assert picture[0, 0].min() > 130  # sky
    assert picture[0, 0, 2] >= picture[0, 0, 0]
    assert picture.sum(axis=2).min() > 60  # nothing is black
    sensor = camera_of(simulation).picture().rgb
    assert (sensor[0] == 0).all()  # what graphs receive stays as the world's file says
