"""The names under which frames are published, where robots share the topics of TF and where they do not."""

from __future__ import annotations

import pytest

from graphengine.devices.stage import Stage
from graphengine.node.context.frame_names import PublishedFrame, frame_prefix, full_frame, prim_prefix
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


def test_without_a_namespace_of_prims_the_prefix_is_the_namespace_of_the_node() -> None:
    made = stage()
    assert frame_prefix(made, "/World/graph/node", "/fleet/one/") == "fleet/one/"
    assert frame_prefix(made, "/bot/base_link", "other") == "bot_0000/"
    assert frame_prefix(made, "/World/graph/node") == ""


def test_frames_have_no_prefix_if_each_robot_has_its_own_topics() -> None:
    assert frame_prefix(stage(shared=False), "/bot/base_link", "other") == ""


@pytest.mark.parametrize("name", ["base_link", "/dock", "map", "", "bot_0000/odom"])
@pytest.mark.parametrize("shared", [True, False])
def test_a_published_name_gets_no_second_prefix(name: str, shared: bool) -> None:
    made = stage(shared=shared)
    published = full_frame(made, name, frame_prefix(made, "/bot/base_link"))
    assert full_frame(made, published, "other/") == published


def test_a_link_above_the_base_link_has_the_prefix_of_the_robot() -> None:
    made = stage()
    made.add("/bot", "robot", facts={"base_link": "/bot/base_link"})
    footprint, crate = made.add("/bot/footprint", "link"), made.add("/World/crate", "body")
    assert (prim_prefix(made, footprint), prim_prefix(made, crate)) == ("bot_0000/", "")


def test_a_copy_of_a_stage_names_frames_like_the_original() -> None:
    assert frame_prefix(stage().copy(), "/bot/base_link") == "bot_0000/"


def test_a_publishers_claim_has_the_published_names() -> None:
    context = RecordingContext("/bot/base_link/graph/node")
    context.world.stage.global_tf = True
    context.world.stage.define("/bot/base_link").namespace = "bot_0000"
    other = full_frame(context.world.stage, "base_link", "bot_0001/")
    publisher = context.publisher(
        "tf2_msgs/msg/TFMessage",
        "tf",
        outermost_namespace=True,
        frame_id="odom",
        child_frame_id="base_link",
        transforms=[("map", "odom"), (PublishedFrame("box"), other)],
    )
    claim = publisher.claim
    assert claim.topic == "/tf"
    assert (claim.frame_id, claim.child_frame_id) == ("bot_0000/odom", "bot_0000/base_link")
    assert claim.transforms == (("map", "bot_0000/odom"), ("box", "bot_0001/base_link"))
    assert {type(frame) for edge in claim.transforms for frame in edge} == {str}
