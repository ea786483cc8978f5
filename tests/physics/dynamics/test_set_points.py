"""How set points move to new targets: at once, evenly over a tick, and no faster than the limits of the drive."""

from __future__ import annotations

import pytest

from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project


def steps(simulation: Simulation, count: int) -> list[list[float]]:
    """Position and velocity set point in each of some steps."""
    found = []
    for _ in range(count):
        simulation.step()
        found.append(simulation.data.ctrl.tolist())
    return found


def drive(project: Project, keys: str) -> tuple[Simulation, Joints]:
    return project.robot(f"joints: {{arm_joint: {{drive: {{stiffness: 50, damping: 5{keys}}}}}}}").load_joints()


@pytest.mark.parametrize(
    ("keys", "positions", "velocities"),
    [
        ("", [0.4] * 4, [2.0] * 4),
        (", interpolate: true", [0.1, 0.2, 0.3, 0.4], [0.5, 1.0, 1.5, 2.0]),
        (", interpolate: true, max_velocity: 12", [0.05, 0.1, 0.15, 0.2], [0.5, 1.0, 1.5, 2.0]),
        (", interpolate: true, max_acceleration: 60", [0.1, 0.2, 0.3, 0.4], [0.25, 0.5, 0.75, 1.0]),
    ],
)
def test_set_points_reach_a_target_at_the_beginning_or_evenly_until_the_end_of_a_tick(
    project: Project, keys: str, positions: list[float], velocities: list[float]
) -> None:
    simulation, joints = drive(project, keys)
    steps(simulation, 4)
    joints.select().command(positions=[0.4], velocities=[2.0])
    seen = steps(simulation, 4)
    assert [position for position, _ in seen] == pytest.approx(positions)
    assert [velocity for _, velocity in seen] == pytest.approx(velocities)


def test_a_target_of_every_tick_is_reached_exactly_at_its_end(project: Project) -> None:
    simulation, joints = drive(project, ", interpolate: true")
    for tick in range(20):
        target = 0.013 * tick
        joints.select().command(positions=[target])
        assert steps(simulation, 4)[-1][0] == target


def test_a_target_within_a_tick_is_reached_at_the_end_of_that_tick(project: Project) -> None:
    simulation, joints = drive(project, ", interpolate: true")
    steps(simulation, 2)
    joints.select().command(positions=[0.4])
    assert [position for position, _ in steps(simulation, 3)] == pytest.approx([0.2, 0.4, 0.4])


def test_the_start_position_is_the_first_set_point(project: Project) -> None:
    keys = "joints: {arm_joint: {start: 0.3, drive: {stiffness: 50, damping: 5, interpolate: true}}}"
    simulation, _ = project.robot(keys).load_joints()
    assert [position for position, _ in steps(simulation, 2)] == [0.3, 0.3]
