"""Cases of QoS profiles, namespaces and names."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import pytest

from graphengine.devices.lidar import LidarStub
from graphengine.format.errors import TopicError
from graphengine.messages import names
from graphengine.messages.qos import parse_qos
from graphengine.nodes.ros2.lidar import ROS2RtxLidarHelper
from graphengine.nodes.ros2.qos_profile import ROS2QoSProfile
from graphengine.nodes.ros2.state import ROS2PublishClock
from graphengine.nodes.ros2.transforms import ROS2PublishRawTransformTree
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, ready
from tests.nodes.isaac.book import Case, made, runs

PROFILE = "isaacsim.ros2.bridge.ROS2QoSProfile"
NAMESPACE = "namespace collection"


def profile(qos: Any) -> Case:
    """A profile under the reference's names."""
    found = asdict(qos)
    return {"leaseDuration": found.pop("lease_duration"), **found}


@runs(PROFILE, "default", "Services", "System Default", "Custom passthrough")
def a_profile(case: Case, play: Player) -> None:
    node = made(ROS2QoSProfile, case)
    node.compute()
    assert json.loads(node.qos_profile) == profile(parse_qos(node.qos_profile)) == case["expect"]


def with_namespaces(case: Case, prim_path: str) -> RecordingContext:
    context = RecordingContext(prim_path)
    for path, namespace in case["inputs"].get("prims", {}).items():
        context.world.stage.add(path, "frame", namespace=namespace)
    return context


@runs(NAMESPACE, "helper nodes, from camera prim upwards", "both inputs empty")
def a_collected_namespace(case: Case, play: Player) -> None:
    start = case["inputs"].get("start", "/World/graph/node")
    collected = with_namespaces(case, start).world.stage.namespaces(start)
    assert names.join_namespaces(collected) == case["expect"]["namespace"]


@runs(NAMESPACE, "tutorial: scan")
def the_tutorials_scan(case: Case, play: Player) -> None:
    context = with_namespaces(case, "/World/scan/LidarHelper")
    lidar = f"{list(case['inputs']['prims'])[1]}/Lidar"
    context.world.add_device(LidarStub, lidar)
    ready(ROS2RtxLidarHelper, context, render_product_path=lidar, topic_name=case["inputs"]["topicName"])
    assert context.services.claims[0].topic == case["expect"]["topic"]


@runs(NAMESPACE, "tutorial: TF nodes use only the outermost namespace")
def the_tutorials_tf(case: Case, play: Player) -> None:
    context = with_namespaces(case, f"{list(case['inputs']['prims'])[1]}/graph/PublishTF")
    for topic in case["inputs"]["topicName"]:
        ready(ROS2PublishRawTransformTree, context, topic_name=topic)
    assert [claim.topic for claim in context.services.claims] == case["expect"]["topics"]


@runs(NAMESPACE, "explicit nodeNamespace wins")
def a_namespace_that_is_given(case: Case, play: Player) -> None:
    context = with_namespaces(case, f"{list(case['inputs']['prims'])[1]}/graph/Publish")
    given = case["inputs"]
    ready(ROS2PublishClock, context, node_namespace=given["nodeNamespace"], topic_name=given["topicName"])
    assert context.services.claims[0].topic == case["expect"]["topic"]


@runs("node name", "prim path sanitised")
def the_ros_name_of_a_prim(case: Case, play: Player) -> None:
    assert names.node_name(case["inputs"]["primPath"]) == case["expect"]["ros node name"]


@runs("name validation", "rcl rules")
def names_that_rcl_takes_and_refuses(case: Case, play: Player) -> None:
    for kind, check in (("nodes", names.check_node_name), ("ns", names.check_namespace)):
        for name in case["inputs"][f"valid_{kind}"]:
            check(name)
        for name in case["inputs"][f"invalid_{kind}"]:
            with pytest.raises(TopicError):
                check(name)
