"""Measured figures are written to the files that hold them, and the next calibration is within bounds."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

import graphengine as ge
from graphengine import bringup
from graphengine.bringup.calibration.figures import Calibration, Covariances, Motion, Odometry, Twist
from graphengine.bringup.calibration.write_back import write_figures
from tests.bringup.calibration import bases

ROOT = Path(__file__).resolve().parents[3]
MEASURED = Calibration(
    "bot", "/cmd_vel", "", 0.3, 0.6, moves=True, wheel_radius=0.04912345, track=0.61234567, wheel_base=0.31
)


def test_a_skid_steered_base_turns_as_commanded_after_its_effective_track_is_written(tmp_path: Path) -> None:
    base = bases.skid_steered(tmp_path).write()
    scene = ge.load(base.scene)
    changes, notes = write_figures(scene, bringup.calibrate(scene))
    assert {change.node for change in changes} == {"drive/Drive.wheelRadius", "drive/Drive.wheelDistance"}
    assert notes == []
    assert bringup.calibrate(ge.load(base.scene)).outside(0.01) == ()


def test_only_the_number_in_a_graph_file_is_replaced_below_a_comment(tmp_path: Path) -> None:
    base = bases.skid_steered(tmp_path).write()
    before = (tmp_path / "drive.yaml").read_text(encoding="utf-8")
    write_figures(ge.load(base.scene), MEASURED)
    comment = "      # graphrun calibrate: measured at 0.3 m/s and 0.6 rad/s\n"
    expected = before.replace("      wheelRadius: 0.05 ", f"{comment}      wheelRadius: 0.049123 ")
    expected = expected.replace("      wheelDistance: 0.3\n", f"{comment}      wheelDistance: 0.61235\n")
    assert (tmp_path / "drive.yaml").read_text(encoding="utf-8") == expected


def test_a_parameter_is_replaced_or_added_where_the_robot_file_uses_the_graph(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.graphs["drive"] = "{use: drive.yaml, parameters: {wheels: [left_joint, right_joint], radius: 0.05}}"
    base.write()
    write_figures(ge.load(base.scene), MEASURED)
    text = (tmp_path / "bot.yaml").read_text(encoding="utf-8")
    assert "parameters: {wheels: [left_joint, right_joint], radius: 0.049123, distance: 0.61235}" in text
    assert text.startswith("# A base of a test.\n")


def test_a_parameter_of_a_graph_in_a_graph_is_replaced_in_the_robot_file(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    del base.graphs["drive"]
    given = "{wheels: [left_joint, right_joint], radius: $(r), robot: /bot}"
    base.graph("outer", f"  Inner: {{subgraph: drive.yaml, parameters: {given}}}\n", "  []\n")
    path = tmp_path / "outer.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(
        text.replace("default: /bot}", "default: /bot}, r: {type: double, default: 0.05}"), encoding="utf-8"
    )
    base.graphs["outer"] = "{use: outer.yaml, parameters: {r: 0.05}}"
    changes, notes = write_figures(ge.load(base.write().scene), MEASURED)
    assert [(change.path.name, change.location[-1], change.new) for change in changes] == [("bot.yaml", "r", 0.049123)]
    assert len(notes) == 1
    assert notes[0].startswith("outer/Inner/DiffController.wheelDistance: not written")


def test_the_geometry_of_wheels_that_slip_is_not_written(tmp_path: Path) -> None:
    base = bases.differential(tmp_path).write()
    slips = Motion("forward", "straight", Twist(x=0.3), Twist(x=0.1), 0.33, slip=0.67)
    changes, notes = write_figures(ge.load(base.scene), replace(MEASURED, motions=(slips,)))
    assert changes == []
    assert notes == ["wheel radius, track and wheel base are not written: the wheels slip (forward)"]


def test_correct_values_are_not_changed(tmp_path: Path) -> None:
    base = bases.differential(tmp_path).write()
    right = Calibration("bot", "", "", 0.3, 0.6, moves=True, wheel_radius=bases.RADIUS * 1.0004, track=bases.TRACK)
    before = (tmp_path / "bot.yaml").read_bytes()
    assert write_figures(ge.load(base.scene), right) == ([], [])
    assert (tmp_path / "bot.yaml").read_bytes() == before


def test_files_that_ship_are_refused_and_nothing_is_written() -> None:
    scene = ge.load("dd100_flat")
    path = ROOT / "graphs" / "dd100" / "cmd_vel.yaml"
    before = path.read_bytes()
    wrong = Calibration("dd100", "", "", 0.3, 0.6, moves=True, wheel_radius=0.06)
    with pytest.raises(
        ge.UsageError, match=r"cmd_vel.yaml ships with graphengine[\s\S]*copy the file into your project"
    ):
        write_figures(scene, wrong)
    assert path.read_bytes() == before


def test_a_copy_of_a_shipped_robot_is_written(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "graphs" / "dd100", tmp_path / "graphs")
    (tmp_path / "robot.yaml").write_text(
        "robot: dd100\nextends: robots/dd100.yaml\ngraphs: {cmd_vel: {use: graphs/cmd_vel.yaml}}\n", encoding="utf-8"
    )
    (tmp_path / "scene.yaml").write_text(
        "scene: s\nworld: worlds/flat_grid.xml\nrobots: {dd100: {use: robot.yaml}}\n", encoding="utf-8"
    )
    wrong = Calibration("dd100", "", "", 0.3, 0.6, moves=True, wheel_radius=0.06)
    changes, _ = write_figures(ge.load(tmp_path / "scene.yaml"), wrong)
    assert [change.path.name for change in changes] == ["cmd_vel.yaml"]
    assert "wheelRadius: 0.06  " in (tmp_path / "graphs" / "cmd_vel.yaml").read_text(encoding="utf-8")


def test_the_calibration_of_a_mecanum_base_is_written_for_controller_and_odometry(tmp_path: Path) -> None:
    base = bases.mecanum(tmp_path).write()
    variances = Covariances(1e-4, 1e-5, 1e-6)
    measured = Calibration(
        "bot", "", "", 0.3, 0.6, moves=True, kinematics="mecanum", wheel_radius=0.049, track=0.64,
        odometry=(Odometry("/odom", "base_link", covariances=variances),),
    )  # fmt: skip
    changes, notes = write_figures(ge.load(base.scene), measured)
    assert [(change.path.name, change.location[-1], change.new) for change in changes] == [
        ("bot.yaml", "radius", 0.049),
        ("bot.yaml", "track", 0.34),  # without the wheel base
        ("bot.yaml", "distance_variance", 1e-4),
        ("bot.yaml", "heading_variance_by_distance", 1e-5),
        ("bot.yaml", "heading_variance_by_turn", 1e-6),
    ]
    assert notes == []
    ge.load(base.scene)


def test_covariances_are_added_to_an_odometry_of_the_user(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    joints = "targetPrim: $(robot), leftJoints: [left_joint], rightJoints: [right_joint]"
    inputs = f"{{{joints}, wheelRadius: 0.05, wheelDistance: 0.3}}"
    wheels = f"  Wheels: {{type: ComputeWheelOdometry, inputs: {inputs}}}\n"
    nodes = f"  Tick: OnPlaybackTick\n{wheels}  Publish: ROS2PublishOdometry\n"
    base.graph("odom", nodes, "  - Tick.tick -> Wheels.execIn\n  - Wheels.execOut -> Publish.execIn\n")
    base.write()
    odometry = Odometry("/odom", "base_link", covariances=Covariances(1e-4, 1e-5, 0.0))
    result = Calibration("bot", "", "", 0.3, 0.6, moves=True, odometry=(odometry,))
    write_figures(ge.load(base.scene), result)
    text = (tmp_path / "odom.yaml").read_text(encoding="utf-8")
    assert "wheelDistance: 0.3, distanceVariance: 0.0001, headingVarianceByDistance: 1.0e-05}" in text
    ge.load(base.scene)


def test_without_covariance_inputs_no_covariance_is_written(tmp_path: Path) -> None:
    base = bases.differential(tmp_path)
    base.odometry()
    base.write()
    odometry = Odometry("/odom", "base_link", covariances=Covariances(1e-4, 1e-5, 1e-6))
    result = Calibration("bot", "", "", 0.3, 0.6, moves=True, odometry=(odometry,))
    assert write_figures(ge.load(base.scene), result) == ([], [])
