"""Omni and mecanum wheels whose rollers a description models, and how a base drives on them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.api.bodies import Pose
from tests.bringup.robots.descriptions import INERTIA
from tests.bringup.robots.imported_bases import (
    DIFFERENTIAL,
    PLUGIN,
    description,
    imported,
    remarks,
    robot_file,
    scene,
)
from tests.bringup.robots.roller_bases import FOUR, PLAIN, THREE, rolling_base, rolling_radius


def test_the_radius_of_a_wheel_is_the_radius_of_the_hull_of_its_rollers(tmp_path: Path) -> None:
    """Not that of its rim, 0.04 m, nor the largest reach of its rollers, which is above the mean by the corners of the hull."""
    base = robot_file(imported(tmp_path, rolling_base(THREE, 8, 0.024)))["graphs"]["base"]
    assert base["use"].endswith("omni.yaml")
    assert base["parameters"]["radius"] == pytest.approx(rolling_radius(8, 0.024), rel=1e-3)
    assert base["parameters"]["wheels"] == ["wheel_1_joint", "wheel_3_joint", "wheel_2_joint"]


def test_rollers_turn_freely_with_full_grip_and_their_axes_identify_mecanum_wheels(tmp_path: Path) -> None:
    found = imported(tmp_path, rolling_base(FOUR))
    file = robot_file(found)
    assert file["graphs"]["base"]["use"].endswith("mecanum.yaml")
    assert file["graphs"]["base"]["parameters"].get("rollers", [45, -45, -45, 45]) == pytest.approx([45, -45, -45, 45])
    assert [name for name, joint in file["joints"].items() if joint] == [f"wheel_{n}_joint" for n in range(1, 5)]
    (material,) = file["materials"].values()
    assert material["static_friction"] == 1.0
    assert len(material["bind"]) == 48
    assert "direction" not in material
    assert "no drive, turns freely" in remarks(found)


@pytest.mark.parametrize(("x", "y", "turn"), [(0.3, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 0.6)])
def test_a_base_on_rollers_drives_as_commanded(tmp_path: Path, x: float, y: float, turn: float) -> None:
    """Over 3 s, from 1 s on, after the ramp of the wheels."""
    command: dict[str, Any] = {"linear": {"x": x, "y": y}, "angular": {"z": turn}}
    with ge.load(scene(tmp_path, imported(tmp_path, rolling_base(THREE)))).session() as sim:
        poses = []
        for _ in range(16):
            sim.robots["bot"].publish("cmd_vel", command)
            sim.run(0.25)
            poses.append(sim.robots["bot"].pose)
    before, after = poses[3], poses[-1]
    assert math.dist(before.position[:2], after.position[:2]) / 3.0 == pytest.approx(x + y, rel=0.01, abs=1e-3)
    assert (yaw(after) - yaw(before)) / 3.0 == pytest.approx(turn, rel=0.01, abs=2e-3)


def yaw(pose: Pose) -> float:
    """Heading (rad) of a pose whose z axis is vertical."""
    _, _, z, w = pose.orientation
    return 2.0 * math.atan2(z, w)


def test_a_differential_controller_does_not_drive_mecanum_rollers(tmp_path: Path) -> None:
    """On rollers at 45 degrees, two driven wheels would push the base aside."""
    plugin = PLUGIN.replace("left_joint<", "wheel_3_joint<").replace("right_joint<", "wheel_4_joint<")
    found = imported(tmp_path, rolling_base(FOUR).replace("</robot>", f"{plugin}</robot>"))
    assert robot_file(found)["graphs"]["base"]["use"].endswith("mecanum.yaml")
    assert "lost: Gazebo's plugin DiffDrive: its wheels have diagonal rollers" in remarks(found)


def test_the_middle_of_three_wheels_is_their_mean(tmp_path: Path) -> None:
    """The middle of the rectangle around them lies a quarter of their distance from it beside the centre of mass."""
    assert "to one side of the middle" not in remarks(imported(tmp_path, PLAIN.urdf()))


@pytest.mark.parametrize(("x", "turn"), [(-0.3, 0.0), (0.0, 0.6)])
def test_a_caster_with_the_friction_of_the_description_does_not_make_the_base_jump(
    tmp_path: Path, x: float, turn: float
) -> None:
    """It carries almost half of the weight, on a ball fixed to the chassis, as in a well-known tutorial."""
    mass = f'<inertial><origin xyz="-0.05 0 0.05"/><mass value="14"/>{INERTIA}</inertial>'
    text = description(DIFFERENTIAL, PLUGIN).replace('<link name="front_ball">', f'<link name="front_ball">{mass}')
    text = text.replace(
        "</robot>", '<gazebo reference="front_ball"><mu1 value="0.5"/><mu2 value="0.5"/></gazebo></robot>'
    )
    found = imported(tmp_path, text)
    (material,) = (each for each in robot_file(found)["materials"].values() if "front_ball" in each["bind"])
    assert (material["across"], material["steady_sliding"]) == (0.5, True)
    assert "carried: link front_ball: friction 0.5" in remarks(found)
    with ge.load(scene(tmp_path, found)).session() as sim:
        sim.robots["bot"].publish("cmd_vel", {"linear": {"x": x}, "angular": {"z": turn}}, every=0.1)
        sim.run(1.5)
        before = sim.robots["bot"].pose
        sim.run(2.0)
        after = sim.robots["bot"].pose
    assert math.dist(before.position[:2], after.position[:2]) / 2.0 == pytest.approx(abs(x), rel=0.01, abs=2e-3)
    assert (yaw(after) - yaw(before)) / 2.0 == pytest.approx(turn, rel=0.02, abs=2e-3)
