"""The names under which frames are published, where robots share the topics of TF and where they do not."""

from __future__ import annotations

import pytest

from graphengine.devices.stage import Stage
from graphengine.node.context.frame_names import frame_prefix, full_frame
from graphengine.testing.recording_context import RecordingContext


def stage(*, shared: bool = True) -> Stage:
    """A stage with a namespaced robot and a namespaced sensor on it."""
    made = Stage()
    made.global_tf = shared
    made.define("/bot/base_link").namespace = "bot_0000"
    made.define("/bot/base_link/lidar").namespace = "lidar"
    return made


@pytest.mark.parametrize(
    ("given", "published"),
    [
        ("base_link", "bot_0000/base_link"),
        ("odom", "bot_0000/odom"),
        ("bot_0000/base_link", "bot_0000/base_link"),
        ("/base_link", "base_link"),
        ("/fleet/dock", "fleet/dock"),
        ("map", "map"),
        ("world", "world"),
        ("earth", "earth"),
        ("", ""),
    ],
)
def test_a_frame_gets_the_prefix_unless_it_has_one_is_absolute_or_shared(given: str, published: str) -> None:
    made = stage()
    assert full_frame(made, given, frame_prefix(made, "/bot/base_link")) == published
    assert full_frame(stage(shared=False), given, "") == given


def test_the_prefix_is_the_outermost_namespace() -> None:
    assert frame_prefix(stage(), "/bot/base_link/lidar/graph/node") == "bot_0000/"


def test_without_a_namespace_of_prims_the_prefix_is_that_of_the_node() -> None:
    made = stage()
    assert frame_prefix(made, "/World/graph/node", "/fleet/one/") == "fleet/one/"
    assert frame_prefix(made, "/bot/base_link", "other") == "bot_0000/"
    assert frame_prefix(made, "/World/graph/node") == ""


def test_nothing_is_prefixed_where_each_robot_has_its_own_topics() -> None:
    assert frame_prefix(stage(shared=False), "/bot/base_link", "other") == ""


def test_a_copy_of_a_stage_names_frames_like_the_original() -> None:
    assert frame_prefix(stage().copy(), "/bot/base_link") == "bot_0000/"


def test_a_publishers_claim_has_the_published_names() -> None:
    context = RecordingContext("/bot/base_link/graph/node")
    context.world.stage.global_tf = True
    context.world.stage.define("/bot/base_link").namespace = "bot_0000"
    publisher = context.publisher(
        "tf2_msgs/msg/TFMessage",
        "tf",
        outermost_namespace=True,
        frame_id="odom",
        child_frame_id="base_link",
        transforms=[("map", "odom")],
    )
    claim = publisher.claim
    assert claim.topic == "/tf"
    assert (claim.frame_id, claim.child_frame_id) == ("bot_0000/odom", "bot_0000/base_link")
    assert claim.transforms == (("map", "bot_0000/odom"),)
