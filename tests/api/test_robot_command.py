"""Targets of joints from Python: they act from the next tick on, are recorded, and are checked before anything changes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import graphengine as ge
from graphengine.cli import main
from graphengine.runtime.commands import parse
from tests.physics.mjcf_models import KITCHEN_SINK, write_model

TICK, STEP = 1 / 60, 1 / 240  # s
RADIUS = 0.049  # m, of the dd100's wheels
WHEELS = ("front_left_wheel_joint", "front_right_wheel_joint")
MASS = 2.0  # kg, of each link
_JOINTS = ("slide", "glide", "spin")
_LINK = f"""<link name="{{0}}"><inertial><mass value="{MASS}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>
</inertial></link>"""
_JOINT = """<joint name="{0}" type="{1}"><parent link="base_link"/><child link="{0}_link"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="1" effort="50" velocity="20"/>{2}</joint>"""
URDF = f"""<robot name="bench">{_LINK.format("base_link")}{"".join(_LINK.format(f"{name}_link") for name in _JOINTS)}
{_JOINT.format("slide", "prismatic", "")}{_JOINT.format("glide", "prismatic", "")}{_JOINT.format("spin", "continuous", "")}
{_LINK.format("echo_link")}{_JOINT.format("echo", "prismatic", '<mimic joint="glide"/>')}</robot>"""
ROBOT = """robot: bench
urdf: bench.urdf
fixed_base: true
joints:
  slide: {drive: {stiffness: 800, damping: 80}}
  spin: {drive: {damping: 50}}
"""
SCENE = "scene: bench\nworld: worlds/flat_grid.xml\nrobots: {bench: {use: bench.yaml, position: [0, 0, 1]}}\n"
HOLD = """graph: hold
nodes:
  Tick: OnPlaybackTick
  Art: {type: ArticulationController, inputs: {robotPath: /bench, jointNames: [slide], positionCommand: [0.2]}}
connections: [Tick.tick -> Art.execIn]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in {"bench.urdf": URDF, "bench.yaml": ROBOT, "scene.yaml": SCENE, "hold.yaml": HOLD}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture
def bench(folder: Path) -> Iterator[ge.Session]:
    """A fixed base with a driven slide, a driven spin, a glide without a drive, and an echo that follows the glide."""
    with ge.load(folder / "scene.yaml").session() as sim:
        yield sim


def clamped(sim: ge.Session) -> dict[str, int]:
    return dict(parse("state").apply(sim._runner.session).get("clamped_commands", {}))


def test_a_prismatic_joint_reaches_its_commanded_position(bench: ge.Session) -> None:
    robot = bench.robots["bench"]
    robot.command(positions={"slide": 0.5})
    assert robot.joints["slide"].position == 0.0
    bench.run(3.0)  # critically damped with 20 / s: 80² = 4 x 2 kg x 800
    assert robot.joints["slide"].position == pytest.approx(0.5, abs=1e-6)


def test_an_effort_accelerates_its_joint_and_a_velocity_is_reached(bench: ge.Session) -> None:
    robot, ticks = bench.robots["bench"], 30
    robot.command(velocities={"spin": 3.0}, efforts={"slide": 8.0})
    bench.step(ticks)
    assert robot.joints["spin"].velocity == pytest.approx(3.0, rel=1e-3)
    bench.run(3.0)
    assert robot.joints["slide"].position == pytest.approx(8.0 / 800.0, rel=1e-3)  # where the spring holds the force


def test_wheels_drive_a_robot_by_their_radius_and_a_replay_is_identical(tmp_path: Path) -> None:
    speed, seconds = 5.0, 2.0
    (tmp_path / "bot.yaml").write_text(
        "robot: bot\nextends: robots/dd100.yaml\ngraphs: {cmd_vel: {use: idle.yaml}}\n", "utf-8"
    )
    (tmp_path / "idle.yaml").write_text("graph: idle\nnodes: {Tick: OnPlaybackTick}\n", "utf-8")
    flat = "scene: flat\nworld: worlds/flat_grid.xml\nrobots: {bot: {use: bot.yaml, position: [0, 0, 0.025]}}\n"
    (tmp_path / "flat.yaml").write_text(flat, "utf-8")
    with ge.load(tmp_path / "flat.yaml", rays="mujoco").session(record=tmp_path / "run.mcap") as sim:
        robot = sim.robots["bot"]
        robot.command(velocities=[speed, speed], joints=WHEELS)
        sim.run(1.0)
        start = robot.pose.position[0]
        sim.run(seconds)
        assert robot.pose.position[0] - start == pytest.approx(RADIUS * speed * seconds, rel=0.005)
        robot.command(velocities=np.array([0.1, 1 / 3]))  # all joints, in their order
        sim.run(0.5)
    assert main(["replay", str(tmp_path / "run.mcap")]) == 0


def test_a_target_acts_in_the_next_tick_before_the_graph_whose_target_then_wins(folder: Path) -> None:
    (folder / "scene.yaml").write_text(f"{SCENE}graphs: {{hold: {{use: hold.yaml}}}}\n", encoding="utf-8")
    with ge.load(folder / "scene.yaml").session() as sim:
        sim.step(2)
        control = sim.mujoco.data.actuator("bench/slide.position").ctrl
        assert control[0] == 0.2
        sim.robots["bench"].command(positions={"slide": 0.5})
        assert control[0] == 0.2
        sim.step()
        assert control[0] == 0.5
        sim.step()
        assert control[0] == 0.2


def test_targets_beyond_the_limits_are_clamped_and_counted(bench: ge.Session) -> None:
    robot = bench.robots["bench"]
    robot.command(positions={"slide": 7.0}, efforts={"glide": -60.0})
    assert clamped(bench) == {
        "position of /bench/slide beyond -9 to 1": 1,
        "effort of /bench/glide beyond -50 to 50": 1,
    }
    bench.step()
    assert bench.mujoco.data.actuator("bench/slide.position").ctrl[0] == 1.0


def test_nan_keeps_the_target_of_its_joint(bench: ge.Session) -> None:
    robot = bench.robots["bench"]
    robot.command(positions={"slide": 0.3})
    robot.command(positions=[math.nan], velocities=[2.0], joints=["slide"])
    bench.step()
    assert bench.mujoco.data.actuator("bench/slide.position").ctrl[0] == 0.3
    assert bench.mujoco.data.actuator("bench/slide.velocity").ctrl[0] == 2.0


WRONG: list[tuple[dict[str, Any], str]] = [
    ({}, "command: give positions, velocities or efforts"),
    ({"positions": {"slied": 0.5}}, "/bench has no joint 'slied'\n  did you mean 'slide'"),
    (
        {"positions": {"slide": 0.5}, "velocities": {"glide": 1.0}},
        "without a drive for velocity targets: glide\n  give these",
    ),
    (
        {"positions": {"spin": 1.0}},
        "without a drive for position targets: spin\n  give these joints a drive with stiffness",
    ),
    ({"positions": {"echo": 1.0}}, "without a drive for position targets: echo\n  joint echo of /bench follows glide"),
    (
        {"positions": [0.5, 0.5], "joints": ["slide"]},
        "positions: expected one number for each of 1 different joints, got 2",
    ),
    ({"positions": [0.5]}, "expected one number for each of 4 different joints, got 1\n  joints: slide, "),
    ({"positions": [0.5, 0.5], "joints": ["slide", "slide"]}, "for each of 2 different joints"),
    ({"positions": {"slide": 0.5}, "joints": ["slide"]}, "positions: the mapping names its joints"),
    ({"positions": {"slide": math.inf}}, "command: slide: expected a finite number, got inf"),
    ({"positions": {"slide": 0.5}, "efforts": {"glide": 1e300}}, "up to 1e+10 for joint 'glide'"),
    ({"positions": {"slide": "fast"}}, "command: slide: expected a number, got 'fast'"),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG)
def test_an_invalid_command_is_refused_and_changes_nothing(bench: ge.Session, arguments: Any, words: str) -> None:
    with pytest.raises(ge.UsageError) as caught:
        bench.robots["bench"].command(**arguments)
    assert words in str(caught.value)
    bench.step()
    assert not bench.mujoco.data.ctrl.any()
    assert not clamped(bench)


def test_an_actuator_has_the_name_of_its_joint(tmp_path: Path) -> None:
    write_model(tmp_path, "sink.xml", KITCHEN_SINK)
    scene = write_model(tmp_path, "scene.yaml", SCENE.replace("bench.yaml", "sink.xml"))
    with ge.load(scene).session() as sim:
        robot, data = sim.robots["bench"], sim.mujoco.data
        robot.command(
            positions={"gripper": 0.02}, efforts={"lift_motor": 5.0}
        )  # a tendon of two joints; a motor of one
        sim.step()
        assert data.actuator("bench/gripper").ctrl[0] == pytest.approx(0.02 * 100 / 0.0157)  # what its spring holds
        assert data.actuator("bench/lift_motor").ctrl[0] == pytest.approx(5.0 / 10)  # gear
        with pytest.raises(ge.UsageError, match="without a drive for effort targets: gripper\n  command the joints"):
            robot.command(efforts={"gripper": 1.0})


def test_a_robot_that_was_removed_has_no_joints(bench: ge.Session) -> None:
    robot = bench.robots["bench"]
    bench.remove("bench")
    with pytest.raises(ge.UnknownEntityError, match="no robot 'bench'"):
        robot.command(positions={"slide": 0.5})
    with pytest.raises(ge.UnknownEntityError, match="no robot 'bench'"):
        robot.command(positions=[0.5])
