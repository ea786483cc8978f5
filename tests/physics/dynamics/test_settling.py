"""Coming to rest before the start."""

from __future__ import annotations

import math

import mujoco
import pytest

from graphengine.format.spec import RobotUse
from graphengine.physics.dynamics.settling import SETTLE_LIMIT, SETTLED_FOR, SETTLED_SPEED, settle
from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.simulation import Simulation
from tests.physics.harness import Project, steps

SPRING = f"""
<mujoco>
  <option timestep="0.005" gravity="0 0 0"/>
  <worldbody>
    <body><joint type="slide" stiffness="{4 * math.pi**2}"/><geom size=".1" mass="1"/></body>
  </worldbody>
</mujoco>
"""


def settled_after(fastest: float) -> float | None:
    """The time that a mass takes which swings once a second without an end, by its greatest speed, m/s."""
    model = mujoco.MjModel.from_xml_string(SPRING)
    data = mujoco.MjData(model)
    data.qpos[0] = fastest / (2 * math.pi)
    return settle(model, data, lambda: mujoco.mj_step(model, data))


def test_a_body_that_swings_faster_than_the_bound_is_not_at_rest() -> None:
    at_turns = 2 * SETTLE_LIMIT * math.asin(0.1) / math.pi
    assert at_turns > 3 * SETTLED_FOR
    assert settled_after(10 * SETTLED_SPEED) is None


def test_a_body_that_swings_slower_than_the_bound_is_at_rest() -> None:
    assert settled_after(0.9 * SETTLED_SPEED) == pytest.approx(SETTLED_FOR, abs=0.006)


HELD = "joints: {arm_joint: {start: 0.3, drive: {stiffness: 50, damping: 5, max_velocity: 0.5}}}"


@pytest.fixture
def held(project: Project) -> tuple[Simulation, Joints]:
    """An arm that a drive holds, which has come to rest."""
    return project.robot(HELD).scene("settle: true\n").load_joints()


def strays(simulation: Simulation, joints: Joints) -> float:
    """How far the arm moves within two seconds without a command, rad."""
    at_rest = joints.positions()[0]
    assert at_rest == pytest.approx(0.3, abs=0.02)
    found = []
    for _ in range(2 * 240):
        simulation.step()
        found.append(abs(joints.positions()[0] - at_rest))
    return float(max(found))


def test_an_arm_that_came_to_rest_stays_where_its_drive_holds_it(held: tuple[Simulation, Joints]) -> None:
    simulation, joints = held
    assert simulation.settled_after is not None
    assert joints.set_points()[0].tolist() == [0.3]
    assert strays(*held) < 1e-3


def test_a_reset_and_a_checkpoint_return_to_the_held_arm(held: tuple[Simulation, Joints]) -> None:
    simulation, joints = held
    saved = simulation.save()
    for back in (simulation.reset, lambda: simulation.restore(saved)):
        joints.select().command(positions=[-0.8])
        steps(simulation, 240)
        assert joints.positions()[0] < 0.2
        back()
        assert strays(*held) < 1e-3


def test_added_robots_and_their_neighbours_stay_where_their_drives_hold_them(project: Project) -> None:
    world = project.robot(HELD).scene("settle: true\n").load()
    simulation = world.simulation
    joints = simulation.articulation(simulation.stage.find("/bot"))
    steps(simulation, 5)
    world.add("late", RobotUse(use="bot.yaml", position=(0, 2, 0.1)))
    late = simulation.articulation(simulation.stage.find("/late"))
    for _ in range(2):
        for arm in (joints, late):
            assert arm.set_points()[0] == pytest.approx(arm.positions(), abs=0.02)
            assert strays(simulation, arm) < 0.02  # the added robot has not come to rest: its arm sags
        simulation.reset()


def test_the_activations_of_a_model_are_kept() -> None:
    text = SPRING.replace(
        "</worldbody>", "</worldbody><actuator><position joint='slide' kp='40' timeconst='0.2'/></actuator>"
    )
    text = text.replace('type="slide" stiffness', 'name="slide" type="slide" damping="8" stiffness')
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.ctrl[0] = 0.5
    assert settle(model, data, lambda: mujoco.mj_step(model, data)) is not None
    assert data.ctrl[0] == 0.5
    assert data.act[0] == pytest.approx(0.5, abs=1e-3)
    rest = data.qpos[0]
    mujoco.mj_step(model, data, 400)
    assert data.qpos[0] == pytest.approx(rest, abs=1e-3)
