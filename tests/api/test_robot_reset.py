"""One robot back at its start, or elsewhere, while the others go on; recorded, and the same in a replay."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.cli import main
from graphengine.messages.messages import Odometry
from tests.api.test_robot_command import ROBOT, SCENE, URDF

START, HEIGHT = 0.3, 0.025  # rad or m, where the slide starts; m, where the dd100 stands
MIMIC = '<mimic joint="glide" multiplier="2" offset="0.1"/>'
ARM = """<mujoco model="arm"><compiler angle="radian"/><worldbody><body name="base"><freejoint name="float"/>
<geom type="box" size=".2 .2 .1" mass="9"/><body name="link" pos="0 0 .3"><joint name="shoulder" axis="0 1 0" range="-2 2"/>
<geom type="capsule" fromto="0 0 0 0 0 .2" size=".02" mass="1"/></body></body></worldbody>
<actuator><position name="servo" joint="shoulder" kp="100" kv="10"/></actuator>
<keyframe><key name="home" qpos="0 0 .1 1 0 0 0 0.4" ctrl="0.4"/><key name="up" qpos="0 0 .1 1 0 0 0 -0.6" ctrl="-0.6"/>
</keyframe></mujoco>"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    files = {
        "bench.urdf": URDF.replace('<mimic joint="glide"/>', MIMIC),
        "bench.yaml": ROBOT.replace("slide: {", f"slide: {{start: {START}, "),
        "scene.yaml": SCENE,
        "arm.xml": ARM,
        "arms.yaml": "scene: arms\nworld: worlds/flat_grid.xml\nrobots:\n"
        "  left: {use: arm.xml, position: [0, 0, 0], start: home}\n  right: {use: arm.xml, position: [0, 2, 0], start: home}\n",
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture
def bench(folder: Path) -> Iterator[ge.Session]:
    with ge.load(folder / "scene.yaml").session() as sim:
        yield sim


@pytest.fixture
def arms(folder: Path) -> Iterator[ge.Session]:
    with ge.load(folder / "arms.yaml").session() as sim:
        yield sim


def test_joints_are_where_they_started_or_are_told_to_be_and_drives_hold_them(bench: ge.Session) -> None:
    robot = bench.robots["bench"]
    robot.command(positions={"slide": -0.5}, velocities={"spin": 5.0}, efforts={"glide": 3.0})
    bench.run(1.0)
    robot.reset(joints={"glide": 0.2})
    found = {name: joint.position for name, joint in robot.joints.items()}
    assert found == {"slide": START, "glide": 0.2, "spin": 0.0, "echo": pytest.approx(2 * 0.2 + 0.1)}
    assert all(joint.velocity == 0.0 for joint in robot.joints.values())
    bench.run(1.0)
    assert robot.joints["slide"].position == pytest.approx(START, abs=1e-6)
    assert robot.joints["spin"].velocity == pytest.approx(0.0, abs=1e-6)
    robot.reset(joints={"slide": -0.7})
    bench.run(1.0)
    assert robot.joints["slide"].position == pytest.approx(-0.7, abs=1e-6)


def test_without_arguments_it_is_the_state_after_a_reset_of_the_session(bench: ge.Session) -> None:
    def state() -> tuple[list[float], ...]:
        data = bench.mujoco.data
        return data.qpos.tolist(), data.qvel.tolist(), data.ctrl.tolist(), data.qfrc_applied.tolist()

    bench.reset("state")
    bench.step(3)
    expected = state()
    bench.robots["bench"].command(positions={"slide": -0.5}, efforts={"glide": 3.0})
    bench.run(1.0)
    bench.robots["bench"].reset()
    bench.step(3)
    assert state() == expected


def test_a_keyframe_replaces_the_start_and_the_other_robot_goes_on(arms: ge.Session) -> None:
    left, right = arms.robots["left"], arms.robots["right"]
    for robot in (left, right):
        robot.command(positions={"shoulder": 1.0})
    arms.run(1.0)
    before = right.joints["shoulder"].position
    left.reset(keyframe="up", position=(3.0, 1.0, 0.1))
    assert left.joints["shoulder"].position == -0.6
    assert left.pose.position == pytest.approx((3.0, 1.0, 0.1))
    assert left.pose.orientation == (0.0, 0.0, 0.0, 1.0)
    assert right.joints["shoulder"].position == before
    arms.step()
    assert arms.mujoco.data.actuator("left/servo").ctrl[0] == -0.6
    assert arms.mujoco.data.actuator("right/servo").ctrl[0] == 1.0
    left.reset(keyframe="up", joints={"shoulder": 0.5})
    assert left.joints["shoulder"].position == 0.5
    assert left.pose.position == pytest.approx((0.0, 0.0, 0.1))


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"joints": {"shulder": 0.0}}, "no joint 'shulder'\n  did you mean 'shoulder'"),
    ({"joints": {"shoulder": 2.5}}, "cannot be at 2.5, which is outside of its limits\n  legal: -2 to 2"),
    ({"joints": {"shoulder": math.inf}}, "expected a finite number"),
    ({"keyframe": "hom"}, "no keyframe 'hom'\n  did you mean 'home'"),
    ({"position": (0.0, 2.1, 0.1)}, "left would be"),
    ({"position": (1e9, 0.0, 0.0)}, "invalid position"),
    ({"orientation": (0.0, 0.0, 0.0, 0.0)}, "must have length 1"),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG)
def test_what_cannot_be_is_refused_and_changes_nothing(arms: ge.Session, arguments: Any, words: str) -> None:
    robot = arms.robots["left"]
    robot.command(positions={"shoulder": 1.0})
    arms.run(0.5)
    before = arms.mujoco.data.qpos.tolist(), arms.mujoco.data.qvel.tolist(), arms.mujoco.data.ctrl.tolist()
    with pytest.raises(ge.UsageError) as caught:
        robot.reset(**arguments)
    assert words in str(caught.value)
    assert before == (arms.mujoco.data.qpos.tolist(), arms.mujoco.data.qvel.tolist(), arms.mujoco.data.ctrl.tolist())


@pytest.mark.parametrize("angle", [1e20, math.inf])
def test_a_joint_position_that_mujoco_cannot_compute_is_refused_and_the_run_goes_on(
    bench: ge.Session, angle: float
) -> None:
    bench.run(0.1)
    before = bench.mujoco.data.qpos.tolist()
    with pytest.raises(ge.UsageError):
        bench.robots["bench"].reset(joints={"spin": angle})
    assert bench.mujoco.data.qpos.tolist() == before
    bench.run(0.1)
    assert bench.state == "paused"


def test_the_reset_of_a_robot_that_was_not_moved_keeps_the_model(bench: ge.Session) -> None:
    model = bench.mujoco.model
    bench.robots["bench"].reset(joints={"slide": 0.1})
    assert bench.mujoco.model is model


def test_a_follower_is_not_placed_by_itself(bench: ge.Session) -> None:
    with pytest.raises(ge.UsageError, match="joint 'echo' follows 'glide'\n  give a position for glide instead"):
        bench.robots["bench"].reset(joints={"echo": 0.5})


def test_a_robot_fixed_to_the_world_returns_from_where_it_was_moved(bench: ge.Session) -> None:
    robot = bench.robots["bench"]
    bench.move("bench", position=(4.0, 0.0, 1.0))
    robot.reset(joints={"slide": 0.1})
    assert robot.pose.position == (0.0, 0.0, 1.0)
    robot.reset(position=(0.0, 3.0, 1.0))
    assert robot.pose.position == (0.0, 3.0, 1.0)
    assert robot.joints["slide"].position == START


def test_pushes_end_and_sensors_and_odometry_behave_as_after_a_move(sim: ge.Session) -> None:
    robot = sim.robots["dd100"]
    lidar = robot.sensors["sim_lidar"]
    lidar.sample()
    odom = sim.subscribe("/dd100_0000/odom", Odometry)
    robot.publish("cmd_vel", {"linear": {"x": 0.5}})
    sim.run(0.4)
    driven = [*odom][-1].pose.pose.position.x
    sim.push("dd100", force=(300.0, 0.0, 0.0), duration=60.0)
    robot.reset(position=(2.0, 0.0, HEIGHT))
    assert lidar.sample() is None
    assert robot.velocity.linear == (0.0, 0.0, 0.0)
    sim.step()
    assert [*odom][-1].pose.pose.position.x == pytest.approx(driven, abs=0.05)
    sim.run(1.0)
    assert robot.pose.position[0] < 2.6  # with the push of 300 N on 13 kg it would be 10 m ahead


def test_the_call_is_recorded_and_a_replay_sends_the_same_bytes(tmp_path: Path) -> None:
    with ge.load("dd100_flat", rays="mujoco").session(record=tmp_path / "run.mcap") as sim:
        robot = sim.robots["dd100"]
        robot.publish("cmd_vel", {"linear": {"x": 0.5}, "angular": {"z": 1.0}}, every=0.1)
        sim.run(0.7)
        angle = 1.0 / 3.0
        robot.reset(position=(1.0, 1 / 3, HEIGHT))
        sim.run(0.5)
        robot.reset(joints={"front_left_wheel_joint": angle}, orientation=(0.0, 0.0, math.sin(angle), math.cos(angle)))
        sim.run(0.5)
    assert main(["replay", str(tmp_path / "run.mcap")]) == 0
