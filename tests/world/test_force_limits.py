"""Maximum forces of drives: what accelerates a joint stays within them, whatever the gains."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.world.drives import Drive, position_servo, velocity_servo
from graphengine.world.engine import mujoco
from graphengine.world.force_limits import ForceLimits
from graphengine.world.model import LoadedWorld
from tests.world.harness import CART, ROBOT, Project

STEP = 1 / 240
MASS, RADIUS = 10.323, 0.049  # kg and m: the dd100 and its wheels
WHEELS = ("front_left_wheel_joint", "front_right_wheel_joint")
DRIVEN = "robot: dd100\nextends: robots/dd100.yaml\njoints:\n"


def rotor(inertia: float, drive: Drive, lever: float = 0.0) -> tuple[mujoco.MjModel, mujoco.MjData, ForceLimits]:
    """One joint with a drive as `robot_model` makes it; a mass of 1 kg on a lever weighs on it."""
    actuators = "".join(
        f'<general name="{name}" joint="j" gainprm="{gain}"/>'
        for name, gain in ((position_servo("j"), drive.stiffness), (velocity_servo("j"), drive.damping))
        if gain
    )
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP!r}" integrator="discrete"/><worldbody><body><joint name="j" axis="0 1 0"'
        f' damping="{drive.damping}" stiffness="{drive.stiffness}"/><inertial mass="1" pos="{lever} 0 0"'
        f' diaginertia="{inertia} {inertia} {inertia}"/></body></worldbody><actuator>{actuators}</actuator></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_step1(model, data)
    return model, data, ForceLimits(model, data, [("j", drive)])


def step(model: mujoco.MjModel, data: mujoco.MjData, limits: ForceLimits) -> None:
    limits.apply(np.zeros(model.nv))
    mujoco.mj_step2(model, data)
    mujoco.mj_step1(model, data)


@settings(max_examples=50, deadline=None)
@given(
    st.floats(1e-3, 10),
    st.floats(1e-2, 1e6),
    st.sampled_from([0.0, 10.0, 1e4]),
    st.floats(0.1, 100),
    st.floats(-50, 50),
)
def test_a_free_joint_takes_the_maximum_force_and_no_more_until_it_has_its_velocity(
    inertia: float, damping: float, stiffness: float, most: float, target: float
) -> None:
    model, data, limits = rotor(inertia, Drive(stiffness, damping, max_force=most))
    data.ctrl[-1] = target
    for _ in range(20):
        before = float(data.qvel[0])
        step(model, data, limits)
        force = inertia * (data.qvel[0] - before) / STEP
        assert abs(force) <= most * (1 + 1e-6)
        wanted = abs(damping * (target - data.qvel[0]) - stiffness * data.qpos[0])
        assert abs(force) == pytest.approx(min(wanted, most), rel=1e-5, abs=1e-6 * most)


def test_what_gravity_takes_is_a_part_of_the_force() -> None:
    # 9.81 N m on the lever: 12 N m lift it with what is left, 8 N m do not hold it
    for most, expected in ((12.0, 12.0 - 9.81), (8.0, 8.0 - 9.81)):
        model, data, limits = rotor(0.5, Drive(0.0, 1e4, max_force=most), lever=1.0)
        data.ctrl[0] = -10.0
        step(model, data, limits)
        assert -1.5 * data.qvel[0] / STEP == pytest.approx(expected, rel=1e-3)


def test_a_joint_held_fast_exceeds_its_maximum_by_no_more_than_is_told() -> None:
    _, data, limits = rotor(0.5, Drive(0.0, 100.0, max_force=2.0))
    data.ctrl[0] = 50.0
    limits.apply(np.zeros(1))
    pushed = 100.0 * 50.0 + data.qfrc_applied[0]  # the whole force, as long as the joint does not move
    assert limits.resisted.tolist() == pytest.approx([1 + 100 * STEP / 0.5])
    assert pushed == pytest.approx(2.0 * limits.resisted[0])


def test_commanded_efforts_are_not_limited() -> None:
    _, data, limits = rotor(0.5, Drive(0.0, 100.0, max_force=2.0))
    limits.apply(np.array([7.0]))
    assert data.qfrc_applied[0] == 7.0


def accelerate(world: LoadedWorld, speed: float, seconds: float) -> tuple[float, list[float], float]:
    """Greatest acceleration over a tenth of a second (m/s2), all efforts of a wheel, greatest tilt (rad)."""
    simulation, stage = world.simulation, world.stage
    joints, base = simulation.articulation(stage.find("/dd100")), simulation.body(stage.find("/dd100/base_link"))
    joints.select(WHEELS).command(velocities=[speed / RADIUS] * 2)
    speeds, efforts, tilt = [], [], 0.0
    for _ in range(round(seconds * 240)):
        simulation.step()
        speeds.append(base.velocity()[0][0])
        efforts.append(float(joints.efforts()[0]))
        x, y, _, _ = base.pose()[1]
        tilt = max(tilt, math.acos(1 - 2 * (x * x + y * y)))
    return float(np.abs(np.subtract(speeds[24:], speeds[:-24])).max()) * 10, efforts, tilt


@pytest.mark.parametrize("damping", [1.0, 50.0, 572958.0])
def test_the_force_that_accelerates_a_robot_is_its_wheels_maximum(project: Project, damping: float) -> None:
    # a wheel's 0.3 N m go into half of the robot, 10.32 kg at 0.049 m, and into the wheel and its rotor
    joints = "".join(f"  {wheel}: {{drive: {{damping: {damping}, max_force: 0.3}}}}\n" for wheel in WHEELS)
    project.write("bot.yaml", DRIVEN + joints).write(
        "scene.yaml",
        "scene: t\nworld: world.xml\nsettle: true\nrobots: {dd100: {use: bot.yaml, position: [0, 0, 0.02]}}\n",
    )
    world = project.load()
    inertia = MASS * RADIUS**2 / 2 + 0.0003234 + 0.005
    assert world.simulation.limits.inertias.tolist() == pytest.approx([inertia] * 2, rel=1e-3)
    expected = 0.3 / inertia * RADIUS
    acceleration, efforts, tilt = accelerate(world, 1.0, 2.0)
    assert acceleration == pytest.approx(expected, rel=0.01)
    assert max(efforts) == pytest.approx(0.3, rel=0.01)
    assert efforts[-1] == pytest.approx(0.0, abs=0.01)
    acceleration, efforts, reversed_tilt = accelerate(world, -1.0, 3.0)
    assert acceleration == pytest.approx(expected, rel=0.01)
    assert min(efforts) == pytest.approx(-0.3, rel=0.01)
    assert max(tilt, reversed_tilt) < math.radians(0.1)


def test_maximum_forces_are_told_with_what_they_come_to(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {drive: {damping: 1, max_force: 3}}}\n")
    world, findings = project.try_load()
    assert world is not None
    # the arm: 0.01 kg m2 about its middle, which is at the joint
    (note,) = findings.items
    assert note.message == "joint 'arm_joint': max_force 3 N m accelerates its 0.01 kg m2 by at most 300 rad/s2"
    assert note.help == (
        f"held fast, it may exert {3 * (1 + STEP / 0.01):.3g} N m: less damping or more substeps bring that down",
    )
    usd = "{usd_drive: {damping: 0.001, max_force: 3}}"
    _, findings = project.write("bot.yaml", ROBOT + f"joints: {{arm_joint: {usd}}}\n").try_load()
    assert findings.items[-1].message == note.message  # a force is no angle


def test_the_effort_of_a_description_is_a_maximum_too_and_told_where_it_is_not_kept_closely(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {drive: {damping: 0.1}}}\n")
    world, findings = project.try_load()
    assert world is not None
    assert findings.items == []
    joints = world.simulation.articulation(world.stage.find("/bot"))
    joints.select().command(velocities=[1e6])
    world.simulation.step()
    assert joints.efforts()[0] == pytest.approx(40.0, rel=0.01)
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {drive: {damping: 1000}}}\n")
    _, findings = project.try_load()
    assert "the effort in the description, 40 N m accelerates its 0.01 kg m2" in findings.items[0].message
    project.write("bot.urdf", CART.replace('effort="40"', 'effort="0"'))
    world, findings = project.try_load()
    assert world is not None
    assert findings.items == []
    assert world.simulation.limits.joints == []
    project.write("bot.urdf", CART).write(
        "bot.yaml", ROBOT + "joints: {arm_joint: {drive: {damping: 0.1, max_force: 5}}}\n"
    )
    world = project.load()
    joints = world.simulation.articulation(world.stage.find("/bot"))
    joints.select().command(velocities=[1e6])
    world.simulation.step()
    assert joints.efforts()[0] == pytest.approx(5.0, rel=0.01)


def test_one_robot_file_used_twice_is_told_once(project: Project) -> None:
    project.write("bot.yaml", ROBOT + "joints: {arm_joint: {drive: {damping: 0.1, max_force: 3}}}\n")
    scene = "scene: t\nworld: world.xml\nrobots: {bot: {use: bot.yaml, count: 3, spacing: [2, 2]}}\n"
    world, findings = project.write("scene.yaml", scene).try_load()
    assert world is not None
    assert len(world.simulation.limits.joints) == 3
    assert len(findings.items) == 1
