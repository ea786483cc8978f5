"""Forces and torques in a robot's joints against statics and circular motion."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from graphengine.descriptions.engine import mujoco
from graphengine.devices.stage import Stage
from graphengine.physics.handles.motion_handles import Joints
from graphengine.physics.simulation import Simulation
from tests.physics.harness import steps

G = 9.81


def robot(bodies: str, *joints: str) -> Joints:
    """The joints of a robot that stands in the world."""
    world = f'<mujoco><option integrator="discrete" timestep="0.001"/><worldbody>{bodies}</worldbody></mujoco>'
    stage = Stage()
    stage.add("/bot", "robot", facts={"joints": joints, "prismatic": (False,) * len(joints)})
    for joint in joints:
        stage.add(f"/bot/Physics/{joint}", "joint", facts={"joint": joint, "drive": None})
    simulation = Simulation(mujoco.MjModel.from_xml_string(world), stage, Fraction(1000), 1)
    return simulation.articulation(stage.find("/bot"))


CANTILEVER = """
  <body name="upper" pos="1 2 3" euler="0 0 30"><joint name="bot/shoulder" axis="0 0 1"/>
    <geom type="box" size=".1 .01 .01" pos="0.4 0 0" mass="2"/>
    <body name="fore" pos="0.8 0 0" euler="0 0 45"><joint name="bot/elbow" axis="0 0 1"/>
      <geom type="box" size=".1 .01 .01" pos="0.3 0 0.1" mass="0.5"/></body></body>
"""


def test_a_joint_holds_the_weight_beyond_it_and_its_moment_in_the_child_links_frame() -> None:
    # Joints about the vertical carry horizontal links: the torque that holds a weight at r is r x (0, 0, m g).
    joints = robot(CANTILEVER, "shoulder", "elbow")
    forces, torques = joints.wrenches()
    np.testing.assert_allclose(forces, [[0, 0, 2.5 * G], [0, 0, 0.5 * G]], atol=1e-9)
    beyond = np.cross([0.3, 0.0, 0.1], [0.0, 0.0, 0.5 * G])
    middle = np.array([0.8 + 0.3 * np.sqrt(0.5), 0.3 * np.sqrt(0.5), 0.1])  # of the fore arm, in the upper arm's frame
    np.testing.assert_allclose(torques[1], beyond, atol=1e-9)
    np.testing.assert_allclose(
        torques[0], np.cross([0.4, 0, 0], [0, 0, 2 * G]) + np.cross(middle, [0, 0, 0.5 * G]), atol=1e-9
    )


def test_a_link_that_circles_is_pulled_inwards() -> None:
    wheel = '<body euler="90 0 0"><joint name="bot/axle" axis="0 1 0"/><geom size=".05" pos="0.4 0 0" mass="2"/></body>'
    joints = robot(wheel, "axle")
    simulation = joints._simulation
    simulation.data.qvel[:] = 5.0
    mujoco.mj_step1(simulation.model, simulation.data)
    for _ in range(100):
        simulation.step()
        (force,), (torque,) = joints.wrenches()
        # After the turn about x the y axis of the child's frame points upwards.
        np.testing.assert_allclose(force, [-2 * 5.0**2 * 0.4, G * 2, 0.0], atol=1e-6)
        np.testing.assert_allclose(torque, np.cross([0.4, 0, 0], [0.0, G * 2, 0.0]), atol=1e-6)


def test_a_leaning_object_is_held_by_both_supports() -> None:
    beam = """
      <geom type="sphere" size=".1" pos="1 0 -.15"/>
      <body><joint name="bot/hinge" axis="0 1 0"/>
        <geom type="box" size=".5 .02 .05" pos=".5 0 0" mass="4"/></body>
    """
    joints = robot(beam, "hinge")
    steps(joints._simulation, 2000)
    (force,), (torque,) = joints.wrenches()
    assert force == pytest.approx([0.0, 0.0, 2 * G], abs=0.02)
    assert torque == pytest.approx([0.0, 0.0, 0.0], abs=1e-3)


def test_reading_wrenches_does_not_change_the_motion() -> None:
    asked, left_alone = robot(CANTILEVER, "shoulder", "elbow"), robot(CANTILEVER, "shoulder", "elbow")
    for joints in (asked, left_alone):
        joints._simulation.data.qvel[:] = [1.0, -2.0]
    for _ in range(50):
        asked._simulation.step()
        left_alone._simulation.step()
        first, second = asked.wrenches(), asked.wrenches()
        np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(asked._simulation.data.qpos, left_alone._simulation.data.qpos)


def test_after_a_reset_wrenches_have_their_initial_values() -> None:
    joints = robot(CANTILEVER, "shoulder", "elbow")
    before = joints.wrenches()
    joints._simulation.data.qvel[:] = 3.0
    joints._simulation.step()
    assert not np.allclose(joints.wrenches()[0], before[0])
    joints._simulation.reset()
    np.testing.assert_array_equal(joints.wrenches(), before)
