"""Drives: dampers that follow velocities, springs that hold positions, and joints without either."""

from __future__ import annotations

import math

import pytest

from tests.physics.harness import CART, Project, steps

ARM = """<robot name="arm">
  <link name="base_link"><inertial><mass value="5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
    <inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="{type}"><parent link="base_link"/><child link="arm"/><axis xyz="{axis}"/>
    <limit lower="-3" upper="1" effort="0" velocity="1"/></joint>
</robot>
"""
ENDLESS = CART.replace('type="revolute"', 'type="continuous"')
ARM_ROBOT = (
    "robot: bot\nurdf: bot.urdf\nfixed_base: true\njoints: {{shoulder: {{drive: {{stiffness: {}, damping: {}}}}}}}\n"
)


def test_target_velocity_in_usd_is_degrees_a_second(project: Project) -> None:
    project.write("bot.urdf", ENDLESS).robot("joints: {arm_joint: {usd_drive: {damping: 100, target_velocity: 100}}}")
    simulation, joints = project.load_joints()
    steps(simulation, 60)
    assert joints.velocities()[0] == pytest.approx(math.radians(100), rel=1e-3)
    simulation.zero_commands()
    steps(simulation, 60)
    assert joints.velocities()[0] == pytest.approx(0.0, abs=1e-3)


def test_max_acceleration_is_the_slope_of_the_velocity_set_point(project: Project) -> None:
    project.write("bot.urdf", ENDLESS).robot("joints: {arm_joint: {drive: {damping: 1000, max_acceleration: 2}}}")
    simulation, joints = project.load_joints()
    joints.select().command(velocities=[1.0])
    seen = []
    for _ in range(240):
        simulation.step()
        seen.append(joints.velocities()[0])
    assert seen[59] == pytest.approx(0.5, rel=0.02)  # after a quarter of a second
    assert seen[239] == pytest.approx(1.0, rel=0.002)


def test_max_velocity_limits_a_command_with_a_warning(project: Project) -> None:
    project.write("bot.urdf", ENDLESS).robot("joints: {arm_joint: {drive: {damping: 1000, max_velocity: 2}}}")
    simulation, joints = project.load_joints()
    joints.select().command(velocities=[-5.0])
    steps(simulation, 60)
    assert joints.velocities()[0] == pytest.approx(-2.0, rel=0.002)
    assert simulation.clamped_commands == {"velocity of /bot/arm_joint beyond -2 to 2": 1}


def test_max_velocity_is_the_slope_of_the_position_set_point(project: Project) -> None:
    drive = "{stiffness: 2000, damping: 20, max_velocity: 0.5}"
    simulation, joints = project.robot(f"joints: {{arm_joint: {{drive: {drive}}}}}").load_joints()
    joints.select().command(positions=[0.5])
    steps(simulation, 120)
    assert joints.positions()[0] == pytest.approx(0.25, abs=0.02)  # after half a second
    steps(simulation, 240)
    assert joints.positions()[0] == pytest.approx(0.5, abs=0.005)


def test_a_spring_and_damper_hold_a_position_and_nan_leaves_a_joint_alone(project: Project) -> None:
    simulation, joints = project.robot("joints: {arm_joint: {drive: {stiffness: 500, damping: 50}}}").load_joints()
    selection = joints.select(("arm_joint",))
    selection.command(positions=[0.5])
    selection.command(positions=[math.nan], velocities=None)
    steps(simulation, 480)
    assert joints.positions()[0] == pytest.approx(0.5, abs=0.001)  # the arm's mass is at its joint


def test_an_effort_moves_a_joint(project: Project) -> None:
    """A torque of 0.5 N m on the arm, and what the drive gives back to stand still."""
    simulation, joints = project.robot("joints: {arm_joint: {drive: {stiffness: 500, damping: 50}}}").load_joints()
    joints.select().command(efforts=[0.5])
    steps(simulation, 720)
    assert joints.efforts()[0] == pytest.approx(0.0, abs=1e-3)
    assert joints.positions()[0] == pytest.approx(0.5 / 500, rel=0.01)


@pytest.mark.parametrize("gains", ["{}", "{target_velocity: 3}", "{max_force: 5}"])
def test_a_drive_without_effect_is_reported_and_harmless(project: Project, gains: str) -> None:
    world, findings = project.robot(f"joints: {{arm_joint: {{drive: {gains}}}}}").load_with_findings()
    (note,) = findings.items
    assert note.message == "joint 'arm_joint': a drive without damping and stiffness does nothing"
    joints = world.simulation.articulation(world.stage.find("/bot"))
    joints.select().command(positions=[0.5], velocities=[1.0])
    world.simulation.step()
    assert joints.efforts().tolist() == [0.0]
    joints.select().command(efforts=[0.01])
    world.simulation.step()
    assert joints.efforts().tolist() == [0.01]


@pytest.mark.parametrize(("stiffness", "damping"), [(200.0, 20.0), (1e4, 0.0), (1e4, 1e3), (1e8, 1e5)])
@pytest.mark.parametrize("target", [0.0, -1.0])
def test_an_arm_droops_by_its_torque_over_its_stiffness(
    project: Project, stiffness: float, damping: float, target: float
) -> None:
    project.write("bot.urdf", ARM.format(type="revolute", axis="0 1 0"))
    simulation, joints = project.write("bot.yaml", ARM_ROBOT.format(stiffness, damping)).load_joints()
    joints.select().command(positions=[target])
    steps(simulation, 1200)
    angle = joints.positions()[0]
    torque = 2 * 9.81 * 0.5 * math.cos(angle)
    assert angle - target == pytest.approx(torque / stiffness, rel=1e-3)
    assert joints.efforts()[0] == pytest.approx(-torque, rel=1e-3)


def test_a_lift_sags_by_its_weight_over_its_stiffness_and_counts_metres_in_usd(project: Project) -> None:
    project.write("bot.urdf", ARM.format(type="prismatic", axis="0 0 1"))
    for kind in ("drive", "usd_drive"):
        world = project.write("bot.yaml", ARM_ROBOT.format(1000.0, 100.0).replace("drive", kind)).load()
        joints = world.simulation.articulation(world.stage.find("/bot"))
        joints.select().command(positions=[0.5])
        steps(world.simulation, 1200)
        assert joints.positions()[0] == pytest.approx(0.5 - 2 * 9.81 / 1000)


def test_a_target_velocity_beside_a_stiffness_shifts_the_position(project: Project) -> None:
    # at rest stiffness (q* - q) + damping v* is nothing: PhysX's drive is one spring and damper
    project.write("bot.urdf", ARM.format(type="revolute", axis="0 0 1"))
    project.write(
        "bot.yaml", ARM_ROBOT.format(200.0, 20.0).replace("damping: 20.0", "damping: 20.0, target_velocity: 0.5")
    )
    world = project.load()
    steps(world.simulation, 1200)
    joints = world.simulation.articulation(world.stage.find("/bot"))
    assert joints.positions()[0] == pytest.approx(20.0 * 0.5 / 200.0)


@pytest.mark.parametrize(("stiffness", "damping"), [(1e4, 1e3), (1e8, 1e6), (0.0, 572958.0)])
@pytest.mark.parametrize("substeps", [1, 4])
def test_a_drive_does_not_push_a_joint_through_its_limit(
    project: Project, stiffness: float, damping: float, substeps: int
) -> None:
    project.write("bot.urdf", ARM.format(type="revolute", axis="0 0 1"))
    project.write("bot.yaml", ARM_ROBOT.format(stiffness, damping))
    simulation, joints = project.scene(f"physics: {{tick_rate: 60, substeps: {substeps}}}\n").load_joints()
    joints.select().command(positions=[2.0], velocities=[0.0 if stiffness else 1.0])
    steps(simulation, 360 * substeps)
    assert joints.positions()[0] == pytest.approx(1.0, abs=1.1e-3)
    assert joints.velocities()[0] == pytest.approx(0.0, abs=1e-6)
