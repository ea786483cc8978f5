"""Joints that follow another one by `<param name="mimic">` of a `<ros2_control>`, as descriptions of ROS 2 Humble have it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bringup.robots.harness import INERTIA, imported, keys


def limb(name: str, y: float) -> str:
    return f"""<link name="{name}"><inertial><mass value="1"/>{INERTIA}</inertial></link>
  <joint name="{name}_joint" type="revolute">
    <parent link="base_link"/><child link="{name}"/><origin xyz="0 {y} 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/>
  </joint>"""


def listed(name: str, *parameters: tuple[str, str]) -> str:
    given = "".join(f'<param name="{key}">{value}</param>' for key, value in parameters)
    return f'<joint name="{name}_joint">{given}<command_interface name="position"/></joint>'


def gripper(*parameters: tuple[str, str]) -> str:
    control = f'<ros2_control name="hand" type="system">{listed("left")}{listed("right", *parameters)}</ros2_control>'
    base = f'<link name="base_link"><inertial><mass value="1"/>{INERTIA}</inertial></link>'
    return f'<robot name="hand">{base}{limb("left", 0.1)}{limb("right", -0.1)}{control}</robot>'


def test_a_joint_with_a_mimic_parameter_follows_its_leader_and_has_no_drive(tmp_path: Path) -> None:
    text = gripper(("mimic", "left_joint"), ("multiplier", "-1"), ("offset", "0.2"))
    robot = imported(tmp_path, text, fixed_base=True)
    mimic = robot.robot.description.joints["right_joint"].mimic
    assert mimic is not None
    assert (mimic.leader, mimic.multiplier, mimic.offset) == ("left_joint", -1.0, 0.2)
    assert keys(robot)["joints"]["right_joint"] == {}
    assert "drive" in keys(robot)["joints"]["left_joint"]  # type: ignore[operator]
    assert not any("right_joint" in remark.text for remark in robot.draft.carried)


def test_the_description_with_the_law_is_written_beside_the_robot_file_and_the_user_s_stays(tmp_path: Path) -> None:
    text = gripper(("mimic", "left_joint"))
    robot = imported(tmp_path, text, fixed_base=True)
    assert str(keys(robot)["urdf"]) == "rover.imported.urdf"
    assert '<mimic joint="left_joint"/>' in robot.files[tmp_path / "rover.imported.urdf"]
    assert (tmp_path / "rover.urdf").read_text(encoding="utf-8") == text


@pytest.mark.parametrize("parameters", [(), (("mimic", "no_joint"),)])
def test_a_mimic_parameter_without_a_leader_changes_nothing(
    tmp_path: Path, parameters: tuple[tuple[str, str], ...]
) -> None:
    robot = imported(tmp_path, gripper(*parameters), fixed_base=True)
    assert str(keys(robot)["urdf"]) == "rover.urdf"
    assert "drive" in keys(robot)["joints"]["right_joint"]  # type: ignore[operator]
