"""Many robots in one session."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graphengine.messages.endpoints import QoS
from tests.jobs.crowd import FIRST, OTHERS, scene
from tests.jobs.harness import Job


def test_ten_robots_have_their_own_topics_and_one_clock() -> None:
    with Job("dd100_fleet") as job:
        job.run(0.1)
        topics = set(job.types())
    own = {"odom", "platform/joint_states", "sim_lidar/scan", "tf", "tf_static"}
    assert topics == {"/clock"} | {f"/dd100_{index:04}/{name}" for index in range(10) for name in own}


def test_each_robot_of_a_fleet_follows_its_own_commands() -> None:
    with Job("dd100_fleet") as job:
        for _ in range(60):
            job.say("/dd100_0003/cmd_vel", 0.5, 0.0)
            job.session.step()
        moved = [job.newest(f"/dd100_{index:04}/odom").pose.pose.position.x for index in range(10)]
    assert moved[3] == pytest.approx(
        0.5 - 0.5**2 / 2, rel=0.03
    )  # a second, of which it speeds up for a half, at 1 m/s2
    assert np.delete(moved, 3) == pytest.approx(np.zeros(9), abs=1e-6)


def test_what_a_robot_does_does_not_depend_on_who_else_is_there(tmp_path: Path) -> None:
    forever = {"SubscribeTwist.timeout": 0.0}
    heard: dict[bool, dict[str, list[bytes]]] = {}
    for alone in (True, False):
        said: dict[str, list[bytes]] = {"nav_msgs/msg/Odometry": [], "sensor_msgs/msg/LaserScan": []}
        with Job(scene(tmp_path, FIRST, *([] if alone else [OTHERS])), forever, heard=False) as job:
            job.say("/one/cmd_vel", 0.6, 0.3)
            for index in range(0 if alone else 9):
                job.say(f"/other_{index:04}/cmd_vel", 0.2 * (index - 4), 0.1 * index)
            job.run(59.0)
            job.transport.reader("/one/odom", "nav_msgs/msg/Odometry", QoS(), said["nav_msgs/msg/Odometry"].append)
            job.transport.reader(
                "/one/sim_lidar/scan", "sensor_msgs/msg/LaserScan", QoS(), said["sensor_msgs/msg/LaserScan"].append
            )
            job.run(1.0)
        heard[alone] = said
    assert [len(said) for said in heard[True].values()] == [60, 20]
    assert heard[True] == heard[False]  # to the last bit, and the noise of the lidar is the same
