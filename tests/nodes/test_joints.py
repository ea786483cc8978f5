"""IsaacArticulationController and ROS2PublishJointState."""

from __future__ import annotations

import itertools
import math
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from graphengine.devices.dry_world import ArticulationStub
from graphengine.format.errors import JointError, NodeError, PrimError
from graphengine.nodes.core.articulation import IsaacArticulationController, IsaacArticulationState, SelectedJointsNode
from graphengine.nodes.ros2.state import ROS2PublishJointState
from graphengine.scene import build
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, computed, dd100, ready

NAN = math.nan
JOINTS = ("shoulder", "elbow", "wrist", "finger")
KINDS = ("position", "velocity", "effort")


def arm(context: RecordingContext) -> ArticulationStub:
    """Three joints that turn, and one that slides."""
    return context.world.add_robot("/arm", JOINTS, prismatic=(False, False, False, True))


def same(one: Any, other: Any) -> bool:
    """Equal, NaN included."""
    return np.array_equal(one, other, equal_nan=True)


def controlled(**inputs: Any) -> ArticulationStub:
    """The arm after one compute."""
    context = RecordingContext()
    robot = arm(context)
    ready(IsaacArticulationController, context, **{"target_prim": "/arm", **inputs}).compute()
    return robot


def test_a_command_to_a_joint_that_mimics_another_one_is_logged(context: RecordingContext) -> None:
    context.world.add_robot("/hand", ["left", "right"], leaders=("", "left"))
    ready(IsaacArticulationController, context, target_prim="/hand", joint_names=["left"])
    ready(IsaacArticulationController, context, target_prim="/hand")  # all joints; the follower is none of its own
    assert context.logged == []
    ready(IsaacArticulationController, context, target_prim="/hand", joint_names=["left", "right"])
    assert context.logged == [("warning", "joint right of /hand follows left: command left instead")]


# Which joints IsaacArticulationController and IsaacArticulationState select

every_selection = pytest.mark.parametrize("cls", [IsaacArticulationController, IsaacArticulationState])


@every_selection
@pytest.mark.parametrize(
    ("inputs", "selected"),
    [
        pytest.param({}, JOINTS, id="all"),
        pytest.param({"joint_names": ["wrist", "shoulder"]}, ("wrist", "shoulder"), id="by name, in the names' order"),
        pytest.param({"joint_indices": [2, 1]}, ("wrist", "elbow"), id="by index where no names are given"),
        pytest.param({"joint_names": ["elbow"], "joint_indices": [3]}, ("elbow",), id="by name where both are given"),
        pytest.param({"joint_indices": [0]}, ("shoulder",), id="by index 0, which the reference takes for none"),
        pytest.param({"joint_indices": [0, 1]}, ("shoulder", "elbow"), id="by index 0 and others"),
    ],
)
def test_joints_are_selected_by_name_or_index(
    cls: type[SelectedJointsNode], inputs: dict[str, Any], selected: tuple[str, ...], context: RecordingContext
) -> None:
    arm(context)
    node = computed(cls, context, target_prim="/arm", **inputs)
    assert node.joints().names == selected


@every_selection
def test_the_selection_may_change_in_every_tick(cls: type[SelectedJointsNode], context: RecordingContext) -> None:
    arm(context)
    node = ready(cls, context, target_prim="/arm", joint_names=["elbow"])
    found: list[str] = []
    for names, indices in [(("elbow",), []), (("finger",), []), ((), [0]), ((), [2])]:
        node.joint_names, node.joint_indices = names, np.array(indices, np.int32)
        node.compute()
        assert node.selection is not None
        found += node.selection.names
    assert found == ["elbow", "finger", "shoulder", "wrist"]


@every_selection
@pytest.mark.parametrize("selection", [{"joint_names": ["elbo"]}, {"joint_indices": [4]}, {"joint_indices": [-1]}])
def test_an_unknown_joint_is_refused_in_setup(
    cls: type[SelectedJointsNode], selection: dict[str, Any], context: RecordingContext
) -> None:
    arm(context)
    with pytest.raises(JointError, match="no joint") as caught:
        ready(cls, context, target_prim="/arm", **selection)
    assert any("elbow" in line or "0 to 3" in line for line in caught.value.help)


@pytest.mark.parametrize("node", ["ArticulationController", "ArticulationState", "JointNameResolver"])
def test_in_a_graph_a_wired_path_without_a_robot_ends_the_branch_and_not_the_run(node: str, play: Player) -> None:
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Turn: FlipFlop
          Robot: {{type: SelectTargetIf, inputs: {{ifFalse: [/dd100]}}}}
          Node: {node}
        connections:
          - Tick.tick -> Turn.execIn
          - Turn.a -> Node.execIn
          - Turn.b -> Node.execIn
          - Turn.isA -> Robot.condition
          - Robot.result -> Node.targetPrim
        """,
        dd100(),
    ).tick(4)
    assert playing.dropped == {"/World/graph/Node": 2}


# IsaacArticulationController


def test_without_commands_no_target_changes() -> None:
    robot = controlled()
    assert all(same(targets, [NAN] * 4) for targets in robot.targets.values())


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_command_reaches_its_own_targets(kind: str) -> None:
    robot = controlled(**{f"{kind}_command": [1.0, 2.0, 3.0, 4.0]})
    for other in KINDS:
        assert same(robot.targets[other], [1.0, 2.0, 3.0, 4.0] if other == kind else [NAN] * 4)


def test_the_selected_joints_are_commanded_and_no_others() -> None:
    robot = controlled(joint_names=["wrist", "shoulder"], velocity_command=[3.0, 1.0])
    assert same(robot.targets["velocity"], [1.0, NAN, 3.0, NAN])


def test_nan_keeps_the_target_of_a_joint() -> None:
    robot = controlled(joint_indices=[1, 2, 3], position_command=[0.1, NAN, 0.3])
    assert same(robot.targets["position"], [NAN, 0.1, NAN, 0.3])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("width", [1, 3, 5])
def test_a_command_of_the_wrong_length_is_an_error_and_no_target_changes(kind: str, width: int) -> None:
    context = RecordingContext()
    robot = arm(context)
    commands = {f"{other}_command": [1.0] * (width if other == kind else 4) for other in KINDS}
    node = ready(IsaacArticulationController, context, target_prim="/arm", **commands)
    with pytest.raises(ValueError, match=f"{kind}Command, .* has one number for each of 4 joints"):
        node.compute()
    assert all(same(targets, [NAN] * 4) for targets in robot.targets.values())


def test_robot_path_overrides_target_prim(context: RecordingContext) -> None:
    robot, other = arm(context), context.world.add_robot("/other", JOINTS)
    computed(IsaacArticulationController, context, target_prim="/other", robot_path="/arm", effort_command=[1.0] * 4)
    assert robot.targets["effort"] == [1.0] * 4
    assert same(other.targets["effort"], [NAN] * 4)


def test_after_a_stop_the_same_joints_are_commanded_again(context: RecordingContext) -> None:
    robot = arm(context)
    node = ready(IsaacArticulationController, context, target_prim="/arm", joint_names=["elbow"], effort_command=[1.0])
    for _ in range(2):
        node.compute()
        assert same(robot.targets["effort"], [NAN, 1.0, NAN, NAN])
        robot.targets["effort"] = [NAN] * 4
        context.stop(node)


def test_the_error_of_a_prim_that_is_not_a_robot_names_the_robot(context: RecordingContext) -> None:
    arm(context)
    context.world.stage.add("/arm/Geometry/base_link/hand", "link")
    with pytest.raises(PrimError, match="is not the root prim, base link or articulation root of a robot") as caught:
        ready(IsaacArticulationController, context, target_prim="/arm/base_link/hand")
    assert "/arm/Geometry/base_link" in "".join(caught.value.help)
    assert "or make this link the articulation_root in the robot file" in caught.value.help


def test_in_a_graph_a_command_of_the_wrong_length_stops_the_run_and_names_the_node(play: Player) -> None:
    world = RecordingWorld()
    world.add_robot("/arm", JOINTS)
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Controller: {type: ArticulationController, inputs: {targetPrim: /arm, effortCommand: [1.0, 2.0]}}
        connections: [Tick.tick -> Controller.execIn]
        """,
        world,
    )
    with pytest.raises(NodeError, match=r"node Controller .*effortCommand, .* has one number for each of 4 joints"):
        playing.tick()


def test_controllers_of_the_same_joints_in_two_graphs_give_a_warning_with_both_positions(tmp_path: Path) -> None:
    node = "{type: ArticulationController, inputs: {targetPrim: /dd100, velocityCommand: [1.0, 1.0]}}"
    wires = "[Tick.tick -> One.execIn, Tick.tick -> Two.execIn]"
    (tmp_path / "twice.yaml").write_text(
        f"graph: twice\nnodes:\n  Tick: OnPlaybackTick\n  One: {node}\n  Two: {node}\nconnections: {wires}\n"
    )
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "scene: a\nworld: worlds/flat_grid.xml\nrobots: {dd100: {use: robots/dd100.yaml}}\ngraphs: {twice: {use: twice.yaml}}\n"
    )
    assembly = build.load(scene)
    told = [found.message.partition(" command ")[0] for found in assembly.findings.items if found.code == "W207"]
    assert told == ["dd100/cmd_vel/ArtController and twice/One"]


# ROS2PublishJointState, of a robot


def stated(**inputs: Any) -> Any:
    """The message about the arm in the state of the test."""
    context = RecordingContext()
    robot = arm(context)
    robot.state = {"position": (0.1, 0.2, 0.3, 0.4), "velocity": (1.1, 1.2, 1.3, 1.4), "effort": (2.1, 2.2, 2.3, 2.4)}
    return ready(ROS2PublishJointState, context, **{"target_prim": "/arm", **inputs}).message()


def test_all_joints_are_published_in_the_articulations_order_under_an_empty_frame() -> None:
    message = stated(time_stamp=3.25)
    assert message.name == list(JOINTS)
    assert message.position.tolist() == [0.1, 0.2, 0.3, 0.4]
    assert message.velocity.tolist() == [1.1, 1.2, 1.3, 1.4]
    assert message.effort.tolist() == [2.1, 2.2, 2.3, 2.4]
    assert (message.header.frame_id, message.header.stamp.sec, message.header.stamp.nanosec) == ("", 3, 250_000_000)


def test_the_published_state_is_the_state_at_the_execution(context: RecordingContext) -> None:
    robot = arm(context)
    node = ready(ROS2PublishJointState, context, target_prim="/arm")
    for angle in (0.5, 0.75):
        robot.state["position"] = [angle] * 4
        node.compute()
    assert [m.position[0] for m in context.transport.messages("/joint_states")] == [0.5, 0.75]


def test_a_name_override_of_a_joint_is_its_name(context: RecordingContext) -> None:
    arm(context)
    context.world.stage.add("/arm/Physics/elbow", "joint", name_override="left_elbow")
    message = ready(ROS2PublishJointState, context, target_prim="/arm").message()
    assert message.name == ["shoulder", "left_elbow", "wrist", "finger"]


@given(st.lists(st.decimals(-10000, 10000, places=7), min_size=4, max_size=4))
def test_numbers_are_rounded_to_four_decimals(numbers: list[Decimal]) -> None:
    context = RecordingContext()
    arm(context).state["position"] = [float(number) for number in numbers]
    found = ready(ROS2PublishJointState, context, target_prim="/arm").message().position
    for number, rounded in zip(numbers, found.tolist(), strict=True):
        assert rounded == float(f"{rounded:.4f}")  # the double nearest to four decimals
        assert abs(Decimal(repr(rounded)) - number) <= Decimal("0.00005")


@given(st.lists(st.floats(), min_size=4, max_size=4), st.floats(1e-12, 1e300))
@example([0.12345, math.nan, -math.inf, 1e308], 1e-4)
@example([1e299, 0.0, 0.0, 0.0], 1e-10)
def test_the_rounding_of_a_number_does_not_depend_on_the_other_numbers(numbers: list[float], resolution: float) -> None:
    context = RecordingContext()
    robot = arm(context)
    node = ready(ROS2PublishJointState, context, target_prim="/arm", resolution=resolution)

    def rounded(positions: list[float]) -> list[float]:
        robot.state["position"] = positions
        found: list[float] = node.message().position.tolist()
        return found

    assert list(map(repr, rounded(numbers))) == [repr(rounded([number] * 4)[0]) for number in numbers]


@pytest.mark.parametrize("number", [math.inf, -math.inf, 1e308, -1e308])
def test_numbers_too_large_to_be_rounded_stay(context: RecordingContext, number: float) -> None:
    arm(context).state["position"] = [0.12345, number, math.nan, -0.12345]
    found = ready(ROS2PublishJointState, context, target_prim="/arm").message().position.tolist()
    assert repr(found) == repr([0.1234, number, math.nan, -0.1234])


def test_with_a_resolution_of_0_numbers_are_not_rounded(context: RecordingContext) -> None:
    arm(context).state["position"] = [math.pi] * 4
    found = ready(ROS2PublishJointState, context, target_prim="/arm", resolution=0.0).message().position
    assert found.tolist() == [math.pi] * 4


# ROS2PublishJointState, of arrays

ARRAYS: dict[str, Any] = {
    "joint_names": ["turning", "sliding"],
    "joint_positions": [1.0, 2.0],
    "joint_velocities": [3.0, 4.0],
    "joint_efforts": [5.0, 6.0],
    "joint_dof_types": [0, 1],
    "stage_meters_per_unit": 1.0,
}


def of_arrays(**inputs: Any) -> Any:
    """The message about the arrays."""
    return ready(ROS2PublishJointState, RecordingContext(), **{**ARRAYS, **inputs}).message()


def test_arrays_take_precedence_over_a_robot() -> None:
    assert stated(**ARRAYS).name == ["turning", "sliding"]


@pytest.mark.parametrize("metres", [1.0, 0.5, 0.01])
def test_lengths_are_scaled_by_the_unit_and_torques_by_its_square(metres: float) -> None:
    message, k = of_arrays(stage_meters_per_unit=metres), 1.0 / metres
    assert np.allclose(message.position, [1.0, 2.0 * k])
    assert np.allclose(message.velocity, [3.0, 4.0 * k])
    assert np.allclose(message.effort, [5.0 * k * k, 6.0 * k])


@pytest.mark.parametrize("metres", [0.0, -1.0, math.inf])
def test_a_stage_unit_that_is_not_above_0_is_an_error(metres: float) -> None:
    with pytest.raises(ValueError, match="stageMetersPerUnit must be above 0"):
        of_arrays(stage_meters_per_unit=metres)


@pytest.mark.parametrize("array", ["joint_positions", "joint_velocities", "joint_efforts", "joint_dof_types"])
def test_arrays_of_different_lengths_are_an_error(array: str) -> None:
    with pytest.raises(ValueError, match=r"jointNames, .* must be of the same length"):
        of_arrays(**{array: ARRAYS[array][:1]})


@pytest.mark.parametrize(("sensor_time", "expected"), [(0.0, 1), (-1.0, 1), (2.0, 2)])
def test_the_sensors_time_is_the_stamp_when_it_is_above_0(sensor_time: float, expected: int) -> None:
    assert of_arrays(sensor_time=sensor_time, time_stamp=1.0).header.stamp.sec == expected


def test_arrays_without_joint_names_are_an_error() -> None:
    node = ready(ROS2PublishJointState, RecordingContext(), **ARRAYS)
    node.joint_names = ()
    with pytest.raises(ValueError, match="jointNames must be the names of the joints, unless targetPrim is given"):
        node.compute()


def test_in_the_tutorials_graph_joint_states_are_published_in_every_tick_with_simulation_time(play: Player) -> None:
    playing = play.shipped("tutorial/joint_states", dd100()).tick(3)
    sent = playing.published("/dd100_0000/platform/joint_states")
    assert [m.header.stamp.nanosec for m in sent] == [int(tick / 60 * 1e9) for tick in (1, 2, 3)]
    assert set(itertools.chain(*(m.name for m in sent))) == {"front_left_wheel_joint", "front_right_wheel_joint"}
