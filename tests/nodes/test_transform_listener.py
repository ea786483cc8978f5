"""ROS2SubscribeTransformTree: prims that go where TF says."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from graphengine.devices.dry_world import BodyStub
from graphengine.devices.rotation import Quaternion, Vector3, compose
from graphengine.format.errors import ContextError, PrimError
from graphengine.messages import messages
from graphengine.nodes.core.transforms import IsaacReadWorldPose
from graphengine.nodes.ros2.service_prim import ROS2ServicePrim
from graphengine.nodes.ros2.transform_listener import ROS2SubscribeTransformTree
from graphengine.nodes.ros2.transforms import ROS2PublishTransformTree
from graphengine.testing import RecordingContext
from tests.nodes import scenes
from tests.nodes.harness import Player, ready, yaw

IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)


def edge(parent: str, child: str, position: Vector3 = (0.0, 0.0, 0.0), orientation: Quaternion = IDENTITY) -> Any:
    transform = messages.Transform(messages.Vector3(*position), messages.Quaternion(*orientation))
    return messages.TransformStamped(messages.header(7.0, parent), child, transform)


class Bench:
    """A box and a mount, which is told where it is by TF."""

    def __init__(self, **inputs: Any) -> None:
        self.context = RecordingContext()
        world = self.context.world
        self.box: BodyStub = world.add_body("/World/box", (0.0, 0.0, 5.0))
        self.cart: BodyStub = world.add_body("/World/cart", (1.0, 0.0, 0.0), yaw(math.pi / 2))
        world.stage.add("/World/box/mark", "frame", position=(0.0, 0.0, 1.0))
        names = ["/World", "world", "/World/box", "box", "/World/cart", "cart", "/World/box/mark", "mark"]
        self.node = ready(ROS2SubscribeTransformTree, self.context, **{"frame_names_map": names, **inputs})

    def hear(self, *arriving: list[Any]) -> int | None:
        for edges in arriving:
            self.context.transport.inject("/tf", messages.TFMessage(edges))
        self.context.tick()
        return self.node.compute()


def near(found: tuple[Vector3, Quaternion], position: Vector3, orientation: Quaternion) -> bool:
    return np.allclose(found[0], position, atol=1e-9) and abs(np.dot(found[1], orientation)) > 1.0 - 1e-9


# isaacsim.ros2.nodes/python/tests/test_subscribers.py, test_transform_tree_subscriber
def test_a_prim_moves_to_the_pose_of_each_message() -> None:
    bench = Bench()
    for step in range(10):
        a = math.sin(step / 2) / math.sqrt(3)
        place, turn = (step / 5, step * step / 25, 1.0), (a, a, a, math.cos(step / 2))
        assert bench.hear([edge("world", "box", place, turn)]) == bench.node.exec_out
        assert near(bench.box.pose(), place, turn)
        assert bench.hear() is None
        assert near(bench.box.pose(), place, turn)


def test_a_pose_is_relative_to_the_current_pose_of_the_parent() -> None:
    bench = Bench()
    bench.hear([edge("cart", "box", (2.0, 0.0, 0.0), yaw(0.5))])
    assert near(bench.box.pose(), (1.0, 2.0, 0.0), yaw(math.pi / 2 + 0.5))
    bench.hear([edge("world", "cart", (0.0, 0.0, 3.0)), edge("cart", "box", (2.0, 0.0, 0.0))])
    assert near(bench.box.pose(), (2.0, 0.0, 3.0), IDENTITY)


def test_the_newest_transform_of_each_child_in_a_tick_is_used_and_the_node_fires_once() -> None:
    bench = Bench()
    cart, box = [edge("world", "cart", (float(x), 0.0, 0.0)) for x in (4, 5)], edge("cart", "box", (1.0, 2.0, 3.0))
    others = [edge("odom", "box", (9.0, 0.0, 0.0)), edge("world", "cart_2")]
    assert bench.hear([cart[0]], [edge("cart", "box"), box], [*others, cart[1]]) == bench.node.exec_out
    assert near(bench.cart.pose(), (5.0, 0.0, 0.0), IDENTITY)
    assert near(bench.box.pose(), (6.0, 2.0, 3.0), IDENTITY)


def test_transforms_of_frames_outside_the_map_are_ignored() -> None:
    bench = Bench()
    assert bench.hear([edge("odom", "box"), edge("world", "base_link")]) == bench.node.exec_out
    assert bench.box.pose()[0] == (0.0, 0.0, 5.0)
    assert bench.context.logged == []


def test_a_fixed_prim_does_not_move_and_a_warning_is_logged() -> None:
    bench = Bench()
    bench.hear([edge("world", "mark")])
    assert bench.context.logged == [
        ("warning", "/tf: mark is the frame of /World/box/mark, which cannot be moved by itself")
    ]


@pytest.mark.parametrize(
    "bad",
    [
        edge("world", "box", (math.nan, 0.0, 0.0)),
        edge("world", "box", (0.0, math.nan, 0.0)),
        edge("world", "box", (0.0, 0.0, -math.inf)),
        edge("world", "box", (0.0, 1e200, 0.0)),
        edge("world", "box", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
        edge("world", "box", (0.0, 0.0, 0.0), (0.0, 1e300, 0.0, 1.0)),
        edge("world", "box", (0.0, 0.0, 0.0), (0.0, math.nan, 0.0, 1.0)),
        edge("world", "box", (0.0, 0.0, 0.0), (0.0, 0.0, 0.2, 1.0)),
        edge("box", "box", (1.0, 0.0, 0.0)),
    ],
)
def test_an_invalid_transform_is_dropped_and_logged_and_the_others_are_used(bad: Any) -> None:
    bench = Bench()
    assert bench.hear([bad, edge("world", "cart", (4.0, 0.0, 0.0))]) == bench.node.exec_out
    assert bench.box.pose()[0] == (0.0, 0.0, 5.0)
    assert bench.cart.pose()[0] == (4.0, 0.0, 0.0)
    told = f"/tf: an invalid transform from {bad.header.frame_id} to box was dropped"
    assert bench.context.logged == [("warning", told)]


def test_transforms_between_two_frames_in_both_directions_keep_the_prims_within_the_world() -> None:
    bench = Bench()
    for _ in range(30):
        bench.hear([edge("box", "cart", (9e8, 0.0, 0.0)), edge("cart", "box", (9e8, 0.0, 0.0))])
    assert max(abs(x) for body in (bench.box, bench.cart) for x in body.pose()[0]) <= 1e9


def test_a_quaternion_of_almost_length_1_is_normalized() -> None:
    bench = Bench()
    bench.hear([edge("world", "box", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.004))])
    assert bench.box.pose()[1] == (0.0, 0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("inputs", "fault"),
    [
        (
            {"frame_names_map": ["/World/box"]},
            "frameNamesMap has 1 strings, but it must be pairs of a prim path and a frame name",
        ),
        ({"frame_names_map": ["/World", "a", "/World", "b"]}, "'/World' is in frameNamesMap twice"),
        ({"frame_names_map": ["/World", "a", "/World/box", "a"]}, "'a' is in frameNamesMap twice"),
        ({"frame_names_map": ["/World/bax", "a"]}, "no prim at '/World/bax'"),
        (
            {"articulation_roots": ["/World/box"]},
            "'/World/box' is not the root prim, base link or articulation root of a robot",
        ),
    ],
)
def test_an_invalid_map_is_refused_in_setup(inputs: dict[str, Any], fault: str) -> None:
    with pytest.raises((ContextError, PrimError), match=fault):
        Bench(**inputs)


def test_only_the_outermost_namespace_is_used() -> None:
    context = RecordingContext("/robot/arm/graph/Subscribe")
    context.world.add_robot("/robot")
    context.world.stage.find("/robot").namespace = "outer"
    context.world.stage.add("/robot/arm", "frame", namespace="inner")
    ready(ROS2SubscribeTransformTree, context, frame_names_map=["/robot", "base_link"])
    assert [claim.topic for claim in context.services.claims] == ["/outer/tf"]


# With physics


def test_a_box_moved_into_the_air_stays_there_until_a_stop(play: Player) -> None:
    files = scenes.cube_on_the_floor(5.0)
    files["graph.yaml"] = """
        graph: graph
        nodes:
          Tick: OnPlaybackTick
          Listen: {type: SubscribeTransformTree, inputs: {frameNamesMap: [/World, world, /World/cube, cube]}}
        connections: [Tick.tick -> Listen.execIn]
        """
    playing = play.scene(files)
    world = playing.session.services.world
    cube = world.frame(world.stage.find("/World/cube"))
    playing.tick(6)
    falling = cube.pose()
    playing.transport.inject("/tf", messages.TFMessage([edge("world", "cube", (1.0, 2.0, 3.0), yaw(0.5))]))
    for _ in range(60):
        playing.tick()
        assert near(cube.pose(), (1.0, 2.0, 3.0), yaw(0.5))
    playing.session.stop()
    playing.tick(6)
    assert cube.pose() == falling


def test_a_robot_follows_another_by_its_tf(play: Player) -> None:
    joints = ["FirstJoint", "PrismaticJoint", "LastJoint"]
    files = scenes.arm(joints, 1e3, 1e2, positionCommand=[1.0, 0.25, -0.5])
    corner = (0.0, 5.0, 0.5)
    files["world.xml"] = scenes.FLOOR.format(body='<body name="corner" pos="0 5 0.5"/>')
    files["scene.yaml"] = files["scene.yaml"].replace(
        "graphs:", "  twin: {use: robot.yaml, position: [9, 9, 2]}\n    graphs:", 1
    )
    links = ["base_link", "base_link/link0", "base_link/link0/link1", "base_link/link0/link1/link2"]
    pairs = ["/World/corner", "world"]
    for link in links:
        pairs += [f"/twin/Geometry/{link}", link.rpartition("/")[2]]
    files["graph.yaml"] = f"""
        graph: graph
        nodes:
          Tick: OnPlaybackTick
          Control: {{type: ArticulationController, inputs: {{targetPrim: /robot, positionCommand: [1.0, 0.25, -0.5]}}}}
          Publish: {{type: PublishTransformTree, inputs: {{targetPrims: /robot}}}}
          Listen: {{type: SubscribeTransformTree, inputs: {{frameNamesMap: {json.dumps(pairs)}}}}}
        connections: [Tick.tick -> Control.execIn, Tick.tick -> Publish.execIn, Tick.tick -> Listen.execIn]
        """
    playing = play.scene(files)
    world = playing.session.services.world

    def pose(robot: str, link: str) -> tuple[Vector3, Quaternion]:
        return world.frame(world.stage.find(f"/{robot}/Geometry/{link}")).pose()

    playing.tick()
    for _ in range(30):
        before = {link: pose("robot", link) for link in links}
        playing.tick()  # in which the twin hears of the tick before
        for link in links:
            assert near(pose("twin", link), *compose((corner, IDENTITY), before[link])), link
    assert abs(pose("robot", links[-1])[1][2]) > 0.1


def test_a_reader_in_the_same_pass_gets_the_changed_pose() -> None:
    def made(cls: Any, **inputs: Any) -> Any:
        return cls(**inputs)

    told = made(ROS2SubscribeTransformTree, frame_names_map=["/World/box", "box", "/World/cart", "cart"])
    for writer, path, touched in (
        (told, "/World/box", True),
        (told, "/dd100/base_link", False),
        (made(ROS2SubscribeTransformTree), "/World/box", True),
        (made(ROS2ServicePrim), "/World/box", True),
    ):
        for reader in (made(IsaacReadWorldPose, prim=[path]), made(ROS2PublishTransformTree, target_prims=[path])):
            assert bool(set(writer.writes()) & set(reader.reads())) == touched
    assert set(told.writes()) & set(made(IsaacReadWorldPose).reads())
