"""Which graphs an imported robot gets for joints that no base drives: states, commands, and trajectories of arms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.bringup.robots.imported_arms import LIMIT, MIMIC, PLATE, arm, bolted, joint
from tests.bringup.robots.imported_bases import (
    DIFFERENTIAL,
    description,
    imported,
    robot_file,
)

FOLLOWS_2 = MIMIC.format("").replace("finger", "joint_2")


def graphs(folder: Path, text: str, controllers: str = "") -> dict[str, Any]:
    found = robot_file(imported(folder, text, controllers))["graphs"]
    assert isinstance(found, dict)
    return found


def joints(number: int, prefix: str = "") -> list[str]:
    return [f"{prefix}joint_{index}" for index in range(1, number + 1)]


def test_a_bolted_arm_gets_states_commands_and_trajectories_without_its_gripper(tmp_path: Path) -> None:
    assert graphs(tmp_path, bolted(arm(6, "plate", gripper=True))) == {
        "joint_states": {"use": "graphs/joint_states.yaml", "parameters": {"base": "world"}},
        "joint_commands": {"use": "graphs/joint_commands.yaml", "parameters": {"base": "world"}},
        "arm": {"use": "graphs/arm/trajectory.yaml", "parameters": {"base": "world", "joints": joints(6)}},
        "gripper": {"use": "graphs/arm/gripper.yaml", "parameters": {"base": "world", "joint": "finger"}},
    }


def test_legs_of_a_free_robot_get_states_and_commands(tmp_path: Path) -> None:
    legs = [arm(3, "plate", prefix) for prefix in ("fl_", "fr_", "rl_", "rr_")]
    assert [*graphs(tmp_path, f'<robot name="bot">{PLATE}{"".join(legs)}</robot>')] == [
        "joint_states",
        "joint_commands",
    ]


def test_an_arm_on_a_base_has_its_torso_and_leaves_the_states_to_the_base(tmp_path: Path) -> None:
    head = joint("pan", "torso") + joint("tilt", "pan")
    found = graphs(tmp_path, description(DIFFERENTIAL, joint("torso", "base_link"), arm(7, "torso"), head))
    assert [*found] == ["base", "joint_commands", "arm"]
    assert found["arm"]["parameters"]["joints"] == ["torso", *joints(7)]


def test_two_arms_have_a_controller_each_without_the_torso_that_they_share(tmp_path: Path) -> None:
    arms = arm(6, "torso", "left_", gripper=True), arm(6, "torso", "right_", gripper=True)
    found = graphs(tmp_path, bolted(joint("torso", "plate"), *arms))
    assert {name: found[name]["parameters"] for name in ("left", "right")} == {
        side: {"base": "world", "controller": f"{side}_controller", "joints": joints(6, f"{side}_")}
        for side in ("left", "right")
    }


def test_a_joint_without_a_drive_gets_no_graph(tmp_path: Path) -> None:
    file = robot_file(imported(tmp_path, bolted(joint("flap", "plate", "", "continuous"))))
    assert "graphs" not in file


@pytest.mark.parametrize(("number", "arms"), [(1, False), (2, True)])
def test_an_arm_has_two_joints_at_least(tmp_path: Path, number: int, arms: bool) -> None:
    assert ("arm" in graphs(tmp_path, bolted(arm(number, "plate")))) == arms


def test_rods_that_follow_an_arm_are_no_fingers(tmp_path: Path) -> None:
    """As in a palletizer: rods beside the upper arm, and a rod on the lower arm, follow the second joint."""
    rods = joint("rod", "plate", LIMIT + FOLLOWS_2), joint("link", "joint_1", LIMIT + FOLLOWS_2)
    found = graphs(tmp_path, bolted(arm(2, "plate", gripper=True), *rods))
    assert found["arm"]["parameters"]["joints"] == joints(2)
    assert [each["parameters"]["joint"] for name, each in found.items() if "gripper" in name] == ["finger"]


def test_two_fingers_with_two_joints_each_are_a_gripper(tmp_path: Path) -> None:
    fingers = [
        joint("proximal", "joint_3") + joint("distal", "proximal"),
        joint("other", "joint_3", LIMIT + FOLLOWS_2) + joint("other_distal", "other", LIMIT + FOLLOWS_2),
    ]
    found = graphs(tmp_path, bolted(arm(3, "plate"), *fingers))
    assert found["arm"]["parameters"]["joints"] == joints(3)


ARM = """controller_manager:
  ros__parameters:
    arm_controller: {type: joint_trajectory_controller/JointTrajectoryController}
    state: {type: joint_state_broadcaster/JointStateBroadcaster}
arm_controller:
  ros__parameters:
    joints: [joint_2, joint_1]
    command_interfaces: [position]
    allow_partial_joints_goal: true
    constraints:
      stopped_velocity_tolerance: 0.05
      goal_time: 1.5
      joint_1: {trajectory: 0.2, goal: 0.03}
"""


def test_a_trajectory_controller_gives_joints_and_tolerances(tmp_path: Path) -> None:
    assert graphs(tmp_path, bolted(arm(2, "plate")), ARM)["arm"]["parameters"] == {
        "base": "world",
        "controller": "arm_controller",
        "joints": ["joint_2", "joint_1"],
        "path_tolerances": [0.0, 0.2],
        "goal_tolerances": [0.0, 0.03],
        "goal_time": 1.5,
        "stopped_velocity": 0.05,
        "partial": True,
    }


def test_legs_with_a_trajectory_controller_follow_trajectories(tmp_path: Path) -> None:
    text = f'<robot name="bot">{PLATE}{arm(2, "plate")}</robot>'
    assert graphs(tmp_path, text, ARM)["arm"]["parameters"]["joints"] == ["joint_2", "joint_1"]


@pytest.mark.parametrize(
    ("package", "more"),
    [("position_controllers", {}), ("parallel_gripper_action_controller", {"action_type": "ParallelGripperCommand"})],
)
def test_a_gripper_controller_gives_joint_and_tolerance(tmp_path: Path, package: str, more: dict[str, str]) -> None:
    hand = f"""hand_controller:
  ros__parameters:
    type: {package}/GripperActionController
    joint: finger
    goal_tolerance: 0.02
    allow_stalling: true
"""
    found = graphs(tmp_path, bolted(arm(2, "plate", gripper=True)), ARM + hand)
    assert found["gripper"]["parameters"] == {
        "base": "world",
        "joint": "finger",
        "controller": "hand_controller",
        "goal_tolerance": 0.02,
        **more,
        "allow_stalling": True,
    }


def test_each_of_two_grippers_has_a_controller(tmp_path: Path) -> None:
    arms = arm(4, "plate", "left_", gripper=True), arm(4, "plate", "right_", gripper=True)
    found = graphs(tmp_path, bolted(*arms))
    assert {name: each["parameters"]["joint"] for name, each in found.items() if "gripper" in name} == {
        "gripper_1": "left_finger",
        "gripper_2": "right_finger",
    }


def test_a_grippers_drive_may_press_beyond_its_limits_with_its_full_effort(tmp_path: Path) -> None:
    found = imported(tmp_path, bolted(arm(2, "plate", gripper=True)))
    drives = {name: entry["drive"] for name, entry in robot_file(found)["joints"].items() if "drive" in entry}
    assert {name: drive["overtravel"] for name, drive in drives.items() if "overtravel" in drive} == {"finger": 0.01}
    assert drives["finger"]["overtravel"] * drives["finger"]["stiffness"] == 20  # N m, the limit of effort
    told = [remark.text for remark in found.draft.guessed if remark.text.startswith("gripper: ")]
    assert told[0].endswith("; targets up to 0.01 rad beyond its limits press")


def test_fingers_that_do_not_mimic_each_other_get_no_gripper(tmp_path: Path) -> None:
    fingers = joint("left", "joint_3"), joint("right", "joint_3")
    found = graphs(tmp_path, bolted(arm(3, "plate"), *fingers))
    assert [*found] == ["joint_states", "joint_commands", "arm"]


@pytest.mark.parametrize("interface", ["position", "velocity", "effort"])
def test_a_trajectory_controller_becomes_position_drives_by_whichever_command(tmp_path: Path, interface: str) -> None:
    controllers = ARM.replace("[position]", f"[{interface}]")
    drives = robot_file(imported(tmp_path, bolted(arm(2, "plate")), controllers))["joints"]
    assert all(drives[name]["drive"]["stiffness"] > 0 for name in joints(2))


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ("joints: [joint_2, joint_3]", "the description has no joint 'joint_3'; did you mean 'joint_1' or 'joint_2'?"),
        ("joints: [joint_1, other_finger]", "joint 'other_finger' has no drive that takes positions"),
        ("joints: []", "it names no joints"),
    ],
)
def test_a_controller_that_cannot_move_its_joints_is_reported_and_left_out(
    tmp_path: Path, wrong: str, reason: str
) -> None:
    text = bolted(arm(2, "plate", gripper=True))
    found = imported(tmp_path, text, ARM.replace("joints: [joint_2, joint_1]", wrong))
    lost = [remark.text for remark in found.draft.lost]
    assert f"JointTrajectoryController arm_controller: {reason}" in lost
