"""IsaacReadWorldPose, IsaacComputeTransformTree, the two publishers of TF, and RobotStatePublisher."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.format.errors import ContextError, PrimError
from graphengine.nodes.core.transforms import IsaacComputeTransformTree, IsaacReadWorldPose
from graphengine.nodes.ros2.transforms import RobotStatePublisher, ROS2PublishRawTransformTree, ROS2PublishTransformTree
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, computed, dd100, matrix, quaternion, ready, vector, yaw

numbers = st.floats(-10.0, 10.0)
vectors = st.tuples(numbers, numbers, numbers)
angles = st.floats(-3.0, 3.0)


def turned(axis: int, angle: float) -> Quaternion:
    """Rotation about x, y or z."""
    parts = [0.0, 0.0, 0.0, math.cos(angle / 2)]
    parts[axis] = math.sin(angle / 2)
    return parts[0], parts[1], parts[2], parts[3]


rotations = st.builds(turned, st.sampled_from((0, 1, 2)), angles)
poses = st.tuples(vectors, rotations)


def tree(context: RecordingContext, *targets: str, parent: str = "") -> IsaacComputeTransformTree:
    """A node of those targets, computed once."""
    node = ready(IsaacComputeTransformTree, context, target_prims=targets, parent_prim=parent)
    context.tick()
    node.compute()
    return node


def edges(node: IsaacComputeTransformTree) -> list[tuple[str, str]]:
    return list(zip(node.parent_frames, node.child_frames, strict=True))


def at(pose: tuple[Vector3, Quaternion]) -> Any:
    """A pose as a 4 x 4 matrix."""
    placed = np.eye(4)
    placed[:3, :3], placed[:3, 3] = matrix(pose[1]), pose[0]
    return placed


# IsaacComputeTransformTree: what it expands to, and what the frames are called


def test_a_prim_without_parent_is_below_the_world(context: RecordingContext) -> None:
    context.world.add_body("/World/Cube", (2.0, 3.0, 4.0))
    node = tree(context, "/World/Cube")
    assert edges(node) == [("world", "Cube")]
    assert node.translations.tolist() == [[2.0, 3.0, 4.0]]
    assert node.orientations.tolist() == [[0.0, 0.0, 0.0, 1.0]]


def test_frames_are_known_before_the_first_tick_and_again_after_a_stop(context: RecordingContext) -> None:
    context.world.add_body("/World/Cube")
    node = ready(IsaacComputeTransformTree, context, target_prims="/World/Cube")
    assert edges(node) == [("world", "Cube")]
    context.stop(node)
    node.compute()
    assert edges(node) == [("world", "Cube")]


def robot_with_two_wheels(context: RecordingContext) -> None:
    context.world.add_robot("/robot", ["left", "right"])
    for side, y in (("left", 0.25), ("right", -0.25)):
        context.world.stage.add(f"/robot/Geometry/base_link/wheel_{side}", "link", position=(0.0, y, 0.0))
    context.world.stage.add("/robot/Geometry/base_link/wheel_left/hub", "link")
    context.world.stage.add("/robot/Geometry/base_link/sensor", "frame")


@pytest.mark.parametrize("target", ["/robot", "/robot/Geometry/base_link", "/robot/base_link"])
def test_a_robot_as_target_gives_its_links_in_kinematic_order_without_sensors(target: str) -> None:
    context = RecordingContext()
    robot_with_two_wheels(context)
    expected = [
        ("world", "base_link"),
        ("base_link", "wheel_left"),
        ("wheel_left", "hub"),
        ("base_link", "wheel_right"),
    ]
    assert edges(tree(context, target)) == expected


# IsaacComputeTransformTree: poses


@given(parent=poses, child=poses)
def test_poses_are_relative_to_the_parent(
    parent: tuple[Vector3, Quaternion], child: tuple[Vector3, Quaternion]
) -> None:
    context = RecordingContext()
    context.world.add_body("/World/Parent", *parent)
    context.world.add_body("/World/Child", *child)
    node = tree(context, "/World/Child", parent="/World/Parent")
    expected = np.linalg.inv(at(parent)) @ at(child)
    x, y, z, w = node.orientations[0].tolist()
    assert np.allclose(at((node.translations[0], (x, y, z, w))), expected, atol=1e-9)


@given(body=poses, mount=poses, sensor=poses)
def test_a_prim_without_physics_moves_with_the_body_that_carries_it(
    body: tuple[Vector3, Quaternion], mount: tuple[Vector3, Quaternion], sensor: tuple[Vector3, Quaternion]
) -> None:
    context = RecordingContext()
    context.world.add_body("/body", *body)
    context.world.stage.add("/body/mount", "frame", position=mount[0], orientation=mount[1])
    context.world.stage.add("/body/mount/sensor", "frame", position=sensor[0], orientation=sensor[1])
    node = tree(context, "/body/mount/sensor")
    x, y, z, w = node.orientations[0].tolist()
    assert np.allclose(at((node.translations[0], (x, y, z, w))), at(body) @ at(mount) @ at(sensor), atol=1e-9)


@given(pose=poses)
def test_the_frame_of_a_camera_is_turned_by_180_degrees_about_x_and_a_lidars_is_not(
    pose: tuple[Vector3, Quaternion],
) -> None:
    context = RecordingContext()
    for kind in ("camera", "lidar"):
        context.world.stage.add(f"/{kind}", kind, position=pose[0], orientation=pose[1])
    node = tree(context, "/camera", "/lidar")
    camera, lidar = (matrix((x, y, z, w)) for x, y, z, w in node.orientations.tolist())
    assert np.allclose(camera, matrix(pose[1]) @ np.diag([1.0, -1.0, -1.0]))
    assert np.allclose(lidar, matrix(pose[1]))


def test_every_execution_reads_the_poses_of_its_tick_into_new_arrays(context: RecordingContext) -> None:
    body = context.world.add_body("/World/Cube")
    node = tree(context, "/World/Cube")
    before = node.translations
    body.position = (1.0, 0.0, 0.0)
    node.compute()
    assert (before.tolist(), node.translations.tolist()) == ([[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0]])


# ROS2PublishRawTransformTree


@given(pose=poses)
def test_the_raw_transform_is_published_unchanged(pose: tuple[Vector3, Quaternion]) -> None:
    values = {"translation": pose[0], "rotation_in": pose[1], "time_stamp": 1.5}
    node = ready(ROS2PublishRawTransformTree, RecordingContext(), **values)
    (edge,) = node.message().transforms
    assert (edge.header.frame_id, edge.child_frame_id) == ("odom", "base_link")
    assert (edge.header.stamp.sec, edge.header.stamp.nanosec) == (1, 500_000_000)
    assert (vector(edge.transform.translation), quaternion(edge.transform.rotation)) == pose


def test_the_claim_of_a_raw_transform_names_its_frames(context: RecordingContext) -> None:
    ready(ROS2PublishRawTransformTree, context, parent_frame_id="map", child_frame_id="odom")
    assert [claim.transforms for claim in context.services.claims] == [(("map", "odom"),)]


# ROS2PublishTransformTree


def publishing(context: RecordingContext, **inputs: Any) -> ROS2PublishTransformTree:
    return ready(ROS2PublishTransformTree, context, **inputs)


ARRAYS: dict[str, Any] = {
    "parent_frames": ("base", "arm"),
    "child_frames": ("arm", "hand"),
    "translations": [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)],
    "orientations": [(0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)],
}


def test_arrays_are_published_in_one_message_with_one_stamp(context: RecordingContext) -> None:
    publishing(context, time_stamp=0.25, **ARRAYS).compute()
    (message,) = context.transport.messages("/tf")
    found = [(t.header.frame_id, t.child_frame_id, vector(t.transform.translation)) for t in message.transforms]
    assert found == [("base", "arm", (1.0, 2.0, 3.0)), ("arm", "hand", (4.0, 5.0, 6.0))]
    assert [quaternion(t.transform.rotation) for t in message.transforms] == ARRAYS["orientations"]
    assert {t.header.stamp.nanosec for t in message.transforms} == {250_000_000}


@pytest.mark.parametrize("short", ["parent_frames", "child_frames", "translations", "orientations"])
def test_arrays_of_different_lengths_are_an_error_and_nothing_is_published(
    short: str, context: RecordingContext
) -> None:
    node = publishing(context, **{**ARRAYS, short: ARRAYS[short][:1]})
    with pytest.raises(
        ValueError, match="parentFrames, childFrames, translations, orientations must be of the same length"
    ):
        node.compute()
    assert context.transport.messages("/tf") == []


def test_without_arrays_target_prims_are_expanded_as_by_the_compute_node(context: RecordingContext) -> None:
    robot_with_two_wheels(context)
    context.world.stage.add("/robot/Geometry/base_link/camera", "camera", position=(1.0, 0.0, 0.0))
    targets = ("/robot", "/robot/base_link/camera")
    computed = tree(context, *targets, parent="/robot/base_link")
    (message,) = [publishing(context, target_prims=targets, parent_prim="/robot/base_link").message()]
    assert [(t.header.frame_id, t.child_frame_id) for t in message.transforms] == edges(computed)
    assert [list(vector(t.transform.translation)) for t in message.transforms] == computed.translations.tolist()
    assert [list(quaternion(t.transform.rotation)) for t in message.transforms] == computed.orientations.tolist()


LOOPS = [
    ("/robot/base_link/wheel_left", True, False),
    ("/World/Crate", True, False),
    ("/robot/base_link/sensor", True, True),
    ("/robot/base_link/camera", True, True),
    ("/robot/base_link", True, False),
    ("/robot", False, False),
]
"""A prim that is both parent and target, and whether either node has an edge from it, or its root link, to itself."""


@pytest.mark.parametrize(("target", "computed", "published"), LOOPS)
def test_a_parent_among_the_targets_gives_an_edge_to_itself_as_in_isaac_sim(
    target: str, computed: bool, published: bool, context: RecordingContext
) -> None:
    robot_with_two_wheels(context)
    context.world.stage.find("/robot").facts["articulation_root"] = "/robot/Geometry/base_link"
    context.world.stage.add("/robot/Geometry/base_link/camera", "camera", position=(1.0, 0.0, 0.0))
    context.world.add_body("/World/Crate", (1.0, 2.0, 3.0))
    parent = "/robot/base_link" if target == "/robot" else target
    targets, name = (target, "/robot/base_link/wheel_right"), parent.rpartition("/")[2]
    node = tree(context, *targets, parent=parent)
    (message,) = [publishing(context, target_prims=targets, parent_prim=parent).message()]
    found = [(t.header.frame_id, t.child_frame_id) for t in message.transforms]
    assert ((name, name) in edges(node), (name, name) in found) == (computed, published)
    if computed:
        assert node.translations.tolist()[edges(node).index((name, name))] == [0.0, 0.0, 0.0]


def test_the_parent_alone_as_a_target_gives_an_empty_message(context: RecordingContext) -> None:
    robot_with_two_wheels(context)
    wheel = "/robot/base_link/wheel_left"
    assert publishing(context, target_prims=(wheel,), parent_prim=wheel).message().transforms == []


def test_without_arrays_and_targets_setup_is_refused() -> None:
    with pytest.raises(ContextError, match="parentFrames"):
        publishing(RecordingContext())


def test_in_a_graph_the_claim_names_the_frames_of_a_compute_node_before_the_first_tick(play: Player) -> None:
    playing = play.shipped("tutorial/joint_states", dd100())
    claimed = {claim.topic: claim.transforms for claim in playing.session.services.claims if claim.transforms}
    assert claimed["/dd100_0000/tf_static"] == (("chassis_link", "sim_lidar"),)
    assert claimed["/dd100_0000/tf"] == (("odom", "base_link"),)


def test_in_the_tutorials_graph_tf_static_is_published_once_a_play_with_the_lidars_mount(play: Player) -> None:
    playing = play.shipped("tutorial/joint_states", dd100()).tick(5)
    playing.session.stop()
    playing.tick(5)
    sent = playing.published("/dd100_0000/tf_static")
    assert len(sent) == 2
    for message in sent:
        (edge,) = message.transforms
        assert (edge.header.frame_id, edge.child_frame_id) == ("chassis_link", "sim_lidar")
        assert vector(edge.transform.translation) == (0.0, 0.0, 0.15)
        assert edge.header.stamp.nanosec == int(1e9 / 60)


# RobotStatePublisher


class Described:
    """A robot with a fixed and a moving link, and a node that publishes its state."""

    def __init__(self, **inputs: Any) -> None:
        self.context = context = RecordingContext("/robot/Geometry/base_link/graph/State")
        fixed = (("base_link", "mast", (0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)),)
        wheel = "/robot/Geometry/base_link/wheel"
        context.world.add_robot("/robot", ["axle"], urdf="<robot/>", fixed_transforms=fixed, moving_links=(wheel,))
        context.world.stage.add(wheel, "link", position=(0.0, 0.25, 0.0), body=wheel)
        context.world.stage.find("/robot/base_link").namespace = "robot_1"
        self.node = ready(RobotStatePublisher, context, target_prim="/robot", **inputs)

    def execute(self, ticks: int = 1) -> None:
        """Execute the node after so many ticks."""
        self.context.tick(ticks)
        self.node.time_stamp = self.context.clock.time
        self.node.compute()

    def sent(self, topic: str) -> list[Any]:
        """Messages on a topic."""
        return self.context.transport.messages(f"/robot_1/{topic}")

    @property
    def counts(self) -> list[int]:
        """How many messages went out on each topic."""
        return [len(self.sent(topic)) for topic in ("tf", "tf_static", "robot_description")]


def test_the_description_and_the_fixed_joints_are_published_once_and_latched() -> None:
    described = Described()
    for _ in range(3):
        described.execute()
    assert [message.data for message in described.sent("robot_description")] == ["<robot/>"]
    (static,) = described.sent("tf_static")
    assert [(t.header.frame_id, t.child_frame_id) for t in static.transforms] == [("base_link", "mast")]
    assert vector(static.transforms[0].transform.translation) == (0.0, 0.0, 1.0)
    claimed = [(claim.latched, claim.transforms) for claim in described.context.services.claims]
    assert claimed == [(True, ()), (True, (("base_link", "mast"),)), (False, (("base_link", "wheel"),))]


@pytest.mark.parametrize("frequency", [1.0, 7.0, 20.0, 60.0, 100.0])
def test_moving_links_are_published_at_their_frequency_but_at_most_once_a_tick(frequency: float) -> None:
    described = Described(publish_frequency=frequency)
    for _ in range(600):
        described.execute()
    assert described.counts[0] - min(10.0 * frequency, 600.0) in (0.0, 1.0)


def test_the_transforms_of_moving_links_are_their_current_poses() -> None:
    described = Described()
    world = described.context.world
    world.body(world.stage.find("/robot/base_link/wheel")).orientation = yaw(0.5)
    described.execute()
    (message,) = described.sent("tf")
    (edge,) = message.transforms
    assert (edge.header.frame_id, edge.child_frame_id) == ("base_link", "wheel")
    assert vector(edge.transform.translation) == (0.0, 0.25, 0.0)
    assert np.allclose(quaternion(edge.transform.rotation), yaw(0.5))


def test_after_a_stop_the_robot_state_is_published_again() -> None:
    described = Described()
    described.execute(100)
    described.context.stop(described.node)
    described.execute(100)
    assert described.counts == [2, 2, 2]


def test_the_robot_state_is_published_again_when_its_frequency_changes() -> None:
    described = Described()
    described.execute(600)
    described.context.close()
    described.node.publish_frequency = 1.0
    described.node.setup(described.context)
    described.execute(600)
    assert described.counts == [2, 2, 2]


@pytest.mark.parametrize("frequency", [0.0, -1.0, math.nan, math.inf, 1e308])
def test_an_invalid_frequency_is_refused_in_setup(frequency: float) -> None:
    described = Described()
    described.node.publish_frequency = frequency
    with pytest.raises(ValueError, match="publishFrequency must be above 0 and at most 1e9 Hz"):
        described.node.setup(described.context)


def test_the_shipped_graph_of_the_robot_state_works_for_any_robot(play: Player) -> None:
    playing = play.shipped("robot_state", dd100()).tick()
    topics = {claim.topic for claim in playing.session.services.claims}
    assert topics == {"/dd100_0000/robot_description", "/dd100_0000/tf_static", "/dd100_0000/tf"}


# IsaacReadWorldPose


@given(carrier=poses, mounted=poses)
def test_a_world_pose_includes_the_poses_of_all_carriers(
    carrier: tuple[Vector3, Quaternion], mounted: tuple[Vector3, Quaternion]
) -> None:
    context = RecordingContext()
    context.world.add_body("/body", *carrier)
    context.world.stage.add("/body/mount", "frame", position=mounted[0], orientation=mounted[1])
    node = computed(IsaacReadWorldPose, context, prim="/body/mount")
    np.testing.assert_allclose(at((node.translation, node.orientation)), at(carrier) @ at(mounted), atol=1e-9)
    assert node.scale == (1.0, 1.0, 1.0)


def test_before_the_first_computation_a_world_pose_has_isaac_sims_defaults(context: RecordingContext) -> None:
    context.world.add_body("/body", (1.0, 2.0, 3.0))
    node = ready(IsaacReadWorldPose, context, prim="/body")
    assert (node.translation, node.orientation) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    assert node.scale == (0.0, 0.0, 0.0)


def test_in_a_graph_a_world_pose_is_the_pose_of_the_current_tick(play: Player) -> None:
    world = dd100()
    playing = play.graph(
        """
        nodes: {Tick: OnPlaybackTick, Pose: {type: ReadWorldPose, inputs: {prim: /dd100}}, TF: PublishRawTransformTree}
        connections: [Tick.tick -> TF.execIn, Pose.translation -> TF.translation, Pose.orientation -> TF.rotation]
        """,
        world,
    )
    body = world.body(world.stage.find("/dd100"))
    for x in (1.0, 2.0):
        body.position = (x, 0.0, 0.0)
        playing.tick()
        (transform,) = playing.published("/tf")[-1].transforms
        assert vector(transform.transform.translation) == (x, 0.0, 0.0)


@pytest.mark.parametrize(("cls", "port"), [(IsaacReadWorldPose, "prim"), (IsaacComputeTransformTree, "target_prims")])
def test_an_unknown_prim_is_refused(cls: Any, port: str) -> None:
    with pytest.raises(PrimError, match="/nowhere"):
        ready(cls, RecordingContext(), **{port: "/nowhere"})
