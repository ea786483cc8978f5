"""How robots move: what they are told, and what they do."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from graphengine.devices.rotation import Vector3, unrotate
from graphengine.format.errors import BadValueError, JointError, PhysicsError
from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.simulation import Simulation
from tests.physics.conftest import Ship
from tests.physics.harness import Project, steps

Flat = tuple[Simulation, Joints]
WHEELS = ("front_left_wheel_joint", "front_right_wheel_joint")
TRUE = (0.049, 0.4523232)  # m: radius and track of the dd100's wheels
TUTORIAL = (0.1, 0.45)  # m: what the tutorial types into its controller


@pytest.fixture
def flat(ship: Ship) -> Flat:
    """A dd100 on a flat floor, and its joints."""
    simulation = ship("dd100_flat.yaml").simulation
    return simulation, simulation.articulation(simulation.stage.find("/dd100"))


def drive(world: LoadedWorld, linear: float, angular: float, geometry: tuple[float, float]) -> tuple[Vector3, Vector3]:
    """Mean twist of base_link in its own frame over a second, a second after the command."""
    radius, track = geometry
    simulation, stage = world.simulation, world.stage
    left, right = linear - angular * track / 2, linear + angular * track / 2
    wheels = simulation.articulation(stage.find("/dd100")).select(WHEELS)
    wheels.command(velocities=[left / radius, right / radius])
    base = simulation.body(stage.find("/dd100/base_link"))
    twists = []
    for step in range(480):
        simulation.step()
        if step >= 240:
            orientation = base.pose()[1]
            twists.append([unrotate(orientation, vector) for vector in base.velocity()])
    (vx, vy, vz), (wx, wy, wz) = np.mean(twists, axis=0).tolist()
    return (vx, vy, vz), (wx, wy, wz)


def test_the_dd100_moves_as_commanded_within_half_a_percent(ship: Ship) -> None:
    world = ship("dd100_flat.yaml")
    assert drive(world, 0.5, 0.0, TRUE)[0][0] == pytest.approx(0.5, rel=0.005)
    world.simulation.reset()
    assert drive(world, 0.0, 0.5, TRUE)[1][2] == pytest.approx(0.5, rel=0.005)
    world.simulation.reset()
    linear, angular = drive(world, 0.5, 0.5, TRUE)
    assert linear[0] == pytest.approx(0.5, rel=0.005)
    assert angular[2] == pytest.approx(0.5, rel=0.005)


def test_the_tutorials_robot_moves_at_half_of_the_commanded_speed(ship: Ship) -> None:
    world = ship("tutorial/flat_grid.yaml")
    assert drive(world, 0.5, 0.0, TUTORIAL)[0][0] / 0.5 == pytest.approx(0.049 / 0.1, rel=0.005)
    world.simulation.reset()
    ratio = 0.049 * 0.45 / (0.1 * 0.4523232)
    assert drive(world, 0.0, 0.5, TUTORIAL)[1][2] / 0.5 == pytest.approx(ratio, rel=0.005)


def test_base_link_moves_sideways_in_a_spin_as_it_lies_behind_the_axle(ship: Ship) -> None:
    linear, angular = drive(ship("dd100_flat.yaml"), 0.0, 0.5, TRUE)
    assert linear[1] == pytest.approx(-0.0989838 * angular[2], rel=0.005)


def test_the_velocity_of_a_mount_is_measured_at_the_mount(ship: Ship) -> None:
    world = ship("dd100_flat.yaml")
    drive(world, 0.0, 0.5, TRUE)
    base = world.simulation.body(world.stage.find("/dd100/base_link"))
    camera = world.simulation.body(world.stage.find("/dd100/base_link/chassis_link/sim_camera"))
    orientation = base.pose()[1]
    ahead = unrotate(orientation, camera.velocity()[0])[1] - unrotate(orientation, base.velocity()[0])[1]
    assert ahead == pytest.approx(0.3 * base.velocity()[1][2], rel=1e-5)
    assert camera.velocity()[1] == base.velocity()[1]


def test_velocities_are_the_slopes_of_poses(ship: Ship) -> None:
    world = ship("dd100_flat.yaml")
    drive(world, 0.5, 0.5, TRUE)
    lidar = world.simulation.body(world.stage.find("/dd100/base_link/chassis_link/sim_lidar/Lidar"))
    before = np.array(lidar.pose()[0])
    world.simulation.step()
    slope = (np.array(lidar.pose()[0]) - before) * 240
    np.testing.assert_allclose(lidar.velocity()[0], slope, atol=2e-3)


def test_the_dd100_stands_level_and_the_descriptions_caster_does_not(ship: Ship) -> None:
    """The caster reaches 2.24 mm lower than the wheels, 0.343 m behind them."""
    for name, expected in (("dd100_flat.yaml", 0.0), ("tutorial/flat_grid.yaml", math.atan2(0.00224, 0.343))):
        world = ship(name)
        x, y, z, w = world.simulation.body(world.stage.find("/dd100")).pose()[1]
        pitch = math.asin(2 * (w * y - z * x))
        assert pitch == pytest.approx(expected, abs=0.001)
        assert world.simulation.settled_after is not None


def test_the_tutorials_quick_test_moves_the_robot(project: Project) -> None:
    # "for both wheel joints, set the Target Velocity to 100", in degrees a second, on wheels of 0.049 m
    wheels = "".join(f"  {wheel}: {{usd_drive: {{target_velocity: 100.0}}}}\n" for wheel in WHEELS)
    project.write("bot.yaml", f"robot: dd100\nextends: robots/tutorial_dd100.yaml\njoints:\n{wheels}")
    project.write(
        "scene.yaml",
        "scene: test\nworld: worlds/flat_grid.xml\nsettle: true\nrobots: {dd100: {use: bot.yaml}}\n",
    )
    world, findings = project.load_with_findings()
    notes = [finding.message for finding in findings.items if "usd_drive" in finding.message]
    assert notes[0].endswith("in SI units it is damping 572958 N m s/rad, target velocity 1.74533 rad/s")
    base = world.simulation.body(world.stage.find("/dd100/base_link/chassis_link"))
    steps(world.simulation, 240)
    start = base.pose()[0]
    steps(world.simulation, 960)
    moved = np.subtract(base.pose()[0], start) / 4.0
    assert moved == pytest.approx([math.radians(100) * 0.049, 0.0, 0.0], abs=0.0005)
    assert math.radians(100) * 0.049 == pytest.approx(0.0855, abs=5e-5)


def test_a_driven_wheels_effort_is_the_torque_that_accelerates_the_robot(flat: Flat) -> None:
    """10.32 kg at 1 m/s2 on two wheels of 0.049 m: 0.253 N m each, and 0.11 N m for the rotors and wheels."""
    simulation, joints = flat
    for step in range(120):
        joints.select(WHEELS).command(velocities=[(step + 1) / 240 / 0.049] * 2)
        simulation.step()
    rotating = (0.0003234 + 0.005) / 0.049  # kg m2 about the axle, a wheel and its rotor, per metre of rim
    assert joints.efforts() == pytest.approx([10.323 * 0.049 / 2 + rotating] * 2, rel=0.05)


def test_commands_take_effect_with_the_next_step(flat: Flat) -> None:
    simulation, joints = flat
    before = joints.efforts()
    joints.select(WHEELS).command(velocities=[5.0, 5.0])
    np.testing.assert_array_equal(joints.efforts(), before)
    simulation.step()
    assert (joints.efforts() > 1.0).all()


def test_an_unknown_joint_is_reported_with_the_nearest_names(flat: Flat) -> None:
    _, joints = flat
    with pytest.raises(JointError, match="did you mean 'front_left_wheel_joint'"):
        joints.select(["front_left_wheel"])
    with pytest.raises(JointError, match="legal: 0 to 1"):
        joints.select(indices=[2])


def test_no_effort_is_left_once_commands_are_zeroed(flat: Flat) -> None:
    simulation, joints = flat
    joints.select(WHEELS).command(efforts=[0.1, 0.2])
    simulation.step()
    assert simulation.data.qfrc_applied.any()
    simulation.zero_commands()
    simulation.step()
    assert not simulation.data.qfrc_applied.any()


def test_a_state_that_is_not_finite_is_reported_with_its_joint(flat: Flat) -> None:
    simulation, joints = flat
    simulation.clamps_commands = False
    joints.select(WHEELS).command(efforts=[1e10, 0.0])
    with pytest.raises(PhysicsError, match=r"at t = 0.0042 s: the motion of joint 'dd100/front_left_wheel_joint'"):
        simulation.step()
    assert not Path("MUJOCO_LOG.TXT").exists()


@pytest.mark.parametrize(
    ("kind", "values", "what"),
    [
        ("efforts", [1e9, -3.0], "effort of /dd100/front_left_wheel_joint beyond -101.269 to 101.269"),
        ("velocities", [1e9, -3.0], "velocity of /dd100/front_left_wheel_joint beyond -100 to 100"),
    ],
)
def test_a_command_beyond_the_limit_of_a_joint_is_clamped_and_counted(
    flat: Flat, kind: str, values: list[float], what: str
) -> None:
    simulation, joints = flat
    for _ in range(120):
        joints.select(WHEELS).command(**{kind: values})
        simulation.step()
    assert simulation.clamped_commands == {what: 120}
    assert abs(joints.velocities()).max() < 101


@pytest.mark.parametrize("value", [math.inf, -math.inf, 1e11])
@pytest.mark.parametrize("kind", ["positions", "velocities", "efforts"])
def test_a_command_beyond_all_bounds_is_refused_and_the_others_with_it(flat: Flat, kind: str, value: float) -> None:
    simulation, joints = flat
    with pytest.raises(BadValueError, match=r"Command must be up to 1e\+10 for joint 'front_right_wheel_joint', it is"):
        joints.select(WHEELS).command(**{kind: [7.0, value]})
    assert not simulation.set_points.targets.any()
    assert not simulation.set_points.efforts.any()
