"""Maximum forces of drives: what accelerates a joint stays within them, whatever the gains."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.descriptions.actuators.drives import Drive, servos
from graphengine.descriptions.engine import mujoco
from graphengine.format.spec import RobotUse
from graphengine.physics.dynamics.force_limits import ForceLimits
from graphengine.physics.loaded_world import LoadedWorld
from tests.physics.harness import Project

STEP = 1 / 240
MASS, RADIUS = 10.323, 0.049  # kg and m: the dd100 and its wheels
WHEELS = ("front_left_wheel_joint", "front_right_wheel_joint")
DRIVEN = "robot: dd100\nextends: robots/dd100.yaml\njoints:\n"


def rotor(
    inertia: float, drive: Drive, lever: float = 0.0, *, held: bool = False
) -> tuple[mujoco.MjModel, mujoco.MjData, ForceLimits]:
    """One joint with a drive as `robot_model` makes it; a mass of 1 kg on a lever weighs on it, or stops hold it."""
    actuators = "".join(
        f'<general name="{name}" joint="j" gainprm="{gain}"/>' for name, gain in servos("j", drive) if gain
    )
    stops = 'limited="true" range="-.001 .001" solreflimit=".004 1" solimplimit=".99 .999 .001"' if held else ""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP!r}" integrator="discrete"/><worldbody><body><joint name="j" axis="0 1 0" {stops}'
        f' damping="{drive.damping}" stiffness="{drive.stiffness}"/><inertial mass="1" pos="{lever} 0 0"'
        f' diaginertia="{inertia} {inertia} {inertia}"/></body></worldbody><actuator>{actuators}</actuator></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_step1(model, data)
    return model, data, ForceLimits(model, data, [("j", drive)])


def step(model: mujoco.MjModel, data: mujoco.MjData, limits: ForceLimits, target: float, effort: float = 0.0) -> None:
    limits.observe()
    data.ctrl[-1] = target
    limits.apply(np.full(model.nv, effort))
    mujoco.mj_step2(model, data)
    mujoco.mj_step1(model, data)


@settings(max_examples=50)
@given(
    st.floats(1e-3, 10),
    st.floats(1e-2, 1e6),
    st.sampled_from([0.0, 10.0, 1e4]),
    st.floats(0.1, 100),
    st.floats(-50, 50),
    st.sampled_from([0.0, 0.05, -3.0]),
)
def test_a_free_joint_takes_the_maximum_force_and_no_more_until_it_has_its_velocity(
    inertia: float, damping: float, stiffness: float, most: float, target: float, effort: float
) -> None:
    model, data, limits = rotor(inertia, Drive(stiffness, damping, max_force=most))
    for _ in range(20):
        before = float(data.qvel[0])
        step(model, data, limits, target, effort)
        force = inertia * (data.qvel[0] - before) / STEP - effort
        assert abs(force) <= most + 1e-6 * (most + abs(effort))
        wanted = abs(damping * (target - data.qvel[0]) - stiffness * data.qpos[0])
        assert abs(force) == pytest.approx(min(wanted, most), rel=1e-5, abs=1e-6 * (most + abs(effort)))


def test_the_force_limit_includes_gravity_compensation() -> None:
    # 9.81 N m on the lever: 12 N m lift it with what is left, 8 N m do not hold it
    for most, expected in ((12.0, 12.0 - 9.81), (8.0, 8.0 - 9.81)):
        model, data, limits = rotor(0.5, Drive(0.0, 1e4, max_force=most), lever=1.0)
        for _ in range(3):
            before = float(data.qvel[0])
            step(model, data, limits, -10.0)
            assert -1.5 * (data.qvel[0] - before) / STEP == pytest.approx(expected, rel=1e-3)


@settings(max_examples=50)
@given(st.floats(0.01, 1), st.floats(0.1, 1000), st.floats(0, 1e4), st.floats(1, 100), st.sampled_from([-1.0, 1.0]))
def test_a_joint_held_fast_is_pushed_with_the_maximum_force(
    inertia: float, damping: float, stiffness: float, most: float, sign: float
) -> None:
    model, data, limits = rotor(inertia, Drive(stiffness, damping, max_force=most), held=True)
    for _ in range(60):
        step(model, data, limits, sign * (1e4 + 2 * most / damping))
    pushed = damping * (data.ctrl[-1] - data.qvel[0]) - stiffness * data.qpos[0] + data.qfrc_applied[0]
    assert pushed == pytest.approx(sign * most, rel=0.01)


def test_a_joint_that_is_let_go_soon_has_its_whole_force() -> None:
    model, data, limits = rotor(0.5, Drive(0.0, 1000.0, max_force=3.0), held=True)
    for _ in range(60):
        step(model, data, limits, 100.0)
    model.jnt_range[0] = -100.0, 100.0
    step(model, data, limits, 100.0)  # which the stop still takes part in
    forces = []
    for _ in range(6):
        before = float(data.qvel[0])
        step(model, data, limits, 100.0)
        forces.append(0.5 * (data.qvel[0] - before) / STEP)
    grown = 3.0 / (1 + 1000 * STEP / 0.5)  # of M, what a joint takes that had been taken for held
    assert forces == pytest.approx([min(grown * 2**step, 3.0) for step in range(6)], rel=0.01)


def test_a_drive_that_moves_a_load_exerts_the_maximum_force() -> None:
    # three times the inertia that the limit knows of: something that is carried, or a link that reaches out
    drive = Drive(0.0, 1000.0, max_force=3.0)
    model, data, _ = rotor(1.5, drive)
    limits = ForceLimits(rotor(0.5, drive)[0], data, [("j", drive)])
    step(model, data, limits, 100.0)
    before = float(data.qvel[0])
    step(model, data, limits, 100.0)
    assert 1.5 * (data.qvel[0] - before) / STEP == pytest.approx(3.0, rel=1e-6)


def test_a_commanded_effort_is_not_limited_but_the_force_of_the_drive_is() -> None:
    model, data, limits = rotor(0.5, Drive(0.0, 100.0, max_force=2.0))
    step(model, data, limits, 0.0, effort=7.0)
    assert 0.5 * data.qvel[0] / STEP == pytest.approx(7.0 - 2.0)


def test_a_joint_that_pushes_goes_on_as_before_when_a_robot_is_added(project: Project) -> None:
    project.robot("joints: {arm_joint: {drive: {stiffness: 1000, damping: 100, overtravel: 1}}}")
    seen = []
    for spawned in (False, True):
        world = project.load()
        joints = world.simulation.articulation(world.stage.find("/bot"))
        joints.select().command(positions=[2.0])
        efforts = []
        for count in range(60):
            if spawned and count == 20:
                world.add("other", RobotUse(use="bot.yaml", position=(3.0, 0.0, 0.1)))
            world.simulation.step()
            efforts.append(float(joints.efforts()[0]))
        seen.append(efforts)
    assert seen[0] == seen[1]
    assert max(seen[0][20:]) > 41.0  # the joint limit resists from one step to the next


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


def test_maximum_forces_are_reported_with_the_resulting_accelerations(project: Project) -> None:
    findings = project.robot("joints: {arm_joint: {drive: {damping: 1, max_force: 3}}}").load_with_findings()[1]
    # the arm: 0.01 kg m2 about its middle, which is at the joint
    (note,) = findings.items
    assert (
        note.message == "joint 'arm_joint': max_force 3 N m accelerates the inertia of 0.01 kg m2 by at most 300 rad/s2"
    )
    usd = "{usd_drive: {damping: 0.001, max_force: 3}}"
    _, findings = project.robot(f"joints: {{arm_joint: {usd}}}").try_load()
    assert findings.items[-1].message == note.message  # a force is no angle


@pytest.mark.parametrize(("drive", "most"), [("damping: 0.1", 40.0), ("damping: 0.1, max_force: 5", 5.0)])
def test_the_descriptions_effort_is_the_maximum_unless_the_drive_has_one(
    project: Project, drive: str, most: float
) -> None:
    simulation, joints = project.robot(f"joints: {{arm_joint: {{drive: {{{drive}}}}}}}").load_joints()
    joints.select().command(velocities=[1e6])
    simulation.step()
    assert joints.efforts()[0] == pytest.approx(most, rel=0.01)


def test_an_effort_of_zero_limits_nothing_and_the_descriptions_effort_causes_no_note(project: Project) -> None:
    world, findings = project.robot("joints: {arm_joint: {drive: {damping: 1000}}}").load_with_findings()
    assert (world.simulation.limits.joints, findings.items) == (["bot/arm_joint"], [])
    assert project.cart('effort="40"', 'effort="0"').load().simulation.limits.joints == []


def test_a_robot_file_used_twice_is_reported_once(project: Project) -> None:
    project.robot("joints: {arm_joint: {drive: {damping: 0.1, max_force: 3}}}")
    scene = "scene: t\nworld: world.xml\nrobots: {bot: {use: bot.yaml, count: 3, spacing: [2, 2]}}\n"
    world, findings = project.write("scene.yaml", scene).load_with_findings()
    assert len(world.simulation.limits.joints) == 3
    assert len(findings.items) == 1


@pytest.mark.parametrize("drag", [0.4, -0.4, 2.0])
def test_friction_does_not_keep_a_stiff_drive_from_its_force(drag: float) -> None:
    # the drive brakes, and so does friction: while the drive has little force, it pushes against the deceleration
    inertia, most, speed = 0.2, 8.0, 5.0
    model, data, limits = rotor(inertia, Drive(0.0, 3600.0, max_force=most))
    data.qvel[0] = speed
    data.xfrc_applied[1, 4] = -drag
    mujoco.mj_step1(model, data)
    for _ in range(20):
        step(model, data, limits, speed)
    for _ in range(10):
        step(model, data, limits, 0.0)
    before = float(data.qvel[0])
    step(model, data, limits, 0.0)
    assert inertia * (data.qvel[0] - before) / STEP == pytest.approx(-most, rel=0.1)
