"""ROS2FollowJointTrajectory: goals from their arrival to their result, over topics in memory, with joints that a test moves."""

from __future__ import annotations

import math
import uuid
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.errors import ContextError
from graphengine.messages import goals, messages
from graphengine.nodes.ros2 import joint_trajectory as codes
from graphengine.nodes.ros2.follow_joint_trajectory import ROS2FollowJointTrajectory
from graphengine.scene import build
from graphengine.testing import RecordingContext, check_node
from tests.action_peer import ActionPeer
from tests.bringup.robots.harness import INERTIA
from tests.nodes.harness import ready, write
from tests.trajectories import FOLLOW, point, tolerance, trajectory

NAMES = ["lift", "elbow"]
TO, REST = (0.4, -0.2), (0.0, 0.0)


class Arm:
    """A robot whose joints are where they are told at the end of each tick, unless a test blocks them; and a client."""

    def __init__(self, **inputs: Any) -> None:
        self.context = RecordingContext()
        facts = {"ranges": ((-1.0, 1.0),) * 3, "leaders": ("", "", "elbow"), "max_velocities": (1.0, 1.0, math.inf)}
        self.robot = self.context.world.add_robot("/arm", [*NAMES, "finger"], **facts)
        self.blocked = False
        self.node = ready(ROS2FollowJointTrajectory, self.context, target_prim="/arm", joint_names=NAMES, **inputs)
        self.peer = ActionPeer(self.context.transport, "/joint_trajectory_controller/follow_joint_trajectory", FOLLOW)
        self.commands: list[list[float] | None] = []
        self.tick()

    def tick(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            self.context.transport.messages("/unused")  # deliver what was sent
            self.context.tick()
            fired = self.node.compute()
            command = self.node.position_command.tolist() if fired else None
            self.commands.append(command)
            if command and not self.blocked:
                speeds = [*self.node.velocity_command, 0.0]
                self.robot.state = {**self.robot.state, "position": [*command, 0.0], "velocity": speeds}
                self.robot.targets["position"] = [*command, 0.0]
        self.context.transport.messages("/unused")

    def run(self, seconds: float) -> None:
        self.tick(round(seconds * 60))

    def send(self, message: Any, **fields: Any) -> uuid.UUID:
        goal = uuid.UUID(int=len(self.peer.accepted) + 1)
        self.peer.send(goal, trajectory=message, **fields)
        self.tick()
        self.peer.ask_result(goal)
        self.tick()
        return goal

    def publish(self, message: Any) -> None:
        self.context.transport.inject("/joint_trajectory_controller/joint_trajectory", message)

    @property
    def results(self) -> list[tuple[int, int]]:
        """Status and error code of each result."""
        return [(response.status, response.result.error_code) for response in self.peer.results]

    @property
    def reason(self) -> str:
        return str(self.peer.results[-1].result.error_string)


def way(time: float = 1.0, to: tuple[float, ...] = TO) -> Any:
    return trajectory(NAMES, point(time, to, REST))


def test_a_goal_moves_the_joints_and_succeeds_at_its_end() -> None:
    arm = Arm()
    arm.send(way())
    arm.run(0.9)
    assert (arm.peer.accepted, arm.results) == ([True], [])
    assert 0.35 < arm.commands[-1][0] < 0.4  # type: ignore[index]
    arm.run(0.2)
    assert arm.results == [(goals.SUCCEEDED, codes.SUCCESSFUL)]
    assert arm.commands[-1] is None  # others may command the joints now
    assert [c for c in arm.commands if c][-1] == pytest.approx(TO)


def test_commands_are_the_set_points_at_the_end_of_the_execution() -> None:
    arm = Arm()
    arm.send(trajectory(NAMES, point(1.0, TO)))  # linear
    assert [command[0] for command in arm.commands if command] == pytest.approx([0.4 / 60, 0.8 / 60])
    assert arm.node.velocity_command == pytest.approx(TO)
    assert arm.node.joint_names_out == tuple(NAMES)


def test_a_trajectory_begins_at_the_targets_of_the_drives() -> None:
    arm = Arm()
    arm.robot.targets["position"] = [0.5, 0.1, 0.0]  # where the joints, which are at 0, are on their way to
    arm.send(trajectory(NAMES, point(1.0, (0.5, 0.1))))
    assert arm.commands[-1] == pytest.approx([0.5, 0.1])


def test_feedback_has_the_desired_and_the_actual_state_and_their_difference() -> None:
    arm = Arm(feedback_rate=10.0)
    arm.blocked = True
    arm.send(trajectory(NAMES, point(1.0, TO)))
    arm.run(1.0)
    times = [messages.seconds(sent.feedback.header.stamp) for sent in arm.peer.feedback]
    assert np.diff(times) == pytest.approx([0.1] * (len(times) - 1), abs=1e-6)
    sent = arm.peer.feedback[5].feedback
    assert sent.joint_names == NAMES
    assert messages.seconds(sent.desired.time_from_start) == pytest.approx(0.5)
    assert sent.desired.positions == pytest.approx([0.2, -0.1])
    assert sent.actual.positions.tolist() == [0.0, 0.0]
    assert sent.error.positions == pytest.approx([0.2, -0.1])
    assert sent.error.velocities == pytest.approx(TO)


def test_an_error_beyond_the_path_tolerance_aborts_and_the_joints_hold_their_positions() -> None:
    arm = Arm(path_tolerances=np.array([0.1]))
    arm.blocked = True
    arm.send(trajectory(NAMES, point(1.0, TO)))
    arm.run(1.0)
    assert arm.results == [(goals.ABORTED, codes.PATH_TOLERANCE_VIOLATED)]
    assert arm.reason == "joint lift: position error 0.1067 rad, tolerance 0.1 rad"
    assert [c for c in arm.commands if c][-1] == [0.0, 0.0]
    assert arm.commands[-1] is None


def test_a_goal_waits_for_the_joints_until_its_time_tolerance_has_passed() -> None:
    arm = Arm(goal_time=0.5, goal_tolerances=np.array([0.01]))
    arm.blocked = True
    arm.send(way())
    arm.run(1.4)
    assert arm.results == []
    arm.run(0.2)
    assert arm.results == [(goals.ABORTED, codes.GOAL_TOLERANCE_VIOLATED)]
    assert arm.reason.startswith("joint lift: position error 0.4 rad, tolerance 0.01 rad, 0.51")


def test_without_a_time_tolerance_a_goal_waits_for_the_joints_without_limit() -> None:
    arm = Arm(goal_tolerances=np.array([0.01]))
    arm.blocked = True
    arm.send(way())
    arm.run(5.0)
    assert arm.results == []
    arm.blocked = False
    arm.tick(2)
    assert arm.results == [(goals.SUCCEEDED, codes.SUCCESSFUL)]


def test_tolerances_of_a_goal_replace_the_defaults() -> None:
    arm = Arm(path_tolerances=np.array([0.01]))
    arm.blocked = True
    arm.send(trajectory(NAMES, point(1.0, TO)), path_tolerance=[tolerance("lift", -1.0), tolerance("elbow", 0.152)])
    arm.run(1.0)
    assert arm.reason == "joint elbow: position error 0.1533 rad, tolerance 0.152 rad"


def test_a_cancelled_goal_holds_the_measured_positions() -> None:
    arm = Arm()
    goal = arm.send(way())
    arm.run(0.3)
    arm.robot.state = {**arm.robot.state, "position": [0.07, -0.03, 0.0]}
    arm.peer.cancel(goal)
    arm.tick()
    assert arm.results == [(goals.CANCELED, codes.SUCCESSFUL)]
    assert (arm.commands[-1], arm.node.velocity_command.tolist()) == ([0.07, -0.03], [0.0, 0.0])
    arm.tick()
    assert arm.commands[-1] is None


def test_a_new_goal_aborts_the_previous_one_and_the_set_points_stay_smooth() -> None:
    arm = Arm()
    arm.send(way(1.0, (0.8, 0.0)))
    arm.run(0.5)
    arm.send(way(1.0, (0.0, 0.8)))
    arm.run(1.1)
    assert arm.results == [(goals.ABORTED, codes.INVALID_GOAL), (goals.SUCCEEDED, codes.SUCCESSFUL)]
    path = np.array([command for command in arm.commands if command])
    assert np.abs(np.diff(path, axis=0)).max() < 1.5 * 0.8 / 60  # of a cubic from rest to rest
    assert np.abs(np.diff(path, 2, axis=0)).max() < 10.0 / 60**2
    assert path[-1] == pytest.approx([0.0, 0.8])


def test_an_invalid_goal_gets_its_error_code_and_the_current_goal_continues() -> None:
    arm = Arm()
    arm.send(way())
    arm.send(trajectory(["lift", "elbw"], point(1.0, TO)))
    assert arm.results == [(goals.ABORTED, codes.INVALID_JOINTS)]
    assert "did you mean 'elbow'" in arm.reason
    arm.run(1.0)
    assert arm.results[1:] == [(goals.SUCCEEDED, codes.SUCCESSFUL)]
    assert any("'elbw' is not a joint" in text for _, text in arm.context.logged)


def test_joints_with_several_degrees_of_freedom_are_not_supported() -> None:
    arm, multi = Arm(), messages.message_class("trajectory_msgs/msg/MultiDOFJointTrajectory")
    arm.send(way(), multi_dof_trajectory=multi(way().header, ["base"], []))
    assert arm.results == [(goals.ABORTED, codes.INVALID_GOAL)]


def test_a_trajectory_on_the_topic_is_followed_and_preempts_a_goal() -> None:
    arm = Arm()
    arm.send(way())
    arm.publish(way(0.5, (-0.1, 0.1)))
    arm.run(0.6)
    assert arm.results == [(goals.ABORTED, codes.INVALID_GOAL)]
    assert arm.reason == "preempted by a trajectory from the topic"
    assert [c for c in arm.commands if c][-1] == pytest.approx([-0.1, 0.1])


def test_a_wrong_trajectory_on_the_topic_is_logged_and_nothing_moves() -> None:
    arm = Arm()
    arm.publish(trajectory(NAMES, point(1.0, (2.0, 0.0))))
    arm.tick(2)
    assert arm.commands == [None] * 3
    assert "joint lift cannot be at 2 rad in point 0, legal: -1 to 1" in arm.context.logged[-1][1]


@pytest.mark.parametrize("by_topic", [False, True])
def test_a_trajectory_without_points_stops_the_joints(by_topic: bool) -> None:
    arm = Arm()
    arm.send(way())
    arm.run(0.5)
    present = [*arm.robot.positions()[:2]]
    if by_topic:
        arm.publish(trajectory([]))
        arm.tick()
    else:
        arm.send(trajectory([]))
    assert [c for c in arm.commands if c][-1] == present
    assert arm.results[0] == (goals.ABORTED, codes.INVALID_GOAL)
    assert by_topic or arm.results[1] == (goals.SUCCEEDED, codes.SUCCESSFUL)


def test_partial_goals_are_refused_unless_they_are_allowed() -> None:
    only = trajectory(["elbow"], point(0.5, (0.3,)))
    strict, lenient = Arm(), Arm(allow_partial_joints_goal=True)
    strict.send(only)
    assert strict.results == [(goals.ABORTED, codes.INVALID_JOINTS)]
    lenient.send(only)
    lenient.run(0.6)
    assert lenient.results == [(goals.SUCCEEDED, codes.SUCCESSFUL)]
    assert [c for c in lenient.commands if c][-1] == pytest.approx([0.0, 0.3])


def test_a_trajectory_that_is_too_fast_is_followed_with_a_warning() -> None:
    arm = Arm()
    arm.send(trajectory(NAMES, point(0.25, TO)))
    assert arm.commands[-1] is not None
    assert arm.context.logged[-1][1].endswith("joint lift moves at 1.6 rad/s, its limit is 1 rad/s")


def test_after_a_stop_no_trajectory_is_followed() -> None:
    arm = Arm()
    arm.send(way())
    arm.context.stop(arm.node)
    arm.tick(3)
    assert arm.commands[-3:] == [None] * 3
    assert arm.results == [(goals.ABORTED, 0)]


@pytest.mark.parametrize("by_topic", [False, True])
def test_joints_stop_when_the_node_gets_other_joints(by_topic: bool) -> None:
    arm = Arm()
    if by_topic:
        arm.publish(way())
        arm.tick(2)
    else:
        arm.send(way())
    arm.context.close()
    arm.node.joint_names = ("elbow",)
    arm.node.setup(arm.context)
    present = arm.robot.positions()[1]
    arm.tick(2)
    assert arm.commands[-2:] == [[present], None]
    assert by_topic or [status for status, _ in arm.results] == [goals.ABORTED]


def test_without_names_all_driven_joints_that_are_not_mimic_joints_are_commanded() -> None:
    context = RecordingContext()
    context.world.add_robot("/arm", [*NAMES, "finger"], leaders=("", "", "elbow"))
    node = ready(ROS2FollowJointTrajectory, context, target_prim="/arm")
    assert node.commanded == tuple(NAMES)


def test_messages_have_published_joint_names_and_commands_the_names_of_the_description() -> None:
    context = RecordingContext()
    context.world.add_robot("/arm", NAMES)
    context.world.stage.add("/arm/Physics/lift", "joint", name_override="shoulder", facts={"joint": "lift"})
    node = ready(ROS2FollowJointTrajectory, context, target_prim="/arm")
    assert (node.joints.names, node.commanded) == (("shoulder", "elbow"), ("lift", "elbow"))


def test_the_namespace_of_a_robot_is_also_the_namespace_of_its_controller() -> None:
    context = RecordingContext("/arm/base_link/graph/node")
    context.world.add_robot("/arm", NAMES)
    context.world.stage.add("/arm/base_link", "link", namespace="left")
    node = ready(ROS2FollowJointTrajectory, context, target_prim="/arm")
    assert node.server.action == "/left/joint_trajectory_controller/follow_joint_trajectory"
    assert node.subscription.topic == "/left/joint_trajectory_controller/joint_trajectory"


@pytest.mark.parametrize(
    ("inputs", "reason"),
    [
        ({"joint_names": ["elbw"]}, "no joint 'elbw'"),
        ({"joint_names": ["finger"]}, "joint 'finger' follows 'elbow'"),
        (
            {"path_tolerances": np.array([0.1, 0.2, 0.3])},
            "pathTolerances must be one number for all joints or 2 numbers",
        ),
        ({"goal_tolerances": np.array([-0.1])}, "goalTolerances must be one number"),
    ],
)
def test_a_mistake_in_the_inputs_is_reported_before_the_run(inputs: dict[str, Any], reason: str) -> None:
    context = RecordingContext()
    context.world.add_robot("/arm", [*NAMES, "finger"], leaders=("", "", "elbow"))
    with pytest.raises(ContextError, match=reason):
        ready(ROS2FollowJointTrajectory, context, target_prim="/arm", **{"joint_names": NAMES, **inputs})


DRIVEN = "{stiffness: 100, damping: 10}"


@pytest.mark.parametrize(
    ("joints", "drive", "idle"),
    [("[]", DRIVEN, []), ("[]", "{damping: 10}", ["W209"]), ("[elbow, slide]", DRIVEN, ["W209"])],
)
def test_joints_without_a_position_drive_are_found_by_the_check(
    tmp_path: Path, joints: str, drive: str, idle: list[str]
) -> None:
    links = "".join(
        f'<link name="{n}"><inertial><mass value="1"/>{INERTIA}</inertial></link>' for n in ("base_link", "a", "b")
    )
    between = [("elbow", "base_link", "a"), ("slide", "a", "b")]
    hinges = "".join(
        f'<joint name="{name}" type="continuous"><parent link="{above}"/><child link="{below}"/></joint>'
        for name, above, below in between
    )
    files = {
        "arm.urdf": f'<robot name="arm">{links}{hinges}</robot>',
        "arm.yaml": f"""
            format: 1
            robot: arm
            urdf: arm.urdf
            fixed_base: true
            joints: {{elbow: {{drive: {drive}}}}}
            graphs: {{trajectory: {{use: graphs/arm/trajectory.yaml, parameters: {{joints: {joints}}}}}}}
        """,
        "scene.yaml": "format: 1\nscene: arm\nworld: worlds/flat_grid.xml\nrobots: {arm: {use: arm.yaml}}\n",
    }
    write(tmp_path, files)
    findings = build.load(tmp_path / "scene.yaml").findings
    assert [found.code for found in findings.warnings if "Trajectory commands" in found.message] == idle
    assert findings.errors == []


def test_check_node_accepts_the_trajectory_controller() -> None:
    def make() -> RecordingContext:
        context = RecordingContext()
        context.world.add_robot("/arm", NAMES)
        return context

    check_node(ROS2FollowJointTrajectory, make, target_prim="/arm")


WILD = st.one_of(st.floats(-3.0, 3.0), st.sampled_from((math.nan, math.inf, -1e300, 1e6, 5e-324)))
TIMES = st.one_of(st.floats(0.0, 1.0), st.floats(-(2.0**31), 2.0**31 - 1.0), st.sampled_from((1e-9, 2e-9, 0.0)))


@st.composite
def wild_trajectories(draw: st.DrawFn) -> Any:
    """Trajectories that are wrong in some way, or nearly right."""
    joints = draw(st.lists(st.sampled_from((*NAMES, "finger", "x" * 3000, "\0")), max_size=3)) or NAMES
    sizes = st.sampled_from((0, len(joints), len(joints), 1))
    points = [
        point(
            draw(TIMES), *(draw(st.lists(WILD, min_size=n, max_size=n)) for n in draw(st.tuples(sizes, sizes, sizes)))
        )
        for _ in range(draw(st.integers(0, 4)))
    ]
    return trajectory(joints, *points, stamp=draw(TIMES))


@given(st.lists(wild_trajectories(), min_size=1, max_size=3), st.booleans())
def test_no_message_raises_an_error_and_every_goal_gets_a_response(sent: list[Any], partial: bool) -> None:
    arm = Arm(allow_partial_joints_goal=partial)
    for message in sent:
        arm.publish(message)
        arm.send(message)
        arm.tick(2)
        assert np.isfinite([arm.node.position_command, arm.node.velocity_command]).all()
    arm.peer.cancel()
    arm.tick(2)
    assert (len(arm.peer.accepted), len(arm.results)) == (len(sent), len(sent))
