"""The main job: one process runs the warehouse, another, with packages from PyPI only, reads its topics and drives it."""

from __future__ import annotations

import math
import signal
from collections.abc import Callable, Iterator
from contextlib import closing
from typing import Any

import pytest

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import live
from tests.waiting import eventually

TOPICS = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/dd100_0000/odom": "nav_msgs/msg/Odometry",
    "/dd100_0000/tf": "tf2_msgs/msg/TFMessage",
    "/dd100_0000/tf_static": "tf2_msgs/msg/TFMessage",
    "/dd100_0000/platform/joint_states": "sensor_msgs/msg/JointState",
    "/dd100_0000/sim_lidar/scan": "sensor_msgs/msg/LaserScan",
}


class Listener:
    """A second participant: the newest message of each topic, and a way to drive."""

    def __init__(self, domain_id: int) -> None:
        self.transport = DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), "listener"))
        self.newest: dict[str, Any] = {}
        for topic, message_type in TOPICS.items():
            qos = LATCHED if topic.endswith("tf_static") else QoS()
            self.transport.reader(topic, message_type, qos, self.keep(topic, message_type))
        self.cmd_vel = self.transport.writer("/dd100_0000/cmd_vel", "geometry_msgs/msg/Twist", QoS())

    def keep(self, topic: str, message_type: str) -> Callable[[bytes], None]:
        def deliver(data: bytes) -> None:
            self.newest[topic] = messages.decode(data, message_type)

        return deliver

    def drive(self, v: float, w: float) -> None:
        twist = messages.Twist(messages.Vector3(v, 0.0, 0.0), messages.Vector3(0.0, 0.0, w))
        self.cmd_vel.write(messages.encode(twist))

    def twist(self) -> tuple[float, float]:
        odometry = self.newest.get("/dd100_0000/odom")
        if odometry is None:
            return math.nan, math.nan
        return odometry.twist.twist.linear.x, odometry.twist.twist.angular.z


@pytest.fixture
def listener(domain_id: int) -> Iterator[Listener]:
    made = Listener(domain_id)
    with closing(made.transport):
        yield made


def test_another_process_reads_every_topic_and_drives_the_robot(domain_id: int, listener: Listener) -> None:
    env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with live("run", "dd100_warehouse", "--transport", "dds", "--for", "10min", env=env) as running:
        drive(listener)
        assert running.stop(signal.SIGTERM) == 0, running.said
    assert "ticks" in running.said.splitlines()[-1]


def drive(listener: Listener) -> None:
    """Read every topic, drive and turn, and fall silent."""
    assert eventually(lambda: len(listener.newest) == len(TOPICS)), f"only {sorted(listener.newest)} came"
    names = listener.newest["/dd100_0000/platform/joint_states"].name
    assert names == ["front_left_wheel_joint", "front_right_wheel_joint"]
    scan = listener.newest["/dd100_0000/sim_lidar/scan"]
    assert (len(scan.ranges), scan.header.frame_id) == (2751, "sim_lidar")
    edges = [(t.header.frame_id, t.child_frame_id) for t in listener.newest["/dd100_0000/tf_static"].transforms]
    assert edges == [("base_link", "sim_lidar")]

    reached = eventually(lambda: abs(listener.twist()[0] - 0.5) < 0.0025, lambda: listener.drive(0.5, 0.0))
    assert reached, f"v = {listener.twist()[0]} m/s, 0.5 was commanded"
    reached = eventually(lambda: abs(listener.twist()[1] - 0.5) < 0.0025, lambda: listener.drive(0.0, 0.5))
    assert reached, f"w = {listener.twist()[1]} rad/s, 0.5 was commanded"
    assert eventually(lambda: abs(listener.twist()[1]) < 1e-3), "silence did not stop the robot"
