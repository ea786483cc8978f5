"""`graphrun new` runs what it wrote for 2 s, and says what falls, hangs, sags or starts inside something."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from graphengine.cli.first_run import MOST_TOLD, _worst, first_run
from tests.bringup.robots.imported_arms import BALL, arm, bolted
from tests.bringup.robots.imported_bases import DIFFERENTIAL, description, interfaces
from tests.cli.harness import Graphrun

STILTS = """<mujoco model="stilts">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="hip" pos="0 0 0.9"><freejoint/>
      <geom type="box" size="0.1 0.15 0.1" mass="10"/>
      <body name="leg" pos="0.05 0 -0.1"><joint name="knee" axis="0 1 0" range="-1 1"/>
        <geom type="capsule" size="0.03" fromto="0 0 0 0 0 -0.75" mass="2"/></body>
    </body>
  </worldbody>
  <actuator><motor joint="knee" ctrlrange="-10 10"/></actuator>
</mujoco>
"""
SAGGING = """<mujoco model="boom">
  <compiler angle="radian" autolimits="true"/>
  <worldbody><body name="base" pos="0 0 1">
    <geom type="box" size="0.1 0.1 0.1" mass="5"/>
    <body name="boom"><joint name="lift" axis="0 1 0" range="-2 2" damping="5"/>
      <inertial pos="0.5 0 0" mass="2" diaginertia="0.01 0.01 0.01"/>
      <geom type="capsule" size="0.02" fromto="0.2 0 0 1 0 0"/></body>
  </body></worldbody>
  <actuator><position joint="lift" kp="200"/></actuator>
</mujoco>
"""
LEVEL = """<link name="shoulder"/><joint name="level" type="fixed"><parent link="plate"/><child link="shoulder"/>
  <origin xyz="0 0 0.5" rpy="0 1.5707963 0"/></joint>"""
"""A link whose z axis is level, so an arm on it needs torque to keep its pose."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run_of(graphrun: Graphrun, source: str, *more: str, name: str = "bot.urdf") -> list[str]:
    """What the run of the new project of a description shows."""
    Path(name).write_text(source)
    lines = graphrun("new", "bot", "--from", name, *more, code=0, err="").lines
    return [line.partition(": ")[2] for line in lines if line.startswith("in a run of 2 s: ")]


def test_a_robot_at_rest_is_not_reported(graphrun: Graphrun) -> None:
    assert run_of(graphrun, description(DIFFERENTIAL)) == []


def test_links_with_slashes_in_their_names_have_prims_that_the_graphs_find(graphrun: Graphrun) -> None:
    assert run_of(graphrun, description(DIFFERENTIAL).replace('"base_link"', '"/cart/base_link"')) == []
    assert "base: _cart_base_link" in Path("bot/robots/bot.yaml").read_text()


def test_a_robot_on_one_leg_falls(graphrun: Graphrun) -> None:
    falls, *_ = run_of(graphrun, STILTS, name="bot.xml")
    assert re.fullmatch(
        r"the robot falls: after 2 s its base link is( \d+ mm lower and)? tilted by 1?\d\d degrees", falls
    )


def test_a_joint_that_swings_fails_the_test_of_its_project(graphrun: Graphrun) -> None:
    swing = SAGGING.replace('<position joint="lift" kp="200"/>', '<motor joint="lift" ctrlrange="-1 1"/>')
    (hangs,) = run_of(graphrun, swing.replace('damping="5"', 'damping="0"'), "--fixed-base", name="bot.xml")
    assert hangs.startswith("joints without a position servo move, rad or m: lift +1.")
    scene = Path("bot/bot.yaml")
    scene.write_text(scene.read_text().replace("settle: true", "settle: false"))
    assert first_run(scene, "bot", holds=True)[1].startswith("test_robot.py fails: a joint moves ")


def test_a_servo_of_a_mujoco_model_sags_by_its_weight_over_its_gain(graphrun: Graphrun) -> None:
    """2 kg at 0.5 m with 200 N m/rad: 9.81 cos(a) = 200 a."""
    (line,) = run_of(graphrun, SAGGING, "--fixed-base", name="bot.xml")
    found = re.fullmatch(r"drives are off their targets, .*: lift \+0\.0(\d+)", line)
    assert found is not None, line
    assert int(found[1]) == pytest.approx(49, abs=1)


def test_joints_that_take_efforts_hang_unless_they_get_position_drives(graphrun: Graphrun) -> None:
    text = bolted(LEVEL, arm(3, "shoulder"), interfaces(joint_1="effort", joint_2="effort", joint_3="effort"))
    (line,) = run_of(graphrun, text)
    assert line.startswith("joints without a drive hang, rad or m: ")
    assert "--position-drives" in line
    Path("bot").rename("limp")
    assert run_of(graphrun, text, "--position-drives") == []
    assert "FollowJointTrajectory" in Path("bot/README.md").read_text()


def test_a_joint_with_a_weak_velocity_drive_is_not_reported_as_hanging(graphrun: Graphrun) -> None:
    """1 kg at 0.5 m with 10 N m s/rad moves by about 1 rad in 2 s."""
    ball = BALL.replace("<geometry>", '<origin xyz="0.5 0 0"/><geometry>')
    text = bolted(arm(1, "plate").replace(BALL, ball), interfaces(joint_1="velocity"))
    Path("bot.urdf").write_text(text)
    graphrun("new", "bot", "--from", "bot.urdf", code=0, err="")
    file = Path("bot/robots/bot.yaml")
    file.write_text(re.sub(r"damping: [\d.]+", "damping: 1.0", file.read_text()))
    assert "damping: 1.0" in file.read_text()
    assert not any("without a drive" in line for line in first_run(Path("bot/bot.yaml"), "bot", holds=False))


def test_a_model_of_mujoco_has_its_own_drives(graphrun: Graphrun) -> None:
    Path("bot.xml").write_text(SAGGING)
    graphrun(
        "new",
        "bot",
        "--from",
        "bot.xml",
        "--position-drives",
        code=2,
        err="graphrun new: --position-drives: bot.xml is a MuJoCo model, which has its own actuators\n",
    )


def test_a_robot_that_starts_inside_the_world_is_reported(graphrun: Graphrun) -> None:
    """In a cube on the table, on which the arm is mounted."""
    inside = BALL.replace("<geometry>", '<origin xyz="0.38 -0.36 -0.08"/><geometry>')
    first, *_ = run_of(graphrun, bolted(arm(3, "plate").replace(BALL, inside, 1)))
    assert first.startswith("at the start, bot touches ")


def test_an_arm_whose_colliders_reach_below_its_base_is_mounted_higher(graphrun: Graphrun) -> None:
    """Its ball of 30 mm is 120 mm below the first joint, which is 100 mm above the base."""
    low = BALL.replace("<geometry>", '<origin xyz="0.2 0 -0.12"/><geometry>')
    assert not any("touches" in line for line in run_of(graphrun, bolted(arm(3, "plate").replace(BALL, low, 1))))
    assert "position: [0, 0, 0.8]" in Path("bot/bot.yaml").read_text()


def test_a_line_names_the_worst_joints_up_to_a_number() -> None:
    errors = [(f"j{number}", 0.1 * number) for number in range(MOST_TOLD + 2)]
    assert _worst("off: {}", errors[: MOST_TOLD + 1], 0.05) == [
        "off: j6 +0.600, j5 +0.500, j4 +0.400, j3 +0.300, j2 +0.200, j1 +0.100"
    ]
    [line] = _worst("off: {}", errors, 0.05)
    assert line.startswith("off: j7 +0.700, j6 +0.600")
    assert line.endswith("j2 +0.200 and 1 more")
