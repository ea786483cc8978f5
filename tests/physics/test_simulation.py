"""What a simulation promises whatever is simulated: the same again, fresh values, handles that last."""

from __future__ import annotations

import hashlib
import math
from fractions import Fraction

import mujoco
import numpy as np
import pytest

from graphengine.format.spec import RobotUse
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.sensors.contact import BodyContactSensor
from graphengine.physics.sensors.lidar import RayLidar
from tests.physics.conftest import Ship
from tests.physics.harness import Project, steps

LIDAR = "/dd100/base_link/chassis_link/sim_lidar/Lidar"


def trajectory(world: LoadedWorld, ticks: int = 40) -> str:
    """Digest of everything that can be read in a short drive."""
    simulation, stage = world.simulation, world.stage
    joints = simulation.articulation(stage.find("/dd100"))
    base, lidar = simulation.body(stage.find("/dd100/base_link")), simulation.device(RayLidar, stage.find(LIDAR))
    digest = hashlib.sha256()
    for tick in range(1, ticks + 1):
        steps(simulation, simulation.substeps)
        simulation.begin_tick(tick)
        joints.select().command(velocities=[10 * math.sin(tick), 5.0])
        digest.update(repr((base.pose(), base.velocity())).encode())
        digest.update(joints.positions().tobytes() + joints.velocities().tobytes() + joints.efforts().tobytes())
        if lidar.due:
            digest.update(lidar.scan().ranges.tobytes())
    return digest.hexdigest()


def test_two_worlds_of_one_scene_are_the_same_bit_by_bit_and_so_is_one_after_reset(ship: Ship) -> None:
    one, other = ship("dd100_warehouse.yaml"), ship("dd100_warehouse.yaml")
    first = trajectory(one)
    assert trajectory(other) == first
    one.simulation.reset()
    assert trajectory(one) == first


def test_a_reset_returns_to_the_settled_state(ship: Ship) -> None:
    world = ship("dd100_flat.yaml")
    base = world.simulation.body(world.stage.find("/dd100"))
    start = base.pose()
    trajectory(world)
    assert base.pose() != start
    world.simulation.reset()
    assert base.pose() == start
    assert world.simulation.time == 0.0


def test_the_order_of_half_steps_is_that_of_mj_step_bit_by_bit(ship: Ship) -> None:
    world = ship("dd100_flat.yaml")
    model = world.simulation.model
    reference = mujoco.MjData(model)
    for name in ("qpos", "qvel", "qacc_warmstart", "ctrl"):
        getattr(reference, name)[:] = getattr(world.simulation.data, name)
    for _ in range(50):
        world.simulation.step()
        mujoco.mj_step(model, reference)
    np.testing.assert_array_equal(world.simulation.data.qpos, reference.qpos)


def test_the_tick_period_is_exact(project: Project) -> None:
    simulation = project.scene("physics: {tick_rate: 59.94, substeps: 3}\n").load().simulation
    assert Fraction(*simulation.tick_period) == 1 / Fraction("59.94")
    assert simulation.substeps == 3
    assert simulation.model.opt.timestep == pytest.approx(1 / (59.94 * 3), rel=1e-15)


def test_a_prim_without_a_body_of_its_own_moves_with_the_one_that_carries_it(project: Project) -> None:
    """The plate is 0.3 m above the arm's joint and turned by 90 degrees; it has no mass, so MuJoCo never sees it."""
    world = project.load()
    plate = world.stage.find("/bot/base_link/arm/plate")
    assert plate.body is None
    position, orientation = world.simulation.frame(plate).pose()
    assert position == pytest.approx((0.1, 0.0, 0.1 + 0.1 + 0.3))
    assert orientation == pytest.approx((0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)))


def test_bodies_of_the_world_are_prims_and_stand_still_or_move(project: Project) -> None:
    shelf = '<body name="shelf" pos="1 2 3"><geom size=".1"/><body pos="0 0 1"><geom size=".1"/></body></body>'
    world = project.world(shelf, '<body name="ball" pos="5 0 1"><freejoint/><geom size=".1"/></body>').load()
    inner = world.stage.find("/World/shelf").children
    assert [prim.kind for prim in inner.values()] == ["body"]
    assert world.simulation.frame(next(iter(inner.values()))).pose()[0] == pytest.approx((1, 2, 4))
    ball = world.simulation.body(world.stage.find("/World/ball"))
    steps(world.simulation, 24)
    assert ball.velocity()[0][2] == pytest.approx(-0.981, rel=0.01)
    assert world.simulation.body(world.stage.find("/World")).velocity() == ((0, 0, 0), (0, 0, 0))


def test_handles_outlive_a_model_that_is_compiled_anew(project: Project) -> None:
    sensors = "sensors: {eye: {type: lidar, profile: lidar_360, parent: base_link}}"
    world = project.robot(f"{sensors}\njoints: {{arm_joint: {{drive: {{damping: 1.0}}}}}}").load()
    simulation, robot = world.simulation, world.stage.find("/bot")
    arm, base = simulation.articulation(robot), simulation.body(robot)
    eye = simulation.device(RayLidar, world.stage.find("/bot/base_link/eye/Lidar"))
    before = base.pose()
    world.add("other", RobotUse(use="bot.yaml", position=(2.0, 0.0, 0.1)))
    assert base.pose() == before
    simulation.reset()
    assert base.pose() == before
    simulation.begin_tick(1)
    assert eye.scan().ranges[180] == pytest.approx(1.8, abs=1e-6)  # straight ahead, to the side of a box of 0.4 m
    arm.select().command(velocities=[0.5])
    steps(simulation, 10)
    assert arm.velocities() == pytest.approx([0.5], rel=0.2)
    assert simulation.articulation(world.stage.find("/other")).velocities() == pytest.approx([0.0], abs=0.05)


def test_a_joint_whose_limits_leave_out_zero_begins_at_the_nearer_one(project: Project) -> None:
    cart = (project.folder / "bot.urdf").read_text()
    world = project.write("bot.urdf", cart.replace('lower="-1" upper="1"', 'lower="0.4" upper="1"')).load()
    arm = world.simulation.articulation(world.stage.find("/bot"))
    assert arm.positions().tolist() == [0.4]
    world.add("other", RobotUse(use="bot.yaml", position=(2.0, 0.0, 0.1)))
    assert world.simulation.articulation(world.stage.find("/other")).positions().tolist() == [0.4]


def test_settling_ends_although_a_body_never_comes_to_rest(project: Project) -> None:
    wheel = '<body name="wheel" pos="3 0 1"><joint damping="0"/><geom type="cylinder" size=".1 .1"/></body>'
    pendulum = '<body name="pendulum" pos="3 0 9"><joint axis="0 1 0"/><geom pos="1 0 0" size=".1"/></body>'
    project.scene("settle: true\n").world('<body pos="9 9 9"/>', wheel, before="<keyframe/>")
    assert project.load().simulation.settled_after is not None
    world, findings = project.world(pendulum).load_with_findings()
    assert world.simulation.settled_after is None
    assert "not at rest after 5 s" in findings.items[-1].message
    assert findings.items[-1].help == ("pendulum moves, and touches nothing",)


def test_settling_does_not_hide_an_initial_overlap_of_a_robot(project: Project) -> None:
    box = '<geom name="plate" type="box" size=".1 .1 .05" pos="0 0 .05"/>'
    _, findings = project.scene("settle: true\n").world(box).load_with_findings()
    assert [(finding.code, finding.message) for finding in findings.warnings] == [
        ("W210", "bot touches plate at the start, 50 mm deep")
    ]


def test_closing_twice_is_safe(ship: Ship) -> None:
    world = ship("dd100_flat.yaml")
    world.simulation.close()
    world.simulation.close()


@pytest.mark.parametrize("world", ["full_warehouse", "simple_warehouse"])
def test_robots_never_sleep_although_loose_bodies_in_both_halls_do(project: Project, world: str) -> None:
    # one with drives, and one with none at all, whose contact sensor feels its weight after seconds of rest
    touch = "sensors: {touch: {type: contact, profile: contact, parent: base_link}}\n"
    project.write("idle.yaml", "robot: bot\nurdf: bot.urdf\n" + touch)
    robots = "  dd100: {use: robots/dd100.yaml, position: [-5, 10, 0.025]}\n  idle: {use: idle.yaml, position: [-3, 6, 0.05]}\n"
    loaded = project.write("scene.yaml", f"scene: t\nworld: worlds/{world}.xml\nsettle: true\nrobots:\n{robots}").load()
    simulation, stage = loaded.simulation, loaded.stage
    touching = simulation.device(BodyContactSensor, stage.find("/idle/base_link/touch"))
    steps(simulation, 720)
    simulation.begin_tick(180)
    model, data = simulation.model, simulation.data
    names = [model.body(int(body)).name for body in model.tree_bodyadr]
    asleep = {name for name, state in zip(names, data.tree_asleep.tolist(), strict=True) if state >= 0}
    assert set(names) - asleep == {"dd100/base_link", "idle/base_link"}
    assert touching.reading().force == pytest.approx(6 * 9.81, rel=1e-3)
    simulation.articulation(stage.find("/idle")).select().command(efforts=[0.05])
    simulation.articulation(stage.find("/dd100")).select().command(velocities=[10.0, 10.0])
    before = simulation.body(stage.find("/dd100")).pose()[0]
    steps(simulation, 24)
    assert simulation.articulation(stage.find("/idle")).positions()[0] > 0.01
    assert math.dist(before, simulation.body(stage.find("/dd100")).pose()[0]) > 0.02


@pytest.mark.parametrize("sleep", ["auto", "init"])
def test_a_change_of_gravity_wakes_sleeping_bodies(project: Project, sleep: str) -> None:
    crate = f'<body name="crate" pos="3 0 .1" sleep="{sleep}"><freejoint/><geom type="box" size=".1 .1 .1"/></body>'
    loaded = project.world(crate, before='<option><flag sleep="enable"/></option>').load()
    simulation, crate_body = loaded.simulation, loaded.simulation.body(loaded.stage.find("/World/crate"))
    steps(simulation, 480)
    simulation.set_gravity(simulation.gravity)
    assert (simulation.data.tree_asleep >= 0).any()
    simulation.set_gravity((0.0, 0.0, 2.0))
    steps(simulation, 24)
    assert crate_body.velocity()[0] == pytest.approx((0.0, 0.0, 24 * 2.0 * simulation.model.opt.timestep), abs=0.01)
    simulation.reset()
    steps(simulation, 480)
    assert (simulation.data.tree_asleep >= 0).any()
