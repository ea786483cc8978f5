"""Views for people: the robot from where nothing hides it, the world from above, and shadows."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.physics.pictures import opengl
from graphengine.physics.pictures.rendering import Renderer
from graphengine.physics.simulation import Simulation
from graphengine.physics.views import views
from tests.physics.harness import CART, SCENE, Project
from tests.physics.pictures.harness import needs_opengl, simulation_of

pytestmark = needs_opengl


def where_robot_is(simulation: Simulation, view: str) -> NDArray[np.bool_]:
    """The pixels of a view that show the robot."""
    image = views.draw(simulation, views.find_view(simulation, view, (160, 120)), segmentation=True)
    assert image.segmentation is not None
    robot = [number for number, path in simulation.studio.labels.items() if path.startswith("/bot")]
    return np.isin(image.segmentation, robot)


@pytest.mark.parametrize("wall", ["", '<geom type="box" size=".05 2 2" euler="0 0 35" pos=".7 .5 0"/>'])
def test_the_perspective_view_is_chosen_from_a_direction_in_which_no_body_hides_the_robot(
    project: Project, wall: str
) -> None:
    seen = where_robot_is(project.world(wall).load().simulation, "perspective")
    rows, columns = np.nonzero(seen)
    assert 0.04 < seen.mean() < 0.3
    assert 0.38 < max(np.ptp(rows) / 120, np.ptp(columns) / 160) < 0.44
    assert 70 < columns.mean() < 90
    assert 50 < rows.mean() < 70


@pytest.mark.parametrize("name", ["perspective", "top"])
def test_a_robot_whose_root_link_is_the_world_is_in_the_picture(project: Project, name: str) -> None:
    bolted = CART.replace(
        '<link name="plate"/>',
        '<link name="plate"/><link name="world"/>'
        '<joint name="bolts" type="fixed"><parent link="world"/><child link="base_link"/></joint>',
    )
    project.write("bot.urdf", bolted).robot("base_link: world")
    project.write("scene.yaml", SCENE.replace("[0, 0, 0.1]", "[30, 0, 0.1]"))
    seen = where_robot_is(project.load().simulation, name)
    assert seen.mean() > (0.02 if name == "perspective" else 0.0001)


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
    assert views.names(simulation) == ["top", "perspective", "follow"]


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
