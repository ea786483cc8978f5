"""Cases of IsaacComputeTransformTree and ROS2PublishTransformTree."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from graphengine.nodes.core.transforms import IsaacComputeTransformTree
from graphengine.nodes.ros2.transforms import ROS2PublishTransformTree
from graphengine.testing import RecordingContext, RecordingWorld
from tests.nodes.harness import Player, computed, ready, yaw
from tests.nodes.isaac.book import Case, at, differs, runs

TREE = "isaacsim.core.nodes.IsaacComputeTransformTree"
PUBLISH_TREE = "isaacsim.ros2.bridge.ROS2PublishTransformTree"


def tree_of(context: RecordingContext, *targets: str, parent: str = "") -> IsaacComputeTransformTree:
    return computed(IsaacComputeTransformTree, context, target_prims=targets, parent_prim=parent)


def translation(node: IsaacComputeTransformTree) -> Any:
    """Of the last child."""
    return node.translations[-1].tolist()


@runs(TREE, "single rigid prim")
def a_single_body(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_body(case["inputs"]["prim"], at(case["inputs"]["pos"]))
    node, expected = tree_of(context, case["inputs"]["prim"]), case["expect"]
    assert list(node.parent_frames) == expected["parentFrames"]
    assert list(node.child_frames) == expected["childFrames"]
    assert node.translations.tolist() == expected["translations"]
    assert node.orientations.tolist() == expected["orientations"]


@runs(TREE, "relative to parentPrim")
def a_body_relative_to_another(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_body("/Parent", at(case["inputs"]["parent"]))
    context.world.add_body("/Child", at(case["inputs"]["child"]))
    assert tree_of(context, "/Child", parent="/Parent").translations.tolist() == case["expect"]["translations"]


def carried(body: Any, sensor: Any, kind: Any = "frame", turn: Any = (0.0, 0.0, 0.0, 1.0)) -> RecordingContext:
    """A body, and a prim on it that physics does not know."""
    context = RecordingContext()
    context.world.add_body("/Body", at(body), turn)
    context.world.stage.add("/Body/Sensor", kind, position=at(sensor))
    return context


@runs(TREE, "rigid body + Xform sensor child, both vs world")
def a_body_and_its_sensor_below_the_world(case: Case, play: Player) -> None:
    context = carried(case["inputs"]["body"], case["inputs"]["sensor_local"])
    assert translation(tree_of(context, "/Body", "/Body/Sensor")) == case["expect"]["sensor translation"]


@runs(TREE, "non-physics parentPrim")
def a_body_below_a_prim_that_physics_does_not_know(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.stage.add("/Parent", "frame", position=at(case["inputs"]["parent"]))
    context.world.add_body("/Body", at(case["inputs"]["body_world"]))
    assert tree_of(context, "/Body", parent="/Parent").translations.tolist() == case["expect"]["translations"]


@runs(TREE, "camera gets 180deg about x")
def a_camera_looks_along_z(case: Case, play: Player) -> None:
    x, _, _, w = tree_of(carried((0, 0, 0), (0, 0, 0), "camera"), "/Body/Sensor").orientations[0]
    assert (abs(x), w) == (case["expect"]["orientation xyzw"]["|x|"], case["expect"]["orientation xyzw"]["w"])


@runs(TREE, "OmniLidar prim: no 180deg rotation")
def a_lidar_does_not_turn(case: Case, play: Player) -> None:
    node = tree_of(carried((0, 0, 0), case["inputs"]["local"], "lidar"), "/Body/Sensor")
    assert node.orientations[0].tolist() == case["expect"]["orientation"]
    assert translation(node)[2] == case["expect"]["z"]


@runs(TREE, "sensor relative to physics parent")
def a_sensor_relative_to_its_body(case: Case, play: Player) -> None:
    context = carried(case["inputs"]["body"], case["inputs"]["sensor_local"])
    assert tree_of(context, "/Body/Sensor", parent="/Body").translations.tolist() == case["expect"]["translations"]


@runs(TREE, "undiscovered physics ancestor")
def a_sensor_whose_body_is_no_target(case: Case, play: Player) -> None:
    context = carried(case["inputs"]["body"], case["inputs"]["sensor_local"])
    assert translation(tree_of(context, "/Body/Sensor")) == case["expect"]["translation"]


@runs(TREE, "isaac:nameOverride honoured for parent and child")
def overrides_name_both_ends(case: Case, play: Player) -> None:
    context = carried((0, 0, 0), (0, 0, 0))
    context.world.stage.find("/Body").name_override = case["inputs"]["parent_override"]
    context.world.stage.find("/Body/Sensor").name_override = case["inputs"]["child_override"]
    node = tree_of(context, "/Body/Sensor", parent="/Body")
    assert list(node.parent_frames) == case["expect"]["parentFrames"]
    assert list(node.child_frames) == case["expect"]["childFrames"]


@runs(TREE, "rotated ancestor")
def a_turned_body_turns_its_sensor(case: Case, play: Player) -> None:
    context = carried((0, 0, 0), case["inputs"]["sensor_local"], turn=yaw(math.radians(case["inputs"]["yaw_deg"])))
    assert translation(tree_of(context, "/Body/Sensor")) == pytest.approx(case["expect"]["translation"], abs=1e-9)


@runs(TREE, "parent rotated 90deg")
def a_turned_parent_turns_what_is_below_it(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_body("/Parent", orientation=yaw(math.radians(case["inputs"]["parent_yaw_deg"])))
    context.world.add_body("/Child", at(case["inputs"]["child_world"]))
    assert translation(tree_of(context, "/Child", parent="/Parent")) == pytest.approx(
        case["expect"]["translation"], abs=1e-9
    )


@runs(TREE, "duplicate nameOverride: deepest wins")
def of_two_that_share_a_name_the_deepest_has_it(case: Case, play: Player) -> None:
    context, paths = RecordingContext(), case["inputs"]["paths"]
    for path in paths:
        context.world.stage.add(path, "frame", name_override=case["inputs"]["override"])
    children = tree_of(context, *paths).child_frames
    assert children.count(case["inputs"]["override"]) == case["expect"]["childFrames count of shared_frame"]
    assert children[-1] == case["inputs"]["override"]


@runs(TREE, "parentPrim reauthored at run time")
def a_parent_that_is_moved_or_replaced_during_play(case: Case, play: Player) -> None:
    given, expect = case["inputs"], case["expect"]
    world = RecordingWorld()
    world.add_body("/Body", at(given["body"]))
    parent = world.add_body("/Parent", at(given["parent_from"]))
    world.add_body("/Other", at(given["parent_to"]))
    playing = play.graph(
        """
        nodes:
          Tick: OnPlaybackTick
          Tree: {type: ComputeTransformTree, inputs: {targetPrims: /Body, parentPrim: /Parent}}
        connections: [Tick.tick -> Tree.execIn]
        """,
        world,
    ).tick()
    assert translation(playing.node("Tree"))[0] == expect["x before"]
    playing.set("Tree", "parent_prim", ("/Other",))
    playing.tick()
    assert translation(playing.node("Tree"))[0] == expect["x after"]
    playing.set("Tree", "parent_prim", ("/Parent",))
    parent.position = at(given["parent_to"])
    playing.tick()
    assert translation(playing.node("Tree"))[0] == expect["x after"]


@differs(TREE, "scaled ancestor scales offset")
def a_sensor_below_a_prim_that_would_be_scaled(case: Case, play: Player) -> Any:
    return translation(tree_of(carried((0, 0, 0), case["inputs"]["sensor_local"]), "/Body/Sensor"))


@differs(TREE, "resetXformStack on middle")
def a_sensor_below_a_prim_that_would_not_move_with_its_parent(case: Case, play: Player) -> Any:
    context = RecordingContext()
    for path, part in (("/outer", "outer"), ("/outer/mid", "mid"), ("/outer/mid/sensor", "sensor")):
        context.world.stage.add(path, "frame", position=at(case["inputs"][part]))
    return translation(tree_of(context, "/outer/mid/sensor"))


@differs(TREE, "camera under 2x scaled mount")
def a_camera_below_a_mount_that_would_be_scaled(case: Case, play: Player) -> Any:
    node = tree_of(carried((0, 0, 0), case["inputs"]["local"], "camera"), "/Body/Sensor")
    return {"z": translation(node)[2], "orientation": node.orientations[0].tolist()}


PANDA = [*(f"panda_link{i}" for i in range(8)), "panda_hand", "panda_leftfinger", "panda_rightfinger"]


def add_panda(world: RecordingWorld, path: str) -> None:
    """Franka's arm: a chain of links, the hand on the last, two fingers on the hand."""
    base = f"{path}/Geometry/{PANDA[0]}"
    world.stage.add(path, "robot", body=base, facts={"base_link": base})
    above = f"{path}/Geometry"
    for link in PANDA:
        made = world.stage.add(f"{above}/{link}", "link", body=f"{above}/{link}")
        above = above if link.endswith("finger") else made.path


@runs(f"{TREE} + ROS2PublishTransformTree", "franka articulation")
def a_robot_gives_all_of_its_links(case: Case, play: Player) -> None:
    world = RecordingWorld()
    add_panda(world, "/panda")
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Tree: {{type: ComputeTransformTree, inputs: {{targetPrims: {json.dumps(case["inputs"]["targetPrims"])}}}}}
          Publish: PublishTransformTree
        connections:
          - Tick.tick -> Tree.execIn
          - Tree.execOut -> Publish.execIn
          - Tree.parentFrames -> Publish.parentFrames
          - Tree.childFrames -> Publish.childFrames
          - Tree.translations -> Publish.translations
          - Tree.orientations -> Publish.orientations
        """,
        world,
    ).tick()
    (message,) = playing.published("/tf")
    assert len(message.transforms) == case["expect"]["number of transforms"]
    assert case["expect"]["some frame_id"] in [t.header.frame_id for t in message.transforms]


@runs(TREE, "IsaacRobotAPI expansion: joint topology parents")
def a_robots_links_hang_on_the_links_that_carry_them(case: Case, play: Player) -> None:
    context = RecordingContext()
    context.world.add_robot("/robot")
    for wheel in ("wheel_left", "wheel_right"):
        context.world.stage.add(f"/robot/Geometry/base_link/{wheel}", "link")
    node = tree_of(context, "/robot", parent=f"/robot/{case['inputs']['parentPrim']}")
    assert [list(pair) for pair in zip(node.parent_frames, node.child_frames, strict=True)] == case["expect"]["pairs"]


def legacy(context: RecordingContext, **inputs: Any) -> Any:
    """Transforms of a node that expands its targets itself."""
    return ready(ROS2PublishTransformTree, context, **inputs).message().transforms


@runs(PUBLISH_TREE, "legacy: parentPrim panda_link0")
def the_first_transform_is_below_the_parent(case: Case, play: Player) -> None:
    context = RecordingContext()
    add_panda(context.world, "/panda")
    first = legacy(context, target_prims="/panda", parent_prim=case["inputs"]["parentPrim"])[0]
    assert first.header.frame_id == case["expect"]["transforms[0].frame_id"]
    assert first.child_frame_id == case["expect"]["transforms[0].child"]


@differs(PUBLISH_TREE, "legacy targetPrims path: franka+cube+Xform child")
def a_target_that_was_already_expanded(case: Case, play: Player) -> Any:
    context = RecordingContext()
    add_panda(context.world, "/panda")
    context.world.add_body("/cube")
    hand = next(prim for prim in context.world.stage.prims("link") if prim.name == "panda_hand")
    context.world.stage.add(f"{hand.path}/geometry", "frame")
    paths = {path: path.replace("/panda/panda_hand", hand.path) for path in case["inputs"]["targetPrims"]}
    transforms = legacy(context, target_prims=list(paths.values()))
    assert len({t.child_frame_id for t in transforms}) == len(transforms)
    return {"transforms": len(transforms), "transforms[12].header.frame_id": transforms[12].header.frame_id}


@differs(PUBLISH_TREE, "legacy: two identical robots")
def frames_of_the_second_robot(case: Case, play: Player) -> Any:
    context = RecordingContext()
    for path in case["inputs"]["targets"]:
        add_panda(context.world, path)
    frames = [t.child_frame_id for t in legacy(context, target_prims=case["inputs"]["targets"])]
    assert frames[:11] == PANDA
    (prefix,) = {frame.removesuffix(link) for frame, link in zip(frames[11:], PANDA, strict=True)}
    return f"{prefix}<link>"
