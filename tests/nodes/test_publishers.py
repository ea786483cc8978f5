"""What all publishers have in common: where they publish, when, and with which quality of service; and ROS2Context."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from graphengine.compiler.registry import default_registry
from graphengine.format.errors import GraphError, TopicError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.nodes.ros2.ackermann import ROS2PublishAckermannDrive
from graphengine.nodes.ros2.boxes import ROS2PublishBbox2D, ROS2PublishBbox3D
from graphengine.nodes.ros2.camera_info import ROS2PublishCameraInfo
from graphengine.nodes.ros2.compressed_image import ROS2PublishCompressedImage
from graphengine.nodes.ros2.context import ROS2Context
from graphengine.nodes.ros2.image import ROS2PublishImage
from graphengine.nodes.ros2.imu import ROS2PublishImu
from graphengine.nodes.ros2.labels import ROS2PublishObjectIdMap, ROS2PublishSemanticLabels
from graphengine.nodes.ros2.laser_scan import ROS2PublishLaserScan
from graphengine.nodes.ros2.point_cloud import ROS2PublishPointCloud
from graphengine.nodes.ros2.publisher import PublisherNode, SensorPublisher
from graphengine.nodes.ros2.state import ROS2PublishClock, ROS2PublishJointState, ROS2PublishOdometry
from graphengine.nodes.ros2.transforms import ROS2PublishRawTransformTree, ROS2PublishTransformTree, TransformPublisher
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, dd100, ready

PUBLISHERS: dict[type[PublisherNode], tuple[str, dict[str, Any]]] = {
    ROS2PublishClock: ("clock", {}),
    ROS2PublishJointState: ("joint_states", {"target_prim": "/robot"}),
    ROS2PublishOdometry: ("odom", {}),
    ROS2PublishRawTransformTree: ("tf", {}),
    ROS2PublishTransformTree: ("tf", {"target_prims": "/robot/Geometry/base_link"}),
    ROS2PublishImage: ("rgb", {}),
    ROS2PublishCameraInfo: ("camera_info", {}),
    ROS2PublishPointCloud: ("point_cloud", {}),
    ROS2PublishLaserScan: ("scan", {"linear_depth_data": [1.0], "num_rows": 1, "num_cols": 1}),
    ROS2PublishImu: ("imu", {}),
    ROS2PublishAckermannDrive: ("ackermann_cmd", {}),
    ROS2PublishCompressedImage: ("image_raw/compressed", {"data": [1, 2, 3]}),
    ROS2PublishBbox2D: ("bbox2d", {}),
    ROS2PublishBbox3D: ("bbox3d", {}),
    ROS2PublishSemanticLabels: ("labels", {}),
    ROS2PublishObjectIdMap: ("labels", {}),
}
"""Default topics, and inputs that a node cannot do without."""
NODE = "/robot/Geometry/base_link/graph/Publish"
STATIC = LATCHED = QoS(depth=1, reliability="reliable", durability="transientLocal")

every_publisher = pytest.mark.parametrize("cls", PUBLISHERS)
every_sensor_publisher = pytest.mark.parametrize("cls", [c for c in PUBLISHERS if issubclass(c, SensorPublisher)])
every_tf_publisher = pytest.mark.parametrize("cls", [c for c in PUBLISHERS if issubclass(c, TransformPublisher)])


def robot(*, wanted: bool = True) -> RecordingContext:
    """A robot whose graph lies below its base link."""
    context = RecordingContext(NODE, wanted=wanted)
    context.world.add_robot("/robot", ["left", "right"])
    return context


def publishing(cls: type[PublisherNode], context: RecordingContext, **inputs: Any) -> PublisherNode:
    return ready(cls, context, **{**PUBLISHERS[cls][1], **inputs})


def claimed(cls: type[PublisherNode], context: RecordingContext, **inputs: Any) -> Any:
    """What a node asked for."""
    publishing(cls, context, **inputs)
    (claim,) = context.services.claims
    return claim


def test_the_tests_of_this_file_cover_every_publisher_of_one_message() -> None:
    assert {cls for cls in default_registry().types.values() if issubclass(cls, PublisherNode)} == set(PUBLISHERS)


@every_publisher
def test_the_default_topic_is_isaac_sims(cls: type[PublisherNode]) -> None:
    assert claimed(cls, robot()).topic == f"/{PUBLISHERS[cls][0]}"


@every_publisher
def test_every_execution_including_the_first_publishes_one_message(cls: type[PublisherNode]) -> None:
    context = robot()
    node = publishing(cls, context)
    for count in (1, 2, 3):
        node.compute()
        assert len(context.transport.raw(f"/{PUBLISHERS[cls][0]}")) == count


@every_publisher
def test_the_message_passes_the_check_of_its_type(cls: type[PublisherNode]) -> None:
    node = publishing(cls, robot())
    messages.check(node.message())
    assert messages.message_type(node.message()) == cls.message_type


@every_publisher
def test_without_subscribers_no_message_is_built(cls: type[PublisherNode]) -> None:
    # No message can be built of this time: if it were built, compute would raise.
    unwanted = publishing(cls, robot(wanted=False), time_stamp=1e12)
    unwanted.compute()
    wanted = publishing(cls, robot(), time_stamp=1e12)
    with pytest.raises(GraphError):
        wanted.compute()


@every_publisher
def test_a_late_subscriber_gets_only_later_messages(cls: type[PublisherNode]) -> None:
    context, heard = robot(wanted=False), list[bytes]()
    node, topic = publishing(cls, context), f"/{PUBLISHERS[cls][0]}"
    node.compute()
    context.transport.reader(topic, cls.message_type, QoS(), heard.append)
    node.compute()
    assert context.transport.raw(topic) == heard
    assert len(heard) == 1


@every_publisher
def test_a_second_play_publishes_the_same_messages(cls: type[PublisherNode]) -> None:
    context = robot()
    node = publishing(cls, context)
    node.compute()
    context.stop(node)
    node.compute()
    first, second = context.transport.raw(f"/{PUBLISHERS[cls][0]}")
    assert first == second


@every_publisher
def test_a_changed_time_stamp_takes_effect(cls: type[PublisherNode]) -> None:
    context = robot()
    node = publishing(cls, context, time_stamp=1.25)
    assert stamp(node.message()) == (1, 250_000_000)
    node.time_stamp = 2.5
    assert stamp(node.message()) == (2, 500_000_000)


@every_sensor_publisher
def test_the_frame_is_in_the_header_and_in_the_table_of_topics(cls: type[PublisherNode]) -> None:
    context = robot()
    node = publishing(cls, context, frame_id="front")
    (claim,) = context.services.claims
    assert (node.message().header.frame_id, claim.frame_id) == ("front", "front")


@every_publisher
def test_rosbags_decodes_the_published_bytes_to_an_equal_message(cls: type[PublisherNode]) -> None:
    context = robot()
    node = publishing(cls, context, time_stamp=1.25)
    for _ in range(3):  # later ones by a template of the first
        node.compute()
    sent = context.transport.raw(f"/{PUBLISHERS[cls][0]}")
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(DEFINITIONS.text(cls.message_type), cls.message_type))
    read = [store.deserialize_cdr(data, cls.message_type) for data in sent]
    assert [stamp(message) for message in read] == [(1, 250_000_000)] * 3
    assert len(set(sent)) == 1


def stamp(message: Any) -> tuple[int, int]:
    """Seconds and nanoseconds of any of these messages."""
    if messages.message_type(message) == "std_msgs/msg/String":
        told = json.loads(message.data)["time_stamp"]
        return told["sec"], told["nanosec"]
    if hasattr(message, "transforms"):
        message = message.transforms[0]
    time = message.clock if hasattr(message, "clock") else message.header.stamp
    return time.sec, time.nanosec


# Names


@every_publisher
def test_a_given_namespace_replaces_the_collected_namespace(cls: type[PublisherNode]) -> None:
    context = robot()
    context.world.stage.find("/robot").namespace = "collected"
    assert claimed(cls, context, node_namespace="/given/", topic_name="/topic_").topic == "/given/topic"


@every_publisher
def test_without_a_namespace_it_is_collected_from_the_ancestors_of_the_node(cls: type[PublisherNode]) -> None:
    context = robot()
    context.world.stage.find("/robot").namespace = "fleet"
    context.world.stage.find("/robot/Geometry/base_link").namespace = "robot_1"
    collected = "/fleet" if issubclass(cls, TransformPublisher) else "/fleet/robot_1"
    assert claimed(cls, context).topic == f"{collected}/{PUBLISHERS[cls][0]}"


@every_publisher
def test_a_leading_slash_does_not_escape_the_namespace(cls: type[PublisherNode]) -> None:
    context = robot()
    context.world.stage.find("/robot").namespace = "robot_1"
    assert claimed(cls, context, topic_name="/up/and_/down/").topic == "/robot_1/up/and_/down"


@every_publisher
@pytest.mark.parametrize("topic", ["", "/", "~", "1st", "with space", "with-dash", "a//b"])
def test_a_topic_that_ros_refuses_is_refused_in_setup(cls: type[PublisherNode], topic: str) -> None:
    with pytest.raises(TopicError):
        publishing(cls, robot(), topic_name=topic)


TUTORIAL = {
    "SubscribeTwist": "/dd100_0000/cmd_vel",
    "PublishJointState": "/dd100_0000/platform/joint_states",
    "PublishOdom": "/dd100_0000/odom",
    "PublishRawTF": "/dd100_0000/tf",
    "PublishTF": "/dd100_0000/tf_static",
    "LidarHelper": "/dd100_0000/sim_lidar/scan",
    "PublishClock": "/clock",
}
"""What the tutorial's robot shows: its namespaces are dd100_0000 on base_link and sim_lidar on the lidar."""
GRAPHS = ("cmd_vel", "joint_states", "scan")


@pytest.mark.parametrize(
    "name", ["clock", *(f"dd100/{name}" for name in GRAPHS), *(f"tutorial/{name}" for name in GRAPHS)]
)
def test_the_topics_of_the_shipped_graph_are_those_of_the_tutorial(play: Player, name: str) -> None:
    playing = play.shipped(name, dd100())
    assert playing.topics == {node: topic for node, topic in TUTORIAL.items() if node in playing.topics} != {}


def test_a_graph_outside_the_robot_has_no_namespace_and_its_lidar_has_the_robots(play: Player) -> None:
    text = """
        at: /World/elsewhere
        nodes:
          Tick: OnPlaybackTick
          PublishOdom: PublishOdometry
          LidarHelper:
            type: RtxLidarHelper
            inputs: {renderProductPath: /dd100/Geometry/base_link/chassis_link/sim_lidar/Lidar}
        connections: [Tick.tick -> PublishOdom.execIn, Tick.tick -> LidarHelper.execIn]
        """
    topics = play.graph(text, dd100()).topics
    assert topics == {"PublishOdom": "/odom", "LidarHelper": "/dd100_0000/sim_lidar/scan"}


# Quality of service


@every_publisher
def test_without_a_profile_the_qos_is_reliable_volatile_with_the_queue_size_as_depth(cls: type[PublisherNode]) -> None:
    expected = QoS("keepLast", 3, "reliable", "volatile", 0.0, 0.0, "systemDefault", 0.0)
    assert claimed(cls, robot(), queue_size=3).qos == expected


@every_publisher
def test_a_profile_overrides_the_queue_size(cls: type[PublisherNode]) -> None:
    profile = json.dumps({"depth": 5, "reliability": "bestEffort", "deadline": 0.5})
    assert claimed(cls, robot(), queue_size=3, qos_profile=profile).qos == QoS(
        depth=5, reliability="bestEffort", deadline=0.5
    )


@every_publisher
@pytest.mark.parametrize("profile", ["no json", "[]", '{"dept": 1}', '{"reliability": "perhaps"}', '{"depth": -1}'])
def test_an_invalid_profile_is_refused_in_setup(cls: type[PublisherNode], profile: str) -> None:
    with pytest.raises(TopicError):
        publishing(cls, robot(), qos_profile=profile)


@every_tf_publisher
def test_a_static_publisher_is_latched_for_any_profile(cls: type[PublisherNode]) -> None:
    claim = claimed(cls, robot(), static_publisher=True, queue_size=7, qos_profile='{"depth": 5}')
    assert (claim.qos, claim.latched) == (STATIC, True)


@every_tf_publisher
def test_a_static_publisher_sends_once_a_play_even_without_subscribers(cls: type[PublisherNode]) -> None:
    context = robot(wanted=False)
    node = publishing(cls, context, static_publisher=True)
    for _ in range(3):
        node.compute()
    assert len(context.transport.raw("/tf")) == 1
    context.stop(node)
    node.compute()
    node.compute()
    assert len(context.transport.raw("/tf")) == 2


@every_tf_publisher
def test_a_late_subscriber_gets_the_static_transforms(cls: type[PublisherNode]) -> None:
    context, heard = robot(wanted=False), list[bytes]()
    publishing(cls, context, static_publisher=True).compute()
    context.transport.reader("/tf", cls.message_type, LATCHED, heard.append)
    assert heard == context.transport.raw("/tf")


# Changes while the graph runs


def test_a_topic_changed_during_play_gets_a_new_publisher(play: Player) -> None:
    playing = play.graph("nodes: {T: OnPlaybackTick, C: PublishClock}\nconnections: [T.tick -> C.execIn]").tick()
    playing.set("C", "topic_name", "other")
    playing.tick(2)
    assert (len(playing.published("/clock")), len(playing.published("/other"))) == (1, 2)


def test_static_transforms_are_published_again_on_a_changed_topic(play: Player) -> None:
    text = "{type: PublishRawTransformTree, inputs: {staticPublisher: true}}"
    playing = play.graph(f"nodes: {{T: OnPlaybackTick, TF: {text}}}\nconnections: [T.tick -> TF.execIn]").tick(2)
    playing.set("TF", "topic_name", "other")
    playing.tick(2)
    assert (len(playing.published("/tf")), len(playing.published("/other"))) == (1, 1)


def test_changed_frame_ids_take_effect(play: Player) -> None:
    playing = play.graph("nodes: {T: OnPlaybackTick, O: PublishOdometry}\nconnections: [T.tick -> O.execIn]").tick()
    playing.set("O", "odom_frame_id", "map")
    playing.set("O", "chassis_frame_id", "chassis")
    playing.tick()
    frames = [(m.header.frame_id, m.child_frame_id) for m in playing.published("/odom")]
    assert frames == [("odom", "base_link"), ("map", "chassis")]


# ROS2Context


@pytest.mark.parametrize(
    ("environment", "inputs", "domain"),
    [
        (None, {}, 0),
        (None, {"domain_id": 7}, 7),
        (42, {"domain_id": 7}, 42),
        (42, {"domain_id": 7, "use_domain_id_env_var": False}, 7),
        (0, {"domain_id": 7}, 0),
    ],
)
def test_the_domain_of_the_environment_overrides_the_input_if_selected(
    environment: int | None, inputs: dict[str, Any], domain: int
) -> None:
    context = RecordingContext(ros_domain_id=environment)
    node = ROS2Context(**inputs)
    node.setup(context)
    node.compute()
    assert node.context == context.ros_context(domain, use_environment=False) != 0


def test_a_context_is_a_data_node_and_0_before_it_is_read() -> None:
    assert (ROS2Context.kind(), ROS2Context().context) == ("data", 0)


def test_a_domain_out_of_range_is_refused() -> None:
    with pytest.raises(TopicError, match="233"):
        ready(ROS2Context, RecordingContext(), domain_id=233)


def test_in_a_graph_endpoints_live_in_the_contexts_domain(play: Player) -> None:
    text = """
        nodes:
          T: OnPlaybackTick
          Domain: {type: ROS2Context, inputs: {domain_id: 5}}
          C: PublishClock
          S: SubscribeTwist
          Own: {type: PublishClock, inputs: {topicName: own}}
        connections:
          - T.tick -> C.execIn
          - T.tick -> S.execIn
          - T.tick -> Own.execIn
          - Domain.context -> C.context
          - Domain.context -> S.context
        """
    playing = play.graph(text)
    five = RecordingContext().ros_context(5, use_environment=False)
    assert {c.topic: c.ros_context for c in playing.session.services.claims} == {
        "/clock": five,
        "/cmd_vel": five,
        "/own": 0,
    }


# ROS2PublishClock


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [(0.0, (0, 0)), (1 / 60, (0, 16_666_666)), (12.5, (12, 500_000_000)), (-0.5, (-1, 500_000_000))],
)
def test_the_clock_message_contains_only_the_time_stamp(seconds: float, expected: tuple[int, int]) -> None:
    message = ROS2PublishClock(time_stamp=seconds).message()
    assert stamp(message) == expected


@pytest.mark.parametrize("seconds", [np.inf, np.nan, 2.0**31])
def test_a_time_out_of_range_of_a_ros_time_is_an_error(seconds: float) -> None:
    with pytest.raises((GraphError, ValueError)):
        ROS2PublishClock(time_stamp=seconds).message()
