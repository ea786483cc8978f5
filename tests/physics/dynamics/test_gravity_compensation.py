"""Gravity compensation: drives hold an arm without sagging, within their efforts, and the floor still carries it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.descriptions.actuators.drives import Drive
from graphengine.descriptions.engine import mujoco
from graphengine.physics.dynamics.gravity_compensation import GravityCompensation
from tests.physics.harness import Project

LEVER, START = 0.3, 0.5  # m and rad
WEIGHT = -9.81 * LEVER * math.sin(START)
DRIVE = "stiffness: 100, damping: 10"
CHAIN = """<mujoco><option gravity="0.7 -1.1 -9.2"/><worldbody>
  <body name="other"><freejoint/><inertial mass="3" pos="0 0 0" diaginertia="1 1 1"/></body>
  <body name="base" pos="0 0 1"><freejoint/><inertial mass="5" pos=".1 0 0" diaginertia="1 1 1"/>
    <body name="a" euler="10 20 30"><joint name="turn" axis="1 2 3"/><inertial mass="2" pos=".1 .2 0" diaginertia="1 1 1"/>
      <body name="b" pos=".3 0 .2"><joint name="slide" type="slide" axis="0 1 1"/>
        <inertial mass="1" pos="0 .1 .2" diaginertia="1 1 1"/>
        <body name="c" pos="0 .2 .1"{}><joint name="tip" axis="0 1 0"/><inertial mass=".5" pos=".2 0 0" diaginertia="1 1 1"/>
      </body></body></body>
    <body name="d"><inertial mass="1" pos=".4 0 0" diaginertia="1 1 1"/></body></body></worldbody></mujoco>"""


def crane(project: Project, drive: str, more: str = "", effort: float = 40.0) -> Project:
    """The cart with its 1 kg at the end of a lever, standing on the floor."""
    project.cart('<link name="arm">\n    <inertial>', f'<link name="arm">\n    <inertial><origin xyz="0 0 {LEVER}"/>')
    text = (project.folder / "bot.urdf").read_text(encoding="utf-8").replace('effort="40"', f'effort="{effort}"')
    project.write("bot.urdf", text)
    return project.robot(f"joints: {{arm_joint: {{start: {START}, drive: {{{drive}}}}}}}\n{more}")


@settings(max_examples=50)
@given(st.lists(st.floats(-2, 2), min_size=17, max_size=17), st.sampled_from(["", ' gravcomp="1"']))
def test_the_compensation_holds_the_links_beyond_a_joint(places: list[float], weightless: str) -> None:
    model = mujoco.MjModel.from_xml_string(CHAIN.format(weightless))
    data = mujoco.MjData(model)
    data.qpos[:] = places
    mujoco.mj_forward(model, data)
    dofs = [model.joint(name).dofadr[0] for name in ("turn", "slide", "tip")]
    held = (data.qfrc_bias - data.qfrc_passive)[dofs]
    drives = [(name, Drive(gravity_compensation=name != "slide")) for name in ("turn", "slide", "tip")]
    efforts = GravityCompensation(model, data, drives).apply(np.ones(model.nv))
    assert efforts[dofs] == pytest.approx(held * [1, 0, 1], abs=1e-9)
    assert data.qfrc_applied[dofs] == pytest.approx(held * [1, 0, 1] + [1, 0, 1], abs=1e-9)
    slide = GravityCompensation(model, data, [("slide", Drive(gravity_compensation=True))])
    assert slide.apply(np.zeros(model.nv))[dofs] == pytest.approx(held * [0, 1, 0], abs=1e-9)


@pytest.mark.parametrize("base", ["fixed_base: true", ""])
def test_an_arm_with_compensation_does_not_sag_and_its_effort_is_its_weight(project: Project, base: str) -> None:
    sags = []
    for compensated in ("", ", gravity_compensation: true"):
        simulation, joints = crane(project, DRIVE + compensated, base).load_joints()
        for _ in range(480):
            simulation.step()
        sags.append(float(joints.positions()[0]) - START)
        assert joints.efforts()[0] == pytest.approx(WEIGHT, rel=0.05)
    assert sags[0] > 0.01
    assert abs(sags[1]) < 1e-5


def test_the_floor_carries_an_arm_whose_drive_carries_its_weight(project: Project) -> None:
    simulation, _ = crane(project, f"{DRIVE}, gravity_compensation: true").load_joints()
    for _ in range(480):
        simulation.step()
    assert sum(force[2] for force in simulation.contacts().forces) == pytest.approx(6 * 9.81, rel=1e-3)


def test_the_compensation_counts_towards_the_maximum_force(project: Project) -> None:
    most, inertia = 1.0, 0.01 + LEVER**2
    simulation, joints = crane(project, f"{DRIVE}, gravity_compensation: true", "fixed_base: true", most).load_joints()
    for _ in range(10):
        before, angle = float(joints.velocities()[0]), float(joints.positions()[0])
        simulation.step()
        falls = (joints.velocities()[0] - before) * 240 * inertia
        assert falls == pytest.approx(9.81 * LEVER * math.sin(angle) - most, rel=0.02)
        assert joints.efforts()[0] == pytest.approx(-most, rel=0.02)


def test_compensation_follows_gravity_that_a_graph_sets(project: Project) -> None:
    simulation, joints = crane(project, f"{DRIVE}, gravity_compensation: true", "fixed_base: true").load_joints()
    simulation.set_gravity((0.0, 0.0, -1.62))
    for _ in range(240):
        simulation.step()
    assert joints.efforts()[0] == pytest.approx(WEIGHT * 1.62 / 9.81, rel=1e-3)
    assert joints.positions()[0] == pytest.approx(START, abs=1e-5)


def test_a_run_with_compensation_repeats_bit_by_bit_after_a_restore(project: Project) -> None:
    drive = f"{DRIVE}, gravity_compensation: true, interpolate: true"
    simulation, joints = crane(project, drive, effort=3.0).load_joints()
    for _ in range(30):
        simulation.step()
    joints.select().command(positions=[-0.4], velocities=[0.1])
    for _ in range(2):
        simulation.step()
    saved, ends = simulation.save(), []
    for _ in range(2):
        for _ in range(50):
            simulation.step()
        ends.append((joints.positions().tobytes(), joints.efforts().tobytes()))
        simulation.restore(saved)
    assert ends[0] == ends[1]
