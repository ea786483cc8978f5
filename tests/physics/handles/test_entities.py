"""Robots and objects as wholes: what they are called, how they move and how far they reach."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graphengine.devices.entity import Move
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import UnknownEntityError
from tests.physics.dynamics.things import BALL, DOOR, SHELF, SPACE, add, bounds, run, world
from tests.physics.harness import Project


def test_robots_come_first_and_then_the_bodies_of_the_world(project: Project) -> None:
    loaded = world(project, SHELF, BALL, DOOR)
    add(loaded, "late")
    found = [
        (entity.name, entity.prim_path, entity.kind, entity.spawned) for entity in loaded.simulation.entities.all()
    ]
    assert found == [
        ("bot", "/bot", "robot", False),
        ("late", "/late", "robot", True),
        ("shelf", "/World/shelf", "static", False),
        ("ball", "/World/ball", "object", False),
        ("door", "/World/door", "object", False),
    ]


def test_a_body_that_is_called_like_a_robot_goes_by_its_path(project: Project) -> None:
    loaded = world(project, BALL.replace("ball", "bot"))
    assert [entity.name for entity in loaded.simulation.entities.all()] == ["bot", "World/bot"]
    assert loaded.simulation.entities.state("World/bot").position == pytest.approx((5, 0, 1))
    assert loaded.simulation.entities.state("/World/bot") == loaded.simulation.entities.state("World/bot")


def test_a_robot_cannot_be_added_with_the_name_of_another_entity(project: Project) -> None:
    loaded = world(project, BALL)
    with pytest.raises(CheckError, match="'ball' is taken"):
        add(loaded, "ball")


def test_an_entity_that_is_not_there_is_an_error_with_the_nearest_name(project: Project) -> None:
    with pytest.raises(UnknownEntityError, match=r"no entity 'bal'\n  did you mean 'ball'\?"):
        world(project, BALL).simulation.entities.state("bal")


def test_an_object_in_free_fall_accelerates_with_gravity_and_one_at_rest_does_not(project: Project) -> None:
    simulation = world(project, BALL, SHELF).simulation
    run(simulation, 0.1)
    ball, shelf = simulation.entities.state("ball"), simulation.entities.state("shelf")
    assert ball.linear_velocity == pytest.approx((0, 0, -0.981), abs=1e-9)
    assert ball.linear_acceleration == pytest.approx((0, 0, -9.81), abs=1e-9)
    assert (*shelf.linear_acceleration, *shelf.linear_velocity) == (0,) * 6
    run(simulation, 2.0)
    assert simulation.entities.state("ball").linear_acceleration == pytest.approx((0, 0, 0), abs=1e-3)


def test_a_turning_body_accelerates_towards_its_axis_only(project: Project) -> None:
    """The geom hangs 0.5 m beside the body's origin, which so goes round it: w^2 r."""
    simulation = world(project, BALL.replace("<geom ", '<geom pos=".5 0 0" '), options=SPACE).simulation
    of_the_origin = (0, -1.5, 0)  # so that the centre rests
    simulation.entities.place("ball", Move((5, 0, 1), None, of_the_origin, (0, 0, 3.0)))
    state = simulation.entities.state("ball")
    assert state.angular_velocity == pytest.approx((0, 0, 3))
    assert state.linear_acceleration == pytest.approx((4.5, 0, 0))


@pytest.mark.parametrize(
    ("geom", "half"),
    [
        ('type="sphere" size=".3"', (0.3, 0.3, 0.3)),
        ('type="box" size="1 2 3"', (3 * math.sqrt(0.5), 3 * math.sqrt(0.5), 3)),
        ('type="capsule" size=".1 .5" euler="0 90 0"', (0.5 * math.sqrt(0.5) + 0.1, 0.5 * math.sqrt(0.5) + 0.1, 0.1)),
        ('type="cylinder" size=".1 .5"', (0.1, 0.1, 0.5)),
        ('type="ellipsoid" size="1 2 3"', (math.sqrt(2.5), math.sqrt(2.5), 3)),
        ('type="mesh" mesh="wedge"', (math.sqrt(0.5), 0.5 * math.sqrt(0.5), 0.5)),
    ],
)
def test_bounds_enclose_a_shape_that_is_turned_by_45_degrees(
    project: Project, geom: str, half: tuple[float, float, float]
) -> None:
    mesh = '<asset><mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/></asset>'
    body = f'<body name="thing" pos="9 9 9" euler="0 0 45"><geom {geom}/></body>'
    low, high = np.reshape(bounds(world(project, body, options=mesh).simulation, "thing"), (2, 3))
    assert (high - low) / 2 == pytest.approx(half)


def test_bounds_enclose_all_parts_of_an_entity_and_infinite_entities_have_none(project: Project) -> None:
    inner = '<body name="a" pos="0 0 1"><geom size=".1"/><body pos="0 3 0"><geom size=".2"/></body></body>'
    simulation = world(project, inner, '<body name="wall"><geom type="plane" size="0 0 1"/></body>').simulation
    assert bounds(simulation, "a") == pytest.approx((-0.2, -0.1, 0.8, 0.2, 3.2, 1.2))
    assert simulation.entities.bounds("wall") is None


def test_bounds_in_the_entitys_own_frame_do_not_depend_on_its_pose(project: Project) -> None:
    box = BALL.replace('<geom size=".1"', '<geom type="box" pos=".5 0 0" size="1 2 3"')
    simulation = world(project, box).simulation
    simulation.entities.place("ball", Move((7, 8, 9), (0.1, 0.2, 0.3, 0.4)))
    assert bounds(simulation, "ball", own=True) == pytest.approx((-0.5, -2, -3, 1.5, 2, 3))
