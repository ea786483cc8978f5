"""Robots and objects that are put elsewhere, and what that does to all else."""

from __future__ import annotations

import math

import pytest

from graphengine.devices.entity import Move
from graphengine.format.errors import PhysicsError, UsageError
from graphengine.physics.sensors.imu import InertialUnit
from graphengine.physics.sensors.lidar import RayLidar
from graphengine.physics.simulation import Simulation
from tests.physics.conftest import Ship
from tests.physics.dynamics.things import BALL, DOOR, IMU, SHELF, SPACE, add, run, world
from tests.physics.harness import ROBOT, Project, ticks


def test_a_robot_is_put_elsewhere_with_its_joints_as_they_are(project: Project) -> None:
    simulation = world(project).simulation
    joints = simulation.articulation(simulation.stage.find("/bot"))
    simulation.data.qpos[7] = 0.5
    turned = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    simulation.entities.place("bot", Move((3, 4, 0.5), turned, (1, 0, 0), (0, 0, 2)))
    state = simulation.entities.state("bot")
    assert (*state.position, *state.orientation) == pytest.approx((3, 4, 0.5, *turned))
    assert (*state.linear_velocity, *state.angular_velocity) == pytest.approx((1, 0, 0, 0, 0, 2))
    assert joints.positions().tolist() == [0.5]
    plate = simulation.frame(simulation.stage.find("/bot/base_link/arm/plate")).pose()[0]
    assert plate == pytest.approx((3 + 0.0, 4 + 0.1 + 0.3 * math.sin(0.5), 0.6 + 0.3 * math.cos(0.5)))


def test_a_robot_whose_base_is_a_frame_is_placed_at_the_requested_pose_of_its_prim(ship: Ship) -> None:
    simulation = ship("dd100_flat.yaml").simulation
    simulation.entities.place("dd100", Move((2, -1, 0.1), (0, 0, 1, 0), (0.5, 0, 0), (0.1, 0.2, 0.3)))
    state = simulation.entities.state("dd100")
    assert (*state.position, *state.orientation) == pytest.approx((2, -1, 0.1, 0, 0, 1, 0), abs=1e-12)
    assert state.linear_velocity == pytest.approx((0.5, 0, 0))
    assert state.angular_velocity == pytest.approx((0.1, 0.2, 0.3))


def test_a_placed_body_rests_at_its_new_pose_unless_a_velocity_is_given(project: Project) -> None:
    simulation = world(project, BALL).simulation
    run(simulation, 0.2)
    simulation.entities.place("ball", Move((0, 5, 2)))
    state = simulation.entities.state("ball")
    assert state.position == pytest.approx((0, 5, 2))
    assert (*state.linear_velocity, *state.angular_velocity) == (0,) * 6


def test_to_be_put_elsewhere_is_no_motion_to_an_inertial_unit(project: Project) -> None:
    project.write("bot.yaml", ROBOT + IMU)
    simulation = world(project, options=SPACE).simulation
    unit = simulation.device(InertialUnit, simulation.stage.find("/bot/base_link/unit"))
    simulation.entities.place("bot", Move((9, 9, 9), (0, 0, 1, 0), (5, 0, 0)))
    ticks(simulation, 6)
    assert unit.sample().linear_acceleration == pytest.approx((0, 0, 0), abs=1e-9)


def test_placing_an_arm_that_is_bolted_to_the_world_is_no_shock_for_its_imu(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "fixed_base: true\n" + IMU)
    simulation = world(project).simulation
    unit = simulation.device(InertialUnit, simulation.stage.find("/bot/base_link/unit"))
    simulation.entities.place("bot", Move((9, 9, 9), (1, 0, 0, 0)))
    assert simulation.entities.state("bot").position == (9, 9, 9)
    assert simulation.frame(simulation.stage.find("/bot/base_link/unit")).pose()[0] == pytest.approx((9, 9, 8.7))
    ticks(simulation, 6)
    assert unit.sample().gravity == pytest.approx((0, 0, -9.81))


@pytest.mark.parametrize("sleep", ["auto", "init"])
def test_moving_a_bolted_body_lets_the_bodies_on_it_fall(project: Project, sleep: str) -> None:
    table = '<body name="table" pos="2 0 .5"><geom type="box" size=".2 .2 .5"/></body>'
    cup = f'<body name="cup" pos="2 0 1.05" sleep="{sleep}"><freejoint/><geom type="box" size=".05 .05 .05"/></body>'
    simulation = world(project, table, cup, options='<option><flag sleep="enable"/></option>').simulation
    run(simulation, 1.0)  # until the cup sleeps
    simulation.entities.place("table", Move((4, 1, 0.5)))
    assert simulation.entities.state("table").position == (4, 1, 0.5)
    run(simulation, 0.2)
    assert simulation.entities.state("cup").linear_velocity[2] == pytest.approx(-1.962, rel=0.05)
    run(simulation, 1.0)
    assert simulation.entities.state("cup").position == pytest.approx((2, 0, 0.05), abs=2e-3)


def test_a_sleeping_body_falls_when_its_support_is_moved_away(project: Project) -> None:
    boxes = "".join(
        f'<body name="{name}" pos="2 0 {z}"><freejoint/><geom type="box" size=".1 .1 .1"/></body>'
        for name, z in (("lower", 0.1), ("upper", 0.3))
    )
    simulation = world(project, boxes, options='<option><flag sleep="enable"/></option>').simulation
    run(simulation, 2.0)
    simulation.entities.place("lower", Move((5, 0, 0.1)))
    run(simulation, 1.0)
    assert simulation.entities.state("upper").position[2] == pytest.approx(0.1, abs=2e-3)


@pytest.mark.parametrize("fast", [True, False])
def test_a_lidar_sees_a_shelf_where_it_was_put(project: Project, fast: bool) -> None:
    project.robot("sensors: {eye: {type: lidar, profile: lidar_360, parent: base_link}}")
    simulation = world(project, '<body name="shelf" pos="3 0 0"><geom type="box" size=".5 1 1"/></body>').simulation
    simulation._rays_choice = "fast" if fast else "mujoco"
    eye = simulation.device(RayLidar, simulation.stage.find("/bot/base_link/eye/Lidar"))
    simulation.begin_tick(1)
    assert eye.scan().ranges[180] == pytest.approx(2.5, abs=1e-3)
    simulation.entities.place("shelf", Move((5, 0, 0)))
    simulation.begin_tick(7)
    assert eye.scan().ranges[180] == pytest.approx(4.5, abs=1e-3)


def test_a_shelf_stays_where_it_was_put_when_robots_come_and_go_and_reset_puts_it_back(project: Project) -> None:
    loaded = world(project, SHELF)
    simulation = loaded.simulation
    simulation.entities.place("shelf", Move((7, 7, 7), (0, 0, 1, 0)))
    add(loaded, "late")
    assert simulation.entities.state("shelf").position == (7, 7, 7)
    loaded.remove("late")
    assert simulation.entities.state("shelf").position == (7, 7, 7)
    simulation.reset()
    state = simulation.entities.state("shelf")
    assert (state.position, state.orientation) == ((1, 2, 3), (0, 0, 0, 1))
    add(loaded, "later")
    assert simulation.entities.state("shelf").position == (1, 2, 3)


def hold_ball(simulation: Simulation) -> None:
    ball = simulation.placement(simulation.stage.find("/World/ball"))
    assert ball is not None
    ball.place((0, 5, 2), (0, 0, 0, 1))


def test_placing_a_held_body_elsewhere_ends_the_hold(project: Project) -> None:
    loaded = world(project, BALL)
    hold_ball(loaded.simulation)
    loaded.simulation.entities.place("ball", Move((0, 7, 2)))
    run(loaded.simulation, 0.1)
    assert loaded.simulation.entities.state("ball").linear_velocity[2] == pytest.approx(-0.981)


def test_a_held_body_stays_held_when_a_shelf_is_moved(project: Project) -> None:
    simulation = world(project, BALL, SHELF).simulation
    loose = simulation.model.dof_armature.copy()
    hold_ball(simulation)
    firm = simulation.model.dof_armature.copy()
    simulation.entities.place("shelf", Move((7, 7, 7)))
    run(simulation, 0.1)
    assert simulation.entities.state("ball").position == pytest.approx((0, 5, 2))
    assert simulation.model.dof_armature.tolist() == firm.tolist() != loose.tolist()
    simulation.reset()
    assert simulation.model.dof_armature.tolist() == loose.tolist()


def test_a_shelf_stays_where_it_was_if_physics_refuses_its_new_pose(
    project: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = world(project, SHELF)
    simulation = loaded.simulation

    def refuse(*_: object) -> None:
        raise PhysicsError("at t = 0 MuJoCo gave up")

    simulation.entities.place("shelf", Move((7, 7, 7)))
    monkeypatch.setattr(simulation, "rebind", refuse)
    with pytest.raises(UsageError, match="shelf cannot be placed at this pose: at t = 0 MuJoCo gave up"):
        simulation.entities.place("shelf", Move((8, 8, 8)))
    monkeypatch.undo()
    add(loaded, "late")
    assert simulation.entities.state("shelf").position == (7, 7, 7)


def test_reset_puts_everything_back_bit_by_bit(project: Project) -> None:
    simulation = world(project, BALL, SHELF).simulation

    def course() -> bytes:
        run(simulation, 0.3)
        data = simulation.data
        return b"".join(array.tobytes() for array in (data.qpos, data.qvel, data.xpos))

    first = course()
    simulation.entities.place("bot", Move((3, 3, 1), None, (1, 1, 1), (1, 1, 1)))
    simulation.entities.place("shelf", Move((0, 0, 3)))
    simulation.entities.push("ball", (10, 0, 0), 5.0)
    run(simulation, 0.1)
    simulation.reset()
    assert course() == first


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("ball", {"position": (math.nan, 0, 0)}, "invalid position nan"),
        ("ball", {"position": (0, math.inf, 0)}, "invalid position inf"),
        ("ball", {"position": (0, 0, 1e7)}, "invalid position 1e.07; legal: at most 1e.06"),
        ("ball", {"orientation": (0, 0, 0, 0)}, "is not an orientation"),
        ("ball", {"orientation": (0, 0, 0, math.nan)}, "invalid orientation nan"),
        ("ball", {"linear": (0, 0, math.inf)}, "invalid velocity inf"),
        ("shelf", {"linear": (1, 0, 0)}, "fixed to the world"),
        ("door", {"position": (0, 0, 0)}, "it is attached to joint 'hinge' of the world"),
    ],
)
def test_a_body_that_cannot_be_placed_stays_where_it_is(
    project: Project, name: str, arguments: dict[str, tuple[float, ...]], words: str
) -> None:
    simulation = world(project, BALL, SHELF, DOOR).simulation
    before = simulation.entities.state(name)
    with pytest.raises(UsageError, match=words):
        simulation.entities.place(name, Move(**arguments))  # type: ignore[arg-type]
    assert simulation.entities.state(name) == before
