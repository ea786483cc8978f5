"""Bodies with a surface velocity, and what lies on them. Numbers are from mechanics, and from Isaac Sim's tests of conveyors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graphengine.descriptions.engine import body_names
from graphengine.devices.backend import World
from graphengine.devices.entity import Move
from graphengine.devices.rotation import Vector3
from graphengine.format.errors import ContextError, PhysicsError
from graphengine.physics.simulation import Simulation
from tests.physics.dynamics.things import add, run, world
from tests.physics.harness import SCENE, Project

BELT = '<body name="belt"><geom type="box" size=".5 .5 .5" friction="{}"/></body>'
CUBE = '<body name="cube" pos="0 0 {}"><freejoint/><geom type="box" size=".05 .05 .05" mass="{}" friction="{}"/></body>'
STILL = (0.0, 0.0, 0.0)


@pytest.fixture
def project(project: Project) -> Project:
    """Without a robot."""
    return project.write("scene.yaml", "scene: test\nworld: world.xml\n")


def conveyor(
    project: Project, *, mass: float = 1.0, friction: float = 0.5, more: str = "", options: str = ""
) -> Simulation:
    """Isaac Sim's test: a cube of 1 m, and one of 0.1 m on top of it."""
    things = BELT.format(friction) + CUBE.format(0.55, mass, friction) + more
    return world(project, things, options=options).simulation


def move(simulation: World, linear: Vector3 = STILL, angular: Vector3 = STILL, body: str = "belt") -> None:
    simulation.conveyor(simulation.stage.find(f"/World/{body}")).move(linear, angular)


def velocity(simulation: Simulation, body: str = "cube") -> Vector3:
    return simulation.entities.state(body).linear_velocity


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-0.6, 0.8, 0.0)])
def test_a_cube_reaches_the_speed_of_the_belt(project: Project, direction: Vector3) -> None:
    simulation = conveyor(project)
    x, y, z = (0.1 * part for part in direction)
    move(simulation, (x, y, z))
    run(simulation, 1.0)
    assert velocity(simulation) == pytest.approx((x, y, z), abs=1e-6)  # Isaac Sim's test allows 1e-2
    assert simulation.entities.state("belt").position == (0.0, 0.0, 0.0)
    assert [entity.kind for entity in simulation.entities.all()] == ["static", "object"]


@pytest.mark.parametrize("friction", [0.2, 0.5])
@pytest.mark.parametrize("mass", [0.01, 1.0, 50.0])
@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
def test_a_belt_acts_on_a_cube_as_the_floor_on_one_that_slides_the_other_way(
    project: Project, friction: float, mass: float, cone: str
) -> None:
    speeds: list[float] = []
    for belt in (2.0, 0.0):
        simulation = conveyor(project, mass=mass, friction=friction, options=f'<option cone="{cone}"/>')
        run(simulation, 0.5)
        if belt:
            move(simulation, (belt, 0.0, 0.0))
        else:
            simulation.entities.place("cube", Move(linear=(-2.0, 0.0, 0.0)))
        run(simulation, 0.1)
        speeds.append(belt - velocity(simulation)[0])
    assert 1.4 < speeds[0] < 1.9
    assert speeds[0] == pytest.approx(speeds[1], abs=1e-5)


def test_a_surface_turns_about_the_origin_of_its_body(project: Project) -> None:
    simulation = conveyor(project, more=CUBE.format(0.551, 1.0, 0.5).replace("cube", "aside").replace("0 0", "0.3 0"))
    move(simulation, angular=(0.0, 0.0, 0.4))
    run(simulation, math.pi / 2 / 0.4)
    state = simulation.entities.state("aside")
    assert state.position[:2] == pytest.approx((0.0, 0.3), abs=0.01)
    assert state.linear_velocity[:2] == pytest.approx((-0.12, 0.0), abs=0.005)
    assert state.angular_velocity[2] == pytest.approx(0.4, abs=0.01)
    assert simulation.entities.state("cube").angular_velocity[2] == pytest.approx(0.4, abs=0.01)


def test_the_velocity_is_in_the_frame_of_the_body(project: Project) -> None:
    turned = BELT.format(0.5).replace('name="belt"', 'name="belt" euler="0 0 90"')
    simulation = world(project, turned + CUBE.format(0.55, 1.0, 0.5)).simulation
    move(simulation, (0.1, 0.0, 0.0))
    run(simulation, 1.0)
    assert velocity(simulation) == pytest.approx((0.0, 0.1, 0.0), abs=1e-6)


def test_a_cube_at_a_stop_stays_while_the_belt_runs_below_it(project: Project) -> None:
    gate = '<body name="gate" pos=".15 0 .6"><geom type="box" size=".05 .3 .1"/></body>'
    simulation = conveyor(project, more=gate)
    move(simulation, (0.2, 0.0, 0.0))
    run(simulation, 2.0)
    assert simulation.entities.state("cube").position == pytest.approx((0.05, 0.0, 0.55), abs=2e-3)


def test_a_belt_that_stops_brakes_and_a_reset_stops_it(project: Project) -> None:
    simulation = conveyor(project)
    move(simulation, (0.1, 0.0, 0.0))
    run(simulation, 1.0)
    move(simulation)
    run(simulation, 1.0)
    assert velocity(simulation) == pytest.approx(STILL, abs=1e-6)
    move(simulation, (0.1, 0.0, 0.0))
    simulation.reset()
    run(simulation, 1.0)
    assert velocity(simulation) == pytest.approx(STILL, abs=1e-6)


def test_a_starting_belt_wakes_sleeping_bodies(project: Project) -> None:
    simulation = conveyor(project, options='<option><flag sleep="enable"/></option>')
    move(simulation)
    run(simulation, 3.0)
    assert (simulation.data.tree_asleep >= 0).any()
    move(simulation, (0.1, 0.0, 0.0))
    run(simulation, 1.0)
    assert velocity(simulation)[0] == pytest.approx(0.1, abs=1e-6)


def test_a_checkpoint_goes_on_bit_by_bit_also_across_a_belt_that_came_later(project: Project) -> None:
    shelf = BELT.format(0.5).replace("belt", "other").replace('name="other"', 'name="other" pos="3 0 0"')
    simulation = conveyor(project, more=shelf)
    move(simulation, (0.1, 0.02, 0.0))
    run(simulation, 0.3)
    saved = simulation.save()
    run(simulation, 0.5)
    expected = simulation.entities.state("cube")
    move(simulation, (0.0, 0.0, 0.0))
    move(simulation, (1.0, 0.0, 0.0), body="other")
    for _ in range(2):
        simulation.restore(saved)
        assert list(simulation.surfaces.velocities) == ["belt"]
        run(simulation, 0.5)
        assert simulation.entities.state("cube") == expected


def test_a_robot_that_comes_and_goes_changes_nothing_on_the_belt(project: Project) -> None:
    ends: list[object] = []
    for busy in (False, True):
        loaded = world(project, BELT.format(0.5) + CUBE.format(0.55, 1.0, 0.5))
        move(loaded.simulation, (0.1, 0.0, 0.0))
        run(loaded.simulation, 0.2)
        if busy:
            add(loaded, "late")
        run(loaded.simulation, 0.2)
        if busy:
            loaded.remove("late")
        run(loaded.simulation, 0.2)
        ends.append(loaded.simulation.entities.state("cube"))
    assert ends[0] == ends[1]


def test_a_link_of_a_robot_can_be_a_belt(project: Project) -> None:
    """The arm of the cart lies still; a plate on it carries a cube along."""
    plate = """<link name="plate">
      <inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry><box size="1 1 .1"/></geometry></collision></link>"""
    project.cart('<link name="plate"/>', plate).robot(
        "fixed_base: true\njoints: {arm_joint: {enabled: false, weld: true}}"
    )
    project.world('<body name="cube" pos=".1 0 .75"><freejoint/><geom type="box" size=".05 .05 .05" mass="1"/></body>')
    project.write("scene.yaml", SCENE)
    simulation = project.load().simulation
    carrier = simulation.stage.find("/bot/plate")
    assert carrier.body is not None
    simulation.conveyor(carrier).move((0.0, -0.1, 0.0), STILL)  # the plate is turned by 90 degrees
    run(simulation, 1.0)
    assert velocity(simulation) == pytest.approx((0.1, 0.0, 0.0), abs=1e-4)


def test_a_body_that_a_joint_moves_cannot_be_a_belt(project: Project) -> None:
    simulation = conveyor(project)
    with pytest.raises(ContextError, match="/World/cube cannot be a conveyor: a joint moves it") as caught:
        move(simulation, body="cube")
    assert caught.value.help


@pytest.mark.parametrize("speed", [math.inf, math.nan, 1e4])
def test_a_speed_without_bounds_is_refused_and_changes_nothing(project: Project, speed: float) -> None:
    simulation = conveyor(project)
    move(simulation, (0.1, 0.0, 0.0))
    with pytest.raises(PhysicsError, match="may exceed 1000 m/s or rad/s"):
        move(simulation, (speed, 0.0, 0.0))
    assert simulation.surfaces.velocities["belt"] == ((0.1, 0.0, 0.0), STILL)


def test_without_a_belt_the_model_is_unchanged(project: Project) -> None:
    simulation = conveyor(project)
    assert not simulation.surfaces
    assert simulation.model.njnt == 1  # that of the cube
    before = body_names(simulation.model)
    move(simulation)
    assert body_names(simulation.model) == before
    assert np.array_equal(simulation.model.body_jntnum[simulation.model.body("belt").id], 6)
