"""Scenes in which all robots share /tf and /tf_static: names of frames in messages, the tree, and what `check` says of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphengine.format.spec import RobotUse
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.tf_tree import FrameTree
from tests.jobs.harness import Job, assemble

SCENE = """scene: shared
world: worlds/flat_grid.xml
tf: %s
robots:
  bot: {use: robots/dd100.yaml, count: 2, per_row: 2, spacing: [3, 3], position: [0, 0, 0.025]}
"""
TYPE = "tf2_msgs/msg/TFMessage"
ROBOTS = ("bot_0000", "bot_0001")


def scene(folder: Path, tf: str = "global", more: str = "") -> Path:
    path = folder / "scene.yaml"
    path.write_text(SCENE % tf + more, encoding="utf-8")
    return path


PUBLISHED = """graph: frames
at: $(at)/frames
parameters: {at: {type: string}, target: {type: target}, namespace: {type: string, default: ''}}
nodes:
  Tick: OnPlaybackTick
  Context: {type: ROS2Context, inputs: {domain_id: 7}}    # apart from the robots' own transforms
  TF: {type: PublishTransformTree, inputs: {targetPrims: [$(target)], nodeNamespace: $(namespace)}}
connections: [Tick.tick -> TF.execIn, Context.context -> TF.context]
"""
COMPUTED = """graph: frames
at: $(at)/frames
parameters: {at: {type: string}, target: {type: target}, namespace: {type: string, default: ''}}
nodes:
  Tick: OnPlaybackTick
  Context: {type: ROS2Context, inputs: {domain_id: 7}}    # apart from the robots' own transforms
  Tree: {type: ComputeTransformTree, inputs: {targetPrims: [$(target)]}}
  TF: {type: PublishTransformTree, inputs: {nodeNamespace: $(namespace)}}
connections:
  - Tick.tick -> Tree.execIn
  - Context.context -> TF.context
  - Tree.execOut -> TF.execIn
  - Tree.parentFrames -> TF.parentFrames
  - Tree.childFrames -> TF.childFrames
  - Tree.translations -> TF.translations
  - Tree.orientations -> TF.orientations
"""
STATE = """graph: frames
at: $(at)/frames
parameters: {at: {type: string}, target: {type: target}, namespace: {type: string, default: ''}}
nodes:
  Tick: OnPlaybackTick
  Context: {type: ROS2Context, inputs: {domain_id: 7}}    # apart from the robots' own transforms
  State: {type: graphengine.ros2.RobotStatePublisher, inputs: {targetPrim: $(target), nodeNamespace: $(namespace)}}
connections: [Tick.tick -> State.execIn, Context.context -> State.context]
"""
WORLD = """<mujoco><worldbody>
  <geom type="plane" size="5 5 1"/>
  <body name="box" pos="0 3 1"><freejoint/><geom size="0.1"/></body>
</worldbody></mujoco>
"""


def published_by(folder: Path, graph: str, at: str, target: str, namespace: str = "") -> set[tuple[str, str]]:
    """Edges on /tf and /tf_static that a graph adds to those of two robots beside a box, given where and of what prim it is."""
    (folder / "world.xml").write_text(WORLD, encoding="utf-8")
    (folder / "frames.yaml").write_text(graph, encoding="utf-8")
    parameters = f"{{at: {at}, target: {target}, namespace: '{namespace}'}}"
    path = scene(folder, more=f"graphs:\n  frames: {{use: frames.yaml, parameters: {parameters}}}\n")
    path.write_text(path.read_text("utf-8").replace("worlds/flat_grid.xml", "world.xml"), encoding="utf-8")
    claims = assemble(path).claims
    with Job(path) as job:
        job.run(0.1)
        sent = {edge for topic in ("/tf", "/tf_static") for message in job.heard(topic) for edge in frames(message)}
    added = {edge for claim in claims if "/frames/" in claim.node for edge in claim.transforms}
    assert added <= sent
    return added


def frames(message: Any) -> set[tuple[str, str]]:
    return {(one.header.frame_id, one.child_frame_id) for one in message.transforms}


def tree(job: Job, *topics: str) -> FrameTree:
    """The tree of all transforms that were sent on the topics."""
    made = FrameTree()
    for topic in topics:
        for message in job.heard(topic):
            made.add(message, topic.endswith("tf_static"), b"session")
    return made


def test_each_robot_has_one_tree_with_its_namespace_in_all_frames(tmp_path: Path) -> None:
    with Job(scene(tmp_path), robot_state=True) as job:
        job.run(0.2)
        made = tree(job, "/tf", "/tf_static")
        assert made.roots() == [f"{robot}/odom" for robot in ROBOTS]
        assert made.faults({}) == []
        assert {edge.child.partition("/")[0] for edge in made.edges} == set(ROBOTS)
        assert not any(topic.startswith("/bot") and topic.endswith(("tf", "tf_static")) for topic in job.types())


def test_the_trees_are_those_of_the_namespaced_topics_but_for_the_prefix(tmp_path: Path) -> None:
    with Job(scene(tmp_path), robot_state=True) as job:
        job.run(0.2)
        shared = [(edge.parent, edge.child, edge.number) for edge in tree(job, "/tf", "/tf_static").edges]
    with Job(scene(tmp_path, "namespaced"), robot_state=True) as job:
        job.run(0.2)
        apart = [
            (f"{robot}/{edge.parent}", f"{robot}/{edge.child}", edge.number)
            for robot in ROBOTS
            for edge in tree(job, f"/{robot}/tf", f"/{robot}/tf_static").edges
        ]
    assert shared == apart


def test_the_frames_in_messages_are_those_of_the_tree(tmp_path: Path) -> None:
    with Job(scene(tmp_path)) as job:
        job.run(0.2)
        odometry, scan = job.newest("/bot_0001/odom"), job.newest("/bot_0001/sim_lidar/scan")
        joints = job.newest("/bot_0001/platform/joint_states")
        assert (odometry.header.frame_id, odometry.child_frame_id) == ("bot_0001/odom", "bot_0001/base_link")
        assert scan.header.frame_id == "bot_0001/sim_lidar"
        assert joints.header.frame_id == ""
        claims = {claim.topic: claim for claim in job.session.services.claims}
        assert claims["/bot_0001/odom"].child_frame_id == "bot_0001/base_link"


@pytest.mark.parametrize("graph", [PUBLISHED, COMPUTED, STATE])
def test_a_robot_publishes_the_frames_of_another_robot_by_their_own_names(tmp_path: Path, graph: str) -> None:
    made = published_by(tmp_path, graph, "/bot_0000/Geometry/base_link", "/bot_0001")
    assert {child.partition("/")[0] for _, child in made} == {"bot_0001"}
    assert ("bot_0001/base_link", "bot_0001/chassis_link") in made


@pytest.mark.parametrize("graph", [PUBLISHED, COMPUTED, STATE])
def test_a_graph_of_the_scene_publishes_frames_by_the_names_in_the_robots_odometry(tmp_path: Path, graph: str) -> None:
    made = published_by(tmp_path, graph, "/World", "/bot_0000", "fleet")
    assert {child.partition("/")[0] for _, child in made} == {"bot_0000"}
    assert ("bot_0000/base_link", "bot_0000/chassis_link") in made


@pytest.mark.parametrize("graph", [PUBLISHED, COMPUTED])
def test_a_prim_of_the_world_has_the_same_name_in_every_robots_graph(tmp_path: Path, graph: str) -> None:
    assert published_by(tmp_path, graph, "/bot_0000/Geometry/base_link", "/World/box") == {("world", "box")}


def test_the_true_pose_of_a_robot_is_published_below_the_common_map(tmp_path: Path) -> None:
    with Job(scene(tmp_path), localization="truth") as job:
        job.run(0.1)
        edges = [edge for message in job.heard("/tf") for edge in message.transforms]
        truth = {edge.child_frame_id: edge.transform.translation for edge in edges if edge.header.frame_id == "map"}
        state = job.session.services.world.entities.state
        assert truth.keys() == {f"{robot}/odom" for robot in ROBOTS}
        for robot in ROBOTS:
            found = truth[f"{robot}/odom"]
            assert (found.x, found.y) == pytest.approx(state(robot).position[:2], abs=1e-3)


def test_check_finds_nothing_wrong_with_robots_that_share_the_topics(tmp_path: Path) -> None:
    assert assemble(scene(tmp_path), robot_state=True).findings.items == []


def test_pieces_of_one_robot_are_found_among_the_trees_of_all(tmp_path: Path) -> None:
    graph = """graph: loose
at: $(robot)/Geometry/base_link/loose
parameters: {robot: {type: target}}
nodes:
  Tick: OnPlaybackTick
  Context: ROS2Context
  TF: {type: PublishRawTransformTree, inputs: {parentFrameId: shelf, childFrameId: box, timeStamp: 1.0}}
connections: [Tick.tick -> TF.execIn, Context.context -> TF.context]
"""
    (tmp_path / "loose.yaml").write_text(graph, encoding="utf-8")
    use = "graphs:\n  loose: {use: loose.yaml, parameters: {robot: /bot_0001}}\n"
    found = assemble(scene(tmp_path, more=use)).findings.items
    assert [finding.code for finding in found] == ["W203"]
    assert "the TF tree of bot_0001 is in 2 pieces" in found[0].message


def test_robots_without_namespaces_collide_in_the_shared_tree(tmp_path: Path) -> None:
    path = scene(tmp_path)
    robots = "".join(
        f"  {name}: {{use: robots/dd100.yaml, namespace: '', position: [{x}, 0, 0.025]}}\n"
        for name, x in (("a", 0), ("b", 3))
    )
    path.write_text(f"scene: two\nworld: worlds/flat_grid.xml\ntf: global\nrobots:\n{robots}", encoding="utf-8")
    found = [item.message for item in assemble(path, robot_state=True).findings.items if item.code == "G306"]
    nodes = [message.partition(" is published by both ")[2].partition(";")[0] for message in found]
    assert len(nodes) == len(set(nodes)), found  # one finding for each pair of publishers
    assert any("; also: 'rear_caster', " in message for message in found), found


def test_a_late_joiner_gets_the_static_transforms_of_all_robots_and_publishers(tmp_path: Path) -> None:
    with Job(scene(tmp_path), heard=False, robot_state=True) as job:
        job.run(0.2)
        heard: list[bytes] = []
        job.transport.reader("/tf_static", TYPE, QoS(depth=100, durability="transientLocal"), heard.append)
        job.run(0.1)
    edges = [frames(messages.decode(data, TYPE)) for data in heard]
    assert len(edges) == 4
    assert {child for edge in edges for _, child in edge} >= {
        f"{robot}/{name}" for robot in ROBOTS for name in ("sim_lidar", "chassis_link")
    }


def test_a_robot_that_is_spawned_gets_its_prefix(tmp_path: Path) -> None:
    with Job(scene(tmp_path)) as job:
        job.run(0.1)
        job.spawn("late", RobotUse(use="robots/dd100.yaml", position=(0.0, 5.0, 0.025), namespace="late"))
        job.run(0.1)
        assert ("late/odom", "late/base_link") in {edge for message in job.heard("/tf") for edge in frames(message)}


@pytest.mark.parametrize(
    ("frame", "published"), [("/dock", "dock"), ("map", "map"), ("bot_0000/odom", "bot_0000/odom")]
)
def test_a_graph_decides_by_the_name_what_is_not_prefixed(tmp_path: Path, frame: str, published: str) -> None:
    with Job(scene(tmp_path), {"bot_0000/joint_states/PublishRawTF.parentFrameId": frame}) as job:
        job.run(0.1)
        assert (published, "bot_0000/base_link") in frames(job.heard("/tf")[0])


def test_a_subscriber_of_transforms_knows_the_prefixed_names(tmp_path: Path) -> None:
    graph = """graph: follow
at: $(robot)/Geometry/base_link/follow
parameters: {robot: {type: target}}
nodes:
  Tick: OnPlaybackTick
  Follow: {type: SubscribeTransformTree, inputs: {frameNamesMap: [/physicsScene, world, $(robot), body]}}
connections: [Tick.tick -> Follow.execIn]
"""
    (tmp_path / "follow.yaml").write_text(graph, encoding="utf-8")
    use = "graphs:\n  follow: {use: follow.yaml, parameters: {robot: /bot_0001}}\n"
    with Job(scene(tmp_path, more=use)) as job:
        job.run(0.1)
        pose = messages.Transform(messages.Vector3(2.0, 7.0, 0.1), messages.Quaternion(0.0, 0.0, 0.0, 1.0))
        edge = messages.TransformStamped(messages.header(0.0, "world"), "bot_0001/body", pose)
        job.transport.inject("/tf", messages.TFMessage([edge]))
        job.run(0.1)
        world = job.session.services.world
        (x, y, _), _ = world.frame(world.stage.find("/bot_0001")).pose()
    assert (x, y) == pytest.approx((2.0, 7.0), abs=1e-6)
