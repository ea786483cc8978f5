"""Cases of ROS2PublishJointState and IsaacArticulationController."""

from __future__ import annotations

import math

import pytest

from graphengine.nodes.core.articulation import IsaacArticulationController
from graphengine.nodes.ros2.state import ROS2PublishJointState
from graphengine.testing import RecordingContext
from tests.nodes import scenes
from tests.nodes.harness import Player, ready
from tests.nodes.isaac.book import CASES, Case, made, runs

JOINT_STATE = "isaacsim.ros2.bridge.ROS2PublishJointState"
CONTROLLER = "isaacsim.core.nodes.IsaacArticulationController"


@runs(JOINT_STATE, "positions rad/m")
def positions_are_published_in_rad_and_m(case: Case, play: Player) -> None:
    given = case["inputs"]
    playing = play.scene(scenes.arm(given["joints"], stiffness=2000.0, damping=200.0, positionCommand=given["target"]))
    playing.tick(120)
    newest = playing.published("/joint_states")[-1]
    assert newest.name == given["joints"]
    assert newest.position.tolist() == pytest.approx(case["expect"]["position"], abs=case["tolerance"])


@runs(JOINT_STATE, "velocities rad/s, m/s")
def velocities_are_published_in_rad_s_and_m_s(case: Case, play: Player) -> None:
    given, joints = case["inputs"], CASES[f"{JOINT_STATE}: positions rad/m"]["inputs"]["joints"]
    playing = play.scene(scenes.arm(joints, given["stiffness"], given["damping"], velocityCommand=given["target"]))
    playing.tick(60)
    newest = playing.published("/joint_states")[-1]
    assert newest.velocity.tolist() == pytest.approx(case["expect"]["velocity"], abs=case["tolerance"])


@runs(JOINT_STATE, "unit scaling prismatic/effort")
def a_sliding_joint_is_scaled(case: Case, play: Player) -> None:
    slider = {"joint_names": ["slider"], "joint_velocities": [0.0]}
    message = made(ROS2PublishJointState, case, **slider).message()
    assert message.position.tolist() == pytest.approx(case["expect"]["position"], abs=case["tolerance"])
    assert message.effort.tolist() == pytest.approx(case["expect"]["effort"], abs=case["tolerance"])


@runs(CONTROLLER, "by name", "by index")
def the_selected_joints_go_where_they_are_told(case: Case, play: Player) -> None:
    joints = [f"panda_joint{number}" for number in range(1, 5)]
    playing = play.scene(scenes.arm(joints, stiffness=2000.0, damping=200.0, **case["inputs"])).tick(120)
    position = playing.published("/joint_states")[-1].position
    tolerance = case["tolerance"] if isinstance(case["tolerance"], float) else min(case["tolerance"].values())
    assert position[1] == pytest.approx(case["expect"]["q[1]"], abs=tolerance)
    assert position[2] == pytest.approx(case["expect"]["q[2]"], abs=tolerance)
    assert [position[0], position[3]] == pytest.approx([0.0, 0.0], abs=0.01)


@runs(CONTROLLER, "width mismatch rejects the whole command")
def a_wrong_width_applies_nothing(case: Case, play: Player) -> None:
    context = RecordingContext()
    robot = context.world.add_robot("/Robot", ["a", "b", "c"])
    node = made(IsaacArticulationController, case, target_prim="/Robot")
    node.setup(context)
    with pytest.raises(ValueError, match="has one number for each of 2 joints") as caught:
        node.compute()
    assert all(word in str(caught.value) for word in case["expect"]["one error mentioning"])
    assert all(math.isnan(target) for targets in robot.targets.values() for target in targets)


@runs(CONTROLLER, "NaN filtered")
def nan_is_skipped(case: Case, play: Player) -> None:
    context = RecordingContext()
    robot = context.world.add_robot("/Robot", ["a", "b", "c", "d"])
    command, indices = [float(value) for value in case["inputs"]["command"]], case["inputs"]["dof_indices"]
    ready(
        IsaacArticulationController, context, target_prim="/Robot", joint_indices=indices, effort_command=command
    ).compute()
    applied = {joint: value for joint, value in enumerate(robot.targets["effort"]) if not math.isnan(value)}
    assert applied == dict(zip(case["expect"]["indices"], case["expect"]["applied"], strict=True))
