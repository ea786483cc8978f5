"""The tutorial's three stages, each against the tutorial's own list of topics: names, types, frames, stamps.

Every ROS 2 node has /parameter_events and /rosout, so they are left out of the lists here.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.jobs.harness import Job, assemble, nanoseconds, tick_times, yaw

TYPES = {
    "cmd_vel": "geometry_msgs/msg/Twist",
    "platform/joint_states": "sensor_msgs/msg/JointState",
    "odom": "nav_msgs/msg/Odometry",
    "scan": "sensor_msgs/msg/LaserScan",
    "tf": "tf2_msgs/msg/TFMessage",
    "tf_static": "tf2_msgs/msg/TFMessage",
    "clock": "rosgraph_msgs/msg/Clock",
}
"""The tutorial's table of what Nav2 requires, with the full names of the types."""

PLAIN = ["/cmd_vel", "/platform/joint_states", "/odom", "/scan", "/tf", "/tf_static"]
"""`ros2 topic list` after "Building OmniGraph Nodes"."""

NAMESPACED = [
    "/dd100_0000/cmd_vel",
    "/dd100_0000/platform/joint_states",
    "/dd100_0000/odom",
    "/dd100_0000/sim_lidar/scan",
    "/dd100_0000/tf",
    "/dd100_0000/tf_static",
]
"""`ros2 topic list` after "Add Automatic Namespace Attributes"."""

STAGES = {
    "tutorial/flat_grid": PLAIN,
    "tutorial/simple_warehouse": PLAIN,
    "namespaces": NAMESPACED,
    "tutorial/navigation": [*NAMESPACED, "/clock"],
}

SECONDS = 1


@pytest.fixture(params=STAGES)
def stage(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[str | Path, list[str]]:
    """A scene and the topics that it should have. No scene that ships has namespaces and no clock, so one is written."""
    name: str = request.param
    if name != "namespaces":
        return name, STAGES[name]
    scene = "scene: s\nworld: worlds/simple_warehouse.xml\nsettle: true\nrobots:\n  dd100: {use: %s}\n"
    (tmp_path / "scene.yaml").write_text(scene % "robots/tutorial_dd100_namespaces.yaml", encoding="utf-8")
    return tmp_path / "scene.yaml", STAGES[name]


def type_of(topic: str) -> str:
    return next(kind for name, kind in TYPES.items() if topic.endswith(f"/{name}"))


def test_topics_and_types_are_those_of_the_tutorial(stage: tuple[str | Path, list[str]]) -> None:
    scene, topics = stage
    claims = assemble(scene).claims
    assert {(claim.topic, claim.message_type) for claim in claims} == {(topic, type_of(topic)) for topic in topics}
    assert [claim.topic for claim in claims if claim.direction == "subscribe"] == [
        topic for topic in topics if topic.endswith("cmd_vel")
    ]


def test_on_each_topic_the_right_frames_and_stamps_come_out(stage: tuple[str | Path, list[str]]) -> None:
    scene, topics = stage
    with Job(scene) as job:
        job.run(SECONDS)
        assert job.types() == {topic: type_of(topic) for topic in topics if not topic.endswith("cmd_vel")}
        heard = {topic.rpartition("/")[2]: job.heard(topic) for topic in topics if not topic.endswith("cmd_vel")}

    every_tick = tick_times(range(1, 60 * SECONDS + 1), 60)
    assert [nanoseconds(m.header.stamp) for m in heard["odom"]] == every_tick
    assert {(m.header.frame_id, m.child_frame_id) for m in heard["odom"]} == {("odom", "base_link")}

    assert [nanoseconds(m.header.stamp) for m in heard["joint_states"]] == every_tick
    names = ("front_left_wheel_joint", "front_right_wheel_joint")
    assert {tuple(m.name) for m in heard["joint_states"]} == {names}
    assert {len(a) for m in heard["joint_states"] for a in (m.position, m.velocity, m.effort)} == {2}

    moving = [m.transforms for m in heard["tf"]]
    assert [nanoseconds(t.header.stamp) for (t,) in moving] == every_tick
    assert {(t.header.frame_id, t.child_frame_id) for (t,) in moving} == {("odom", "base_link")}

    ((static,),) = [m.transforms for m in heard["tf_static"]]
    assert (static.header.frame_id, static.child_frame_id) == ("chassis_link", "sim_lidar")
    assert nanoseconds(static.header.stamp) == every_tick[0]
    place = static.transform.translation
    assert (place.x, place.y, place.z) == pytest.approx((0.0, 0.0, 0.15), abs=1e-9)

    expected = [tick for tick in range(1, 60 * SECONDS + 1) if tick == 1 or tick % 3 == 0]
    assert [nanoseconds(m.header.stamp) for m in heard["scan"]] == tick_times(expected, 60)
    assert {m.header.frame_id for m in heard["scan"]} == {"sim_lidar"}
    assert {len(m.ranges) for m in heard["scan"]} == {2751}

    if "clock" in heard:
        assert [nanoseconds(m.clock) for m in heard["clock"]] == every_tick


@pytest.mark.parametrize("scene", ["tutorial/flat_grid", "tutorial/navigation"])
def test_the_tutorials_own_command_moves_the_robot(scene: str) -> None:
    """`ros2 topic pub /cmd_vel geometry_msgs/Twist "{'linear': {'x': 1, …}, 'angular': {…, 'z': 1.0}}" --once`."""
    prefix = "/dd100_0000" if scene.endswith("navigation") else ""
    with Job(scene) as job:
        job.say(f"{prefix}/cmd_vel", 1.0, 1.0)
        job.run(2.0)
        pose = job.newest(f"{prefix}/odom").pose.pose
    share_of_v, share_of_w = 0.049 / 0.1, 0.049 / 0.1 * 0.45 / 0.4523232
    assert yaw(pose.orientation) == pytest.approx(2.0 * share_of_w, rel=0.1)  # without a ramp the wheels slip at first
    assert math.hypot(pose.position.x, pose.position.y) == pytest.approx(2.0 * share_of_v, rel=0.1)


def test_odometry_and_tf_begin_at_the_origin_whatever_the_place_in_the_world() -> None:
    with Job("tutorial/navigation") as job:
        job.run(0.1)
        first = job.heard("/dd100_0000/odom")[0].pose.pose
        assert (first.position.x, first.position.y, first.position.z) == (0.0, 0.0, 0.0)
        assert (first.orientation.x, first.orientation.y, first.orientation.z) == pytest.approx((0, 0, 0), abs=1e-12)
        (edge,) = job.heard("/dd100_0000/tf")[0].transforms
        assert (edge.transform.translation.x, edge.transform.translation.y) == (0.0, 0.0)


def test_clock_comes_before_what_it_stamps() -> None:
    with Job("tutorial/navigation") as job:
        job.run(0.1)
        order = [topic for topic, _, _ in job.recorder.stream]
    assert order[0] == "/clock"
    assert order.index("/clock", 1) > order.index("/dd100_0000/odom")
