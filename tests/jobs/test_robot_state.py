"""`--robot-state`: one tree of frames, without a robot_state_publisher beside it."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from graphengine.messages.endpoints import QoS
from tests.jobs.harness import ROOT, Job, assemble

SCENES = ["dd100_warehouse", "dd100_flat", "tutorial/flat_grid", "tutorial/simple_warehouse", "tutorial/navigation"]
URDF = ElementTree.parse(ROOT / "scenes/robots/dd100/dd100.urdf").getroot()
AS_TF2_DOES = QoS(depth=100, durability="transientLocal")
LINKS = {link.get("name") for link in URDF.findall("link")}


def prefix_of(scene: str) -> str:
    return "" if scene in ("tutorial/flat_grid", "tutorial/simple_warehouse") else "/dd100_0000"


def test_the_robot_has_15_links() -> None:
    assert len(LINKS) == 15


@pytest.mark.parametrize("scene", SCENES)
def test_the_description_that_is_published_is_the_urdf(scene: str) -> None:
    with Job(scene, robot_state=True) as job:
        job.run(0.1)
        (message,) = job.heard(f"{prefix_of(scene)}/robot_description")
    told = ElementTree.fromstring(message.data)
    assert {link.get("name") for link in told.findall("link")} == LINKS
    ours = {joint.get("name"): joint.get("type") for joint in told.findall("joint")}
    assert ours.keys() == {joint.get("name") for joint in URDF.findall("joint")}


def test_who_comes_late_still_gets_description_and_fixed_transforms() -> None:
    with Job("dd100_warehouse", robot_state=True, heard=False) as job:
        job.run(2.0)
        for topic, message_type in (
            ("/dd100_0000/robot_description", "std_msgs/msg/String"),
            ("/dd100_0000/tf_static", "tf2_msgs/msg/TFMessage"),
        ):
            latched: list[bytes] = []
            job.transport.reader(topic, message_type, AS_TF2_DOES, latched.append)
            assert latched == job.transport.raw(topic)
            assert len(latched) == (2 if topic.endswith("tf_static") else 1)
            volatile: list[bytes] = []
            job.transport.reader(topic, message_type, QoS(), volatile.append)
            assert volatile == []


@pytest.mark.parametrize("scene", SCENES)
def test_tf_and_tf_static_are_one_tree_below_odom_with_every_link(scene: str) -> None:
    with Job(scene, robot_state=True) as job:
        job.run(1.0)
        prefix = prefix_of(scene)
        edges = {
            (edge.child_frame_id, edge.header.frame_id)
            for topic in ("tf", "tf_static")
            for message in job.heard(f"{prefix}/{topic}")
            for edge in message.transforms
        }
    parents = dict(edges)
    assert len(parents) == len(edges), "a frame has two parents"
    assert LINKS | {"sim_lidar"} == parents.keys()
    for frame in parents:
        seen = [frame]
        while seen[-1] in parents:
            seen.append(parents[seen[-1]])
            assert len(seen) <= len(parents) + 1, f"a loop: {seen}"
        assert seen[-1] == "odom"


@pytest.mark.parametrize("scene", ["tutorial/flat_grid", "tutorial/navigation"])
def test_the_lint_of_a_tree_in_pieces_is_gone_with_it(scene: str) -> None:
    without, joined = assemble(scene).findings, assemble(scene, robot_state=True).findings
    assert [finding.code for finding in without.warnings if finding.code == "W203"] == ["W203"]
    assert [finding.code for finding in joined.items if finding.code in ("W203", "G306")] == []
    assert joined.errors == []


@pytest.mark.parametrize("scene", ["dd100_flat", "dd100_warehouse"])
def test_where_one_should_start_from_the_tree_is_whole_either_way(scene: str) -> None:
    for robot_state in (False, True):
        assert assemble(scene, robot_state=robot_state).findings.warnings == []


def test_wheels_turn_in_tf_as_in_the_joint_states() -> None:
    import math

    with Job("dd100_flat", robot_state=True) as job:
        job.drive("/dd100_0000/cmd_vel", 0.3, 0.0, 1.5)
        state = job.newest("/dd100_0000/platform/joint_states")
        edges = [
            e for m in job.heard("/dd100_0000/tf") for e in m.transforms if e.child_frame_id == "front_left_wheel_link"
        ]
        spokes = [e for e in edges if e.header.stamp == state.header.stamp]
    assert len(spokes) == 1
    rotation = spokes[0].transform.rotation
    axle = next(joint for joint in URDF.findall("joint") if joint.get("name") == "front_left_wheel_joint")
    assert axle.find("axis").get("xyz").split()[1].startswith("1")  # type: ignore[union-attr]
    turned = 2.0 * math.atan2(rotation.y, rotation.w)
    angle = state.position[list(state.name).index("front_left_wheel_joint")]
    assert math.remainder(turned - angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-3)


def test_a_scene_may_ask_for_it_itself(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(
        "scene: s\nworld: worlds/flat_grid.xml\nrobots:\n  dd100: {use: robots/dd100.yaml, robot_state: true}\n",
        encoding="utf-8",
    )
    topics = {claim.topic for claim in assemble(tmp_path / "scene.yaml").claims}
    assert "/dd100_0000/robot_description" in topics
