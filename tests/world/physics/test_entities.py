"""Robots and objects as wholes: their names, where they are, put elsewhere and pushed."""

from __future__ import annotations

import math
from fractions import Fraction

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.context import Vector3
from graphengine.diagnostics import CheckError, Findings, PhysicsError, UnknownEntityError, UsageError
from graphengine.spec import RobotUse
from graphengine.stage import Stage
from graphengine.world.loading import LoadedWorld
from graphengine.world.population import Population
from graphengine.world.simulation import Simulation
from tests.world.conftest import Ship
from tests.world.harness import ROBOT, Project

BALL = '<body name="ball" pos="5 0 1"><freejoint/><geom size=".1" mass="2"/></body>'
SHELF = '<body name="shelf" pos="1 2 3"><geom type="box" size=".1 .2 .3"/></body>'
DOOR = '<body name="door" pos="8 0 1"><joint name="hinge" axis="0 0 1"/><geom type="box" pos=".4 0 0" size=".4 .05 .9"/></body>'
SPACE = '<option gravity="0 0 0"/>'
IMU = "sensors: {unit: {type: imu, profile: imu, parent: base_link, position: [0, 0, 0.3]}}\n"


def world(project: Project, *bodies: str, options: str = "") -> LoadedWorld:
    floor = '<geom name="floor" type="plane" size="0 0 1" friction="0.8"/>'
    project.write("world.xml", f"<mujoco>{options}<worldbody>{floor}{''.join(bodies)}</worldbody></mujoco>")
    return project.load()


def run(simulation: Simulation, seconds: float) -> None:
    for _ in range(round(seconds / simulation.model.opt.timestep)):
        simulation.step()


def add(loaded: LoadedWorld, name: str, x: float = -4.0) -> None:
    Population(loaded).add(name, RobotUse(use="bot.yaml", position=(x, 0.0, 0.1)), Findings())


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


def test_nobody_comes_by_the_name_of_a_thing_that_is_there(project: Project) -> None:
    loaded = world(project, BALL)
    with pytest.raises(CheckError, match="'ball' is taken"):
        add(loaded, "ball")


def test_an_entity_that_is_not_there_is_an_error_with_the_nearest_name(project: Project) -> None:
    with pytest.raises(UnknownEntityError, match=r"no entity 'bal'\n  did you mean 'ball'\?"):
        world(project, BALL).simulation.entities.state("bal")


def test_a_thing_in_free_fall_accelerates_with_gravity_and_one_at_rest_does_not(project: Project) -> None:
    simulation = world(project, BALL, SHELF).simulation
    run(simulation, 0.1)
    ball, shelf = simulation.entities.state("ball"), simulation.entities.state("shelf")
    assert ball.linear_velocity == pytest.approx((0, 0, -0.981), abs=1e-9)
    assert ball.linear_acceleration == pytest.approx((0, 0, -9.81), abs=1e-9)
    assert (*shelf.linear_acceleration, *shelf.linear_velocity) == (0,) * 6
    run(simulation, 2.0)
    assert simulation.entities.state("ball").linear_acceleration == pytest.approx((0, 0, 0), abs=1e-3)


def test_a_thing_that_turns_accelerates_towards_its_axis_alone(project: Project) -> None:
    """The geom hangs 0.5 m beside the body's origin, which so goes round it: w^2 r."""
    simulation = world(project, BALL.replace("<geom ", '<geom pos=".5 0 0" '), options=SPACE).simulation
    of_the_origin = (0, -1.5, 0)  # so that the centre rests
    simulation.entities.place("ball", (5, 0, 1), None, of_the_origin, (0, 0, 3.0))
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
    bounds = world(project, body, options=mesh).simulation.entities.bounds("thing")
    assert bounds is not None
    assert np.subtract(bounds.high, bounds.low) / 2 == pytest.approx(half)


def test_bounds_hold_all_that_hangs_on_an_entity_and_what_has_no_end_has_none(project: Project) -> None:
    inner = '<body name="a" pos="0 0 1"><geom size=".1"/><body pos="0 3 0"><geom size=".2"/></body></body>'
    simulation = world(project, inner, '<body name="wall"><geom type="plane" size="0 0 1"/></body>').simulation
    bounds = simulation.entities.bounds("a")
    assert bounds is not None
    assert (*bounds.low, *bounds.high) == pytest.approx((-0.2, -0.1, 0.8, 0.2, 3.2, 1.2))
    assert simulation.entities.bounds("wall") is None


def test_bounds_in_its_own_frame_are_those_of_a_thing_however_it_stands(project: Project) -> None:
    simulation = world(
        project, BALL.replace('<geom size=".1"', '<geom type="box" pos=".5 0 0" size="1 2 3"')
    ).simulation
    simulation.entities.place("ball", (7, 8, 9), (0.1, 0.2, 0.3, 0.4))
    bounds = simulation.entities.bounds("ball", own=True)
    assert bounds is not None
    assert (*bounds.low, *bounds.high) == pytest.approx((-0.5, -2, -3, 1.5, 2, 3))


def test_a_robot_is_put_elsewhere_with_its_joints_as_they_are(project: Project) -> None:
    loaded = world(project)
    simulation = loaded.simulation
    joints = simulation.articulation(loaded.stage.find("/bot"))
    simulation.data.qpos[7] = 0.5
    turned = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    simulation.entities.place("bot", (3, 4, 0.5), turned, (1, 0, 0), (0, 0, 2))
    state = simulation.entities.state("bot")
    assert (*state.position, *state.orientation) == pytest.approx((3, 4, 0.5, *turned))
    assert (*state.linear_velocity, *state.angular_velocity) == pytest.approx((1, 0, 0, 0, 0, 2))
    assert joints.positions().tolist() == [0.5]
    plate = simulation.frame(loaded.stage.find("/bot/base_link/arm/plate")).pose()[0]
    assert plate == pytest.approx((3 + 0.0, 4 + 0.1 + 0.3 * math.sin(0.5), 0.6 + 0.3 * math.cos(0.5)))


def test_a_robot_whose_base_is_a_frame_on_what_moves_goes_where_its_prim_is_wanted(ship: Ship) -> None:
    simulation = ship("dd100_flat.yaml").simulation
    simulation.entities.place("dd100", (2, -1, 0.1), (0, 0, 1, 0), (0.5, 0, 0), (0.1, 0.2, 0.3))
    state = simulation.entities.state("dd100")
    assert (*state.position, *state.orientation) == pytest.approx((2, -1, 0.1, 0, 0, 1, 0), abs=1e-12)
    assert state.linear_velocity == pytest.approx((0.5, 0, 0))
    assert state.angular_velocity == pytest.approx((0.1, 0.2, 0.3))


def test_what_is_put_elsewhere_rests_there_unless_told_otherwise(project: Project) -> None:
    simulation = world(project, BALL).simulation
    run(simulation, 0.2)
    simulation.entities.place("ball", (0, 5, 2))
    state = simulation.entities.state("ball")
    assert state.position == pytest.approx((0, 5, 2))
    assert (*state.linear_velocity, *state.angular_velocity) == (0,) * 6


def test_to_be_put_elsewhere_is_no_motion_to_an_inertial_unit(project: Project) -> None:
    project.write("bot.yaml", ROBOT + IMU)
    loaded = world(project, options=SPACE)
    simulation = loaded.simulation
    unit = simulation.imu(loaded.stage.find("/bot/base_link/unit"))
    simulation.entities.place("bot", (9, 9, 9), (0, 0, 1, 0), (5, 0, 0))
    for tick in range(1, 7):
        run(simulation, 1 / 60)
        simulation.begin_tick(tick)
    assert unit.sample().linear_acceleration == pytest.approx((0, 0, 0), abs=1e-9)


def test_nor_is_it_to_that_of_an_arm_which_is_bolted_to_the_world(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "fixed_base: true\n" + IMU)
    loaded = world(project)
    simulation = loaded.simulation
    unit = simulation.imu(loaded.stage.find("/bot/base_link/unit"))
    simulation.entities.place("bot", (9, 9, 9), (1, 0, 0, 0))
    assert simulation.entities.state("bot").position == (9, 9, 9)
    assert simulation.frame(loaded.stage.find("/bot/base_link/unit")).pose()[0] == pytest.approx((9, 9, 8.7))
    for tick in range(1, 7):
        run(simulation, 1 / 60)
        simulation.begin_tick(tick)
    assert unit.sample().gravity == pytest.approx((0, 0, -9.81))


def test_what_is_bolted_to_the_world_is_moved_with_what_stands_on_it_falling(project: Project) -> None:
    table = '<body name="table" pos="2 0 .5"><geom type="box" size=".2 .2 .5"/></body>'
    cup = '<body name="cup" pos="2 0 1.05"><freejoint/><geom type="box" size=".05 .05 .05"/></body>'
    simulation = world(project, table, cup, options='<option><flag sleep="enable"/></option>').simulation
    run(simulation, 1.0)  # until the cup sleeps
    simulation.entities.place("table", (4, 1, 0.5))
    assert simulation.entities.state("table").position == (4, 1, 0.5)
    run(simulation, 0.2)
    assert simulation.entities.state("cup").linear_velocity[2] == pytest.approx(-1.962, rel=0.05)
    run(simulation, 1.0)
    assert simulation.entities.state("cup").position == pytest.approx((2, 0, 0.05), abs=2e-3)


def test_what_lies_on_a_thing_that_is_taken_away_falls_even_from_sleep(project: Project) -> None:
    boxes = "".join(
        f'<body name="{name}" pos="2 0 {z}"><freejoint/><geom type="box" size=".1 .1 .1"/></body>'
        for name, z in (("lower", 0.1), ("upper", 0.3))
    )
    simulation = world(project, boxes, options='<option><flag sleep="enable"/></option>').simulation
    run(simulation, 2.0)
    simulation.entities.place("lower", (5, 0, 0.1))
    run(simulation, 1.0)
    assert simulation.entities.state("upper").position[2] == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize("fast", [True, False])
def test_a_lidar_sees_a_shelf_where_it_was_put(project: Project, fast: bool) -> None:
    project.write("bot.yaml", ROBOT + "sensors: {eye: {type: lidar, profile: lidar_360, parent: base_link}}\n")
    loaded = world(project, '<body name="shelf" pos="3 0 0"><geom type="box" size=".5 1 1"/></body>')
    simulation = loaded.simulation
    simulation._rays_choice = "fast" if fast else "mujoco"
    eye = simulation.lidar(loaded.stage.find("/bot/base_link/eye/Lidar"))
    simulation.begin_tick(1)
    assert eye.scan().ranges[180] == pytest.approx(2.5, abs=1e-3)
    simulation.entities.place("shelf", (5, 0, 0))
    simulation.begin_tick(7)
    assert eye.scan().ranges[180] == pytest.approx(4.5, abs=1e-3)


def test_a_shelf_stays_where_it_was_put_when_robots_come_and_go_and_reset_puts_it_back(project: Project) -> None:
    loaded = world(project, SHELF)
    simulation = loaded.simulation
    simulation.entities.place("shelf", (7, 7, 7), (0, 0, 1, 0))
    add(loaded, "late")
    assert simulation.entities.state("shelf").position == (7, 7, 7)
    Population(loaded).remove("late")
    assert simulation.entities.state("shelf").position == (7, 7, 7)
    simulation.reset()
    state = simulation.entities.state("shelf")
    assert (state.position, state.orientation) == ((1, 2, 3), (0, 0, 0, 1))
    add(loaded, "later")
    assert simulation.entities.state("shelf").position == (1, 2, 3)


def test_a_body_that_is_held_is_let_go_when_it_is_put_elsewhere(project: Project) -> None:
    loaded = world(project, BALL)
    held = loaded.simulation.placement(loaded.stage.find("/World/ball"))
    assert held is not None
    held.place((0, 5, 2), (0, 0, 0, 1))
    loaded.simulation.entities.place("ball", (0, 7, 2))
    run(loaded.simulation, 0.1)
    assert loaded.simulation.entities.state("ball").linear_velocity[2] == pytest.approx(-0.981)


def test_a_body_that_is_held_stays_so_when_a_shelf_is_moved(project: Project) -> None:
    loaded = world(project, BALL, SHELF)
    simulation = loaded.simulation
    loose = simulation.model.dof_armature.copy()
    held = simulation.placement(loaded.stage.find("/World/ball"))
    assert held is not None
    held.place((0, 5, 2), (0, 0, 0, 1))
    firm = simulation.model.dof_armature.copy()
    simulation.entities.place("shelf", (7, 7, 7))
    run(simulation, 0.1)
    assert simulation.entities.state("ball").position == pytest.approx((0, 5, 2))
    assert simulation.model.dof_armature.tolist() == firm.tolist() != loose.tolist()
    simulation.reset()
    assert simulation.model.dof_armature.tolist() == loose.tolist()


def test_a_shelf_that_physics_does_not_want_there_stays_where_it_was(
    project: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = world(project, SHELF)
    simulation = loaded.simulation

    def refuse(*_: object) -> None:
        raise PhysicsError("at t = 0 MuJoCo gave up")

    simulation.entities.place("shelf", (7, 7, 7))
    monkeypatch.setattr(simulation, "rebind", refuse)
    with pytest.raises(UsageError, match="shelf cannot be there: at t = 0 MuJoCo gave up"):
        simulation.entities.place("shelf", (8, 8, 8))
    monkeypatch.undo()
    add(loaded, "late")
    assert simulation.entities.state("shelf").position == (7, 7, 7)


def test_reset_puts_everything_back_bit_by_bit(project: Project) -> None:
    loaded = world(project, BALL, SHELF)
    simulation = loaded.simulation

    def course() -> bytes:
        run(simulation, 0.3)
        data = simulation.data
        return b"".join(array.tobytes() for array in (data.qpos, data.qvel, data.xpos))

    first = course()
    simulation.entities.place("bot", (3, 3, 1), None, (1, 1, 1), (1, 1, 1))
    simulation.entities.place("shelf", (0, 0, 3))
    simulation.entities.push("ball", (10, 0, 0), 5.0)
    run(simulation, 0.1)
    simulation.reset()
    assert course() == first


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("ball", {"position": (math.nan, 0, 0)}, "no position is nan"),
        ("ball", {"position": (0, math.inf, 0)}, "no position is inf"),
        ("ball", {"position": (0, 0, 1e7)}, "no position is 1e.07; legal is up to 1e.06"),
        ("ball", {"orientation": (0, 0, 0, 0)}, "is none"),
        ("ball", {"orientation": (0, 0, 0, math.nan)}, "no orientation is nan"),
        ("ball", {"linear": (0, 0, math.inf)}, "no velocity is inf"),
        ("shelf", {"linear": (1, 0, 0)}, "bolted to the world"),
        ("door", {"position": (0, 0, 0)}, "hangs on joint 'hinge'"),
    ],
)
def test_what_cannot_be_placed_so_stays_where_it_is(
    project: Project, name: str, arguments: dict[str, tuple[float, ...]], words: str
) -> None:
    simulation = world(project, BALL, SHELF, DOOR).simulation
    before = simulation.entities.state(name)
    with pytest.raises(UsageError, match=words):
        simulation.entities.place(name, **arguments)  # type: ignore[arg-type]
    assert simulation.entities.state(name) == before


@settings(deadline=None)
@given(duration=st.floats(1e-4, 0.5), force=st.tuples(*[st.floats(-100, 100)] * 3))
def test_the_impulse_of_a_push_is_force_times_duration(duration: float, force: Vector3) -> None:
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{SPACE}<worldbody>{BALL}</worldbody></mujoco>")
    stage = Stage()
    stage.add("/World/ball", "body", body="ball")
    simulation = Simulation(model, stage, Fraction(1, 1) / Fraction(repr(model.opt.timestep)), 1)
    simulation.entities.push("ball", force, duration)
    run(simulation, duration + 0.02)
    state = simulation.entities.state("ball")
    assert state.linear_velocity == pytest.approx([f * duration / 2.0 for f in force], rel=1e-9, abs=1e-9)
    assert state.angular_velocity == pytest.approx((0, 0, 0), abs=1e-12)


def test_pushes_add_up_and_those_beside_the_centre_of_mass_turn(project: Project) -> None:
    simulation = world(project, BALL, options=SPACE).simulation
    simulation.entities.push("ball", (4, 0, 0), 0.1, (5, 0.1, 1))
    simulation.entities.push("ball", (0, 2, 0), 0.1)
    run(simulation, 1 / 240)
    inertia = 0.4 * 2.0 * 0.1**2
    assert simulation.entities.state("ball").angular_velocity == pytest.approx((0, 0, -0.4 / 240 / inertia))
    assert simulation.entities.state("ball").linear_acceleration == pytest.approx((2, 1, 0), rel=1e-3)
    run(simulation, 0.2)
    assert simulation.entities.state("ball").linear_velocity == pytest.approx((0.2, 0.1, 0))
    assert not simulation.data.xfrc_applied.any()


def test_a_push_wakes_what_sleeps_with_its_whole_impulse(project: Project) -> None:
    ice = '<body name="puck" pos="5 0 .05"><freejoint/><geom type="box" size=".1 .1 .05" mass="2" friction="0 0 0"/></body>'
    simulation = world(project, ice, options='<option><flag sleep="enable"/></option>').simulation
    for geom in range(simulation.model.ngeom):
        simulation.model.geom_friction[geom, 0] = 1e-5
    run(simulation, 2.0)
    assert (simulation.data.tree_asleep >= 0).any()
    simulation.entities.push("puck", (6, 0, 0), 0.5)
    run(simulation, 0.5)
    assert simulation.entities.state("puck").linear_velocity[0] == pytest.approx(1.5, rel=1e-3)


def test_a_push_goes_on_when_others_come_and_go_and_ends_with_its_entity(project: Project) -> None:
    loaded = world(project, BALL, options=SPACE)
    simulation = loaded.simulation
    add(loaded, "late")
    simulation.entities.push("ball", (4, 0, 0), 0.5)
    simulation.entities.push("late", (4, 0, 0), 0.5)
    run(simulation, 0.25)
    Population(loaded).remove("late")
    run(simulation, 0.5)
    assert simulation.entities.state("ball").linear_velocity == pytest.approx((1, 0, 0))
    assert not simulation.data.xfrc_applied.any()


@pytest.mark.parametrize(
    ("name", "force", "duration", "point", "words"),
    [
        ("ball", (math.nan, 0, 0), 1.0, None, "no force is nan"),
        ("ball", (1e9, 0, 0), 1.0, None, "no force is 1e.09"),
        ("ball", (1, 0, 0), 0.0, None, "lasts longer than 0 s"),
        ("ball", (1, 0, 0), math.inf, None, "no duration is inf"),
        ("ball", (1, 0, 0), 1.0, (0, 0, math.nan), "no point is nan"),
        ("shelf", (1, 0, 0), 1.0, None, "bolted to the world"),
    ],
)
def test_a_push_that_cannot_be_is_refused(
    project: Project, name: str, force: Vector3, duration: float, point: Vector3 | None, words: str
) -> None:
    simulation = world(project, BALL, SHELF).simulation
    with pytest.raises(UsageError, match=words):
        simulation.entities.push(name, force, duration, point)
    assert not simulation.data.xfrc_applied.any()


# What is put into something


BLOCK = '<body name="{}" pos="{} 0 .5"><freejoint/><geom type="box" size=".5 .5 .5" mass="10"/></body>'


def test_what_is_put_into_something_overlaps_with_it_as_deep_as_it_is_in_there(project: Project) -> None:
    wall = '<body name="wall" pos="5 0 0"><geom type="box" size=".5 5 5"/></body>'
    simulation = world(project, wall, BLOCK.format("block", 2)).simulation
    assert simulation.entities.overlaps("block") == []
    simulation.entities.place("block", (4.12, 0, 0.48))
    deepest, other = simulation.entities.overlaps("block")
    assert (deepest.other, other.other) == ("wall", "floor")
    assert (deepest.depth, other.depth) == pytest.approx((0.12, 0.02))
    assert simulation.entities.overlaps("bot") == []


def test_who_is_put_into_another_overlaps_with_it_and_it_with_them(project: Project) -> None:
    simulation = world(project, BLOCK.format("one", 2), BLOCK.format("two", 4)).simulation
    simulation.entities.place("one", (3.2, 0, 0.5))
    for name, other in (("one", "two"), ("two", "one")):
        (found,) = simulation.entities.overlaps(name)
        assert found.other == other
        assert found.depth == pytest.approx(0.2)


def test_what_rests_on_something_does_not_overlap_with_it(project: Project) -> None:
    simulation = world(project, BLOCK.format("block", 2), BLOCK.format("heavy", 4).replace("10", "1000")).simulation
    run(simulation, 0.5)
    assert simulation.entities.overlaps("block") == simulation.entities.overlaps("heavy") == []


def test_a_robot_that_comes_into_something_overlaps_with_it(project: Project) -> None:
    loaded = world(project, BLOCK.format("block", -4))
    add(loaded, "late", -3.4)
    (found,) = loaded.simulation.entities.overlaps("late")
    assert found.other == "block"
    assert found.depth == pytest.approx(0.1)


def test_an_arm_that_is_bolted_to_the_world_does_not_overlap_with_itself(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "fixed_base: true\n")
    loaded = world(project, BLOCK.format("block", 2))
    loaded.simulation.entities.place("bot", (1.4, 0, 0.5))
    (found,) = loaded.simulation.entities.overlaps("bot")
    assert found.other == "block"
    assert found.depth == pytest.approx(0.1)


def test_shapes_that_pass_through_each_other_do_not_overlap(project: Project) -> None:
    ghost = '<body name="ghost" pos="5 0 1"><geom type="box" size=".5 5 5" contype="0" conaffinity="0"/></body>'
    simulation = world(project, ghost, BLOCK.format("block", 2)).simulation
    simulation.entities.place("block", (5, 0, 0.5))
    assert simulation.entities.overlaps("block") == []
