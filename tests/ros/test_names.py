from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.errors import TopicError
from graphengine.messages import names

CHASSIS = "/dd100/Geometry/base_link/chassis_link"
ROBOT = {"/dd100/Geometry/base_link": "dd100_0000", f"{CHASSIS}/sim_lidar": "sim_lidar"}


def collected(prims: dict[str, str], start: str) -> list[str]:
    return [value for path, value in prims.items() if start == path or start.startswith(path + "/")]


# isaacsim.ros2.nodes/python/tests/test_camera_info.py
def test_namespaces_join_from_the_outermost_inwards() -> None:
    prims = {"/World/robot": "my_robot", "/World/robot/sensors": "front"}
    assert names.join_namespaces(collected(prims, "/World/robot/sensors/camera")) == "my_robot/front"
    assert names.join_namespaces([]) == ""


# The tutorial's topics, and Ros2Node.h of isaacsim.ros2.core.
@pytest.mark.parametrize(
    ("start", "topic", "outermost", "full"),
    [
        (f"{CHASSIS}/sim_lidar/Lidar", "scan", False, "/dd100_0000/sim_lidar/scan"),
        (f"{CHASSIS}/sim_lidar/tf", "tf", True, "/dd100_0000/tf"),
        (f"{CHASSIS}/sim_lidar/tf", "tf_static", True, "/dd100_0000/tf_static"),
        (f"{CHASSIS}/joints", "platform/joint_states", False, "/dd100_0000/platform/joint_states"),
        ("/World/clock/PublishClock", "clock", False, "/clock"),
    ],
)
def test_topics_of_the_tutorial_equal_those_in_isaac_sim(start: str, topic: str, outermost: bool, full: str) -> None:
    namespace = names.join_namespaces(collected(ROBOT, start), outermost)
    assert names.full_topic(namespace, topic) == full


# Ros2Node.h
@pytest.mark.parametrize(
    ("namespace", "topic", "full"),
    [
        ("foo/", "/scan", "/foo/scan"),
        ("", "/scan", "/scan"),
        ("", "~/x", "/x"),
        ("~/_robot_/", "scan_", "/robot/scan"),
        ("/a/b", "c/d", "/a/b/c/d"),
        ("///", "x", "/x"),
    ],
)
def test_both_ends_are_trimmed_and_an_absolute_name_stays_in_a_namespace(namespace: str, topic: str, full: str) -> None:
    assert names.full_topic(namespace, topic) == full


# Ros2Node.h
def test_a_node_is_named_after_its_prim() -> None:
    assert names.node_name("/World/Graph/Pub-1") == "_World_Graph_Pub_1"
    names.check_node_name(names.node_name("/World/Graph/Pub-1"))


# isaacsim.ros2.core/library/tests/TestRos2NodeHandle.cpp, and rmw/test/test_validate_namespace.cpp
def test_rcl_accepts_these_names_of_nodes_and_namespaces() -> None:
    for name in ("valid_node_name", "node123", "_private_node", "a" * 255):
        names.check_node_name(name)
    for name in ("/valid/namespace", "/", "/a", "/_a/b1", "/" + "a" * 244):
        names.check_namespace(name)


# isaacsim.ros2.core/library/tests/TestRos2NodeHandle.cpp
@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("", "is empty"),
        ("node/with/slash", "has '/' at character 5"),
        ("node-with-dash", "has '-' at character 5"),
        ("123node", "starts with the digit '1'"),
        ("knöten", "has 'ö' at character 3"),
        ("a" * 256, "has 256 characters, at most 255"),
    ],
)
def test_rcl_refuses_these_node_names(name: str, fault: str) -> None:
    with pytest.raises(TopicError, match=fault):
        names.check_node_name(name)


# isaacsim.ros2.core/library/tests/TestRos2NodeHandle.cpp, and rmw/test/test_validate_namespace.cpp
@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("valid_namespace", "does not start with '/'"),
        ("", "is empty"),
        ("namespace with space", "has ' ' at character 10"),
        ("namespace-with-dash", "has '-' at character 10"),
        ("/a/", "ends with '/'"),
        ("/a//b", "has two slashes in a row at character 3"),
        ("/a/1b", "has a part that starts with the digit '1' at character 4"),
        ("/" + "a" * 245, "has 246 characters, at most 245"),
    ],
)
def test_rcl_refuses_these_namespaces(name: str, fault: str) -> None:
    with pytest.raises(TopicError, match=fault) as caught:
        names.check_namespace(name)
    assert "legal: letters A-Z a-z, digits and _" in str(caught.value)


@pytest.mark.parametrize(
    ("namespace", "topic", "message", "value"),
    [
        ("", "sc an", "topic name '/sc an' (from 'sc an') has ' ' at character 4", "sc an"),
        ("robot", "a//b", "topic name '/robot/a//b' (from 'a//b') has two slashes in a row at character 9", "a//b"),
        ("my-robot", "scan", "namespace '/my-robot' (from 'my-robot') has '-' at character 4", "my-robot"),
        ("", "2d_scan", "starts with the digit '2'", "2d_scan"),
        ("", "/~_", "no letter or digit", "/~_"),
        ("", "", "no letter or digit", ""),
        ("", "a{node}b", "has '{' at character 3", "a{node}b"),
        ("", "x" * 300, "has 301 characters, at most 247", "x" * 300),
    ],
)
def test_an_error_names_the_fault_and_the_input(namespace: str, topic: str, message: str, value: str) -> None:
    with pytest.raises(TopicError) as caught:
        names.full_topic(namespace, topic)
    assert message in caught.value.message
    assert caught.value.value == value
    assert caught.value.help


def reference_rule(name: str) -> bool:
    """rmw_validate_full_topic_name, in other words."""
    parts = name.split("/")
    alphabet = set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_")
    return (
        len(parts) > 1
        and parts[0] == ""
        and all(part and set(part) <= alphabet and part[0] not in "0123456789" for part in parts[1:])
        and len(name) <= 247
    )


@given(st.one_of(st.text("ab_/1~ -é", max_size=12), st.text(max_size=12), st.from_regex(r"(/[a-z_1]{1,90}){1,4}")))
def test_the_accepted_names_are_those_that_rcl_accepts(name: str) -> None:
    try:
        names.check_topic(name)
        passed = True
    except TopicError:
        passed = False
    assert passed == reference_rule(name)


@given(st.text(max_size=20), st.text(max_size=20))
def test_a_full_topic_is_always_legal(namespace: str, topic: str) -> None:
    try:
        full = names.full_topic(namespace, topic)
    except TopicError:
        return
    assert reference_rule(full)


@pytest.mark.parametrize("topic", ["rt/a/bRequest", "rq/a/bRequestRequest", "rr/a/bRequestReply"])
def test_dds_topics_and_ros_names_convert_to_each_other(topic: str) -> None:
    assert names.ros_name(topic) == "/a/bRequest"
    assert topic in ("rt/a/bRequest", *names.service_topics("/a/bRequest"))


@pytest.mark.parametrize("topic", ["ros_discovery_info", "DCPSParticipant", "rt", "rx/a", "a/rt/b", ""])
def test_a_dds_topic_outside_of_ros_keeps_its_name(topic: str) -> None:
    assert names.ros_name(topic) == topic


def test_names_are_checked_without_loading_a_middleware() -> None:
    heavy = {"cyclonedds", "rosbags", "rclpy"}
    modules = "graphengine.messages.names, graphengine.ros.domain, graphengine.ros.transports.select"
    code = f"import sys, {modules}; assert not {heavy!r} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("name", ["über", "odomä", "²odom"])
def test_letters_of_other_alphabets_are_refused_instead_of_trimmed(name: str) -> None:
    with pytest.raises(TopicError, match="character"):
        names.full_topic("", name)
