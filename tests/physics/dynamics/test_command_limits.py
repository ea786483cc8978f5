"""What a command may ask of a joint at most: as its description says, and finite where that says nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graphengine.physics.handles.motion_handles import ROUNDING, Joints
from graphengine.physics.simulation import Simulation
from tests.physics.harness import CART, ROBOT, Project, steps, ticks

FREE = CART.replace('type="revolute"', 'type="continuous"').replace(
    '<limit lower="-1" upper="1" effort="40" velocity="1"/>', ""
)


@pytest.mark.parametrize(
    ("description", "kind", "beyond"),
    [
        (CART, "efforts", "effort of /bot/arm_joint beyond -40 to 40"),
        (FREE, "efforts", "effort of /bot/arm_joint beyond -58.86 to 58.86"),  # which lifts 6 kg at 1 m
        (CART, "velocities", "velocity of /bot/arm_joint beyond -17453.3 to 17453.3"),
        (CART, "positions", "position of /bot/arm_joint beyond -1 to 1"),
    ],
)
@pytest.mark.parametrize("value", [1e9, -1e9])
def test_commands_beyond_the_limit_are_clamped_and_counted(
    project: Project, description: str, kind: str, beyond: str, value: float
) -> None:
    driven = f"{ROBOT}joints: {{arm_joint: {{drive: {{stiffness: 9, damping: 9}}}}}}\n"
    simulation = project.write("bot.urdf", description).write("bot.yaml", driven).load().simulation
    simulation.articulation(simulation.stage.find("/bot")).select(["arm_joint"]).command(**{kind: [value]})
    points = simulation.set_points
    commanded = [abs(number) for number in (*points.targets.ravel(), *points.efforts.ravel()) if number]
    assert max(commanded) == pytest.approx(float(beyond.rpartition(" ")[2]), rel=1e-5)
    assert simulation.clamped_commands == {beyond: 1}


SPEED, STEP = 0.5, 1 / 240
LIMITED = f"joints: {{arm_joint: {{drive: {{stiffness: 400, damping: 40, max_velocity: {SPEED}}}}}}}\nfixed_base: true"


def limited(project: Project, keys: str = LIMITED) -> tuple[Simulation, Joints]:
    simulation, joints = project.robot(keys).load_joints()
    simulation.set_gravity((0.0, 0.0, 0.0))
    return simulation, joints


@pytest.mark.parametrize("seconds", [3, 12])
def test_a_joint_commanded_beyond_its_range_waits_at_the_limit_and_obeys_the_next_command_at_once(
    project: Project, seconds: int
) -> None:
    simulation, joints = limited(project)
    for _ in range(2):
        joints.select().command(positions=[9.0])
        steps(simulation, seconds * 240)
        assert joints.positions()[0] == pytest.approx(1.0, abs=1e-3)
        assert abs(joints.efforts()[0]) < 0.5  # N m, of 40: it does not press
        joints.select().command(positions=[0.9])
        steps(simulation, round((0.1 / SPEED + 3 * 40 / 400) / STEP))  # the way, and three time constants of the drive
        assert joints.positions()[0] == pytest.approx(0.9, abs=0.006)
    assert simulation.clamped_commands == {"position of /bot/arm_joint beyond -1 to 1": 2}


@pytest.mark.parametrize("kind", ["drive", "usd_drive"])
def test_a_drive_with_overtravel_presses_against_its_limit_with_the_effort_of_that_distance(
    project: Project, kind: str
) -> None:
    unit = 1.0 if kind == "drive" else math.degrees(1.0)
    gains = f"stiffness: {400 / unit}, damping: {40 / unit}, overtravel: {0.05 * unit}"
    simulation, joints = limited(project, f"joints: {{arm_joint: {{{kind}: {{{gains}}}}}}}\nfixed_base: true")
    joints.select().command(positions=[9.0])
    ticks(simulation, 120)
    assert joints.target_ranges[0] == pytest.approx((-1.05, 1.05))
    assert joints.efforts()[0] == pytest.approx(400 * (1.05 - joints.positions()[0]))
    assert 18.0 < joints.efforts()[0] < 20.0
    assert simulation.clamped_commands == {"position of /bot/arm_joint beyond -1.05 to 1.05": 1}


def test_a_joint_that_stops_at_its_limit_is_not_pushed_by_the_velocity_of_its_trajectory(project: Project) -> None:
    simulation, joints = limited(project)
    joints.select().command(positions=[1.2], velocities=[0.5])
    assert [float(target[0]) for target in joints.set_points()] == [1.0, 0.0]
    joints.select().command(positions=[0.5], velocities=[0.5])
    assert [float(target[0]) for target in joints.set_points()] == [0.5, 0.5]
    assert sum(simulation.clamped_commands.values()) == 1


def test_rounding_beyond_a_limit_is_clamped_without_a_count(project: Project) -> None:
    simulation, joints = limited(project)
    joints.select().command(positions=[np.nextafter(1.0, 2.0) + ROUNDING / 2])
    assert joints.set_points()[0].tolist() == [1.0]
    assert not simulation.clamped_commands
    joints.select().command(positions=[1.0 + 2 * ROUNDING])
    assert simulation.clamped_commands


SERVO = """<mujoco><compiler angle="radian"/><worldbody><body name="arm">
<joint name="hinge" axis="0 1 0" range="-1 1" limited="true"/><geom size="0.1" pos="0.2 0 0" mass="0.1"/></body></worldbody>
<actuator><position name="servo" joint="hinge" kp="20" kv="2" {}/></actuator></mujoco>"""


@pytest.mark.parametrize(("control", "most"), [("", 1.0), ('ctrlrange="-1.5 1.5"', 1.5), ('ctrlrange="-0.5 0.5"', 0.5)])
def test_a_servo_of_a_model_without_a_control_range_has_the_range_of_its_joint(
    project: Project, control: str, most: float
) -> None:
    simulation, joints = (
        project.write("bot.xml", SERVO.replace(" {}", f" {control}"))
        .write("bot.yaml", "robot: bot\nmjcf: bot.xml\nbase_link: world\n")
        .load_joints()
    )
    joints.select().command(positions=[9.0])
    assert joints.set_points()[0].tolist() == [most]
    assert simulation.clamped_commands == {f"position of /bot/hinge beyond {-most:g} to {most:g}": 1}
