"""A running scene and peers that do not fit: told on the terminal, once each, and the run goes on."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import closing

import pytest

from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import live


@pytest.fixture
def environment(domain_id: int) -> dict[str, str]:
    return {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


@pytest.fixture
def rviz(environment: dict[str, str]) -> Iterator[DdsTransport]:
    with closing(DdsTransport(JoinOptions(Domain.from_environment(environment), "rviz"))) as transport:
        yield transport


def test_a_run_tells_who_asks_for_what_it_does_not_offer(environment: dict[str, str], rviz: DdsTransport) -> None:
    with live("run", "dd100_flat", "--transport", "dds", env=environment) as run:
        assert run.hear(lambda said: " Hz, " in said), run.said
        for _ in range(2):
            rviz.reader(
                "/dd100_0000/odom", "nav_msgs/msg/Odometry", QoS(durability="transientLocal"), lambda data: None
            )
        rviz.writer("/dd100_0000/cmd_vel", "geometry_msgs/msg/Twist", QoS(reliability="bestEffort"))
        publisher = "/dd100/Geometry/base_link/chassis_link/joint_states/PublishOdom"
        told = f"/dd100_0000/odom: /rviz asks for transientLocal, {publisher} offers volatile: no messages arrive"
        assert run.hear(lambda said: told in said), run.said
        subscriber = "/dd100/Geometry/base_link/chassis_link/cmd_vel/SubscribeTwist"
        assert run.hear(lambda said: f"{subscriber} asks for reliable, /rviz offers bestEffort" in said), run.said
        assert run.stop(signal.SIGINT) == 0
        assert run.said.count(told) == 1


def test_two_runs_in_one_domain_tell_of_each_others_clock(environment: dict[str, str]) -> None:
    told = "/clock: another process named /dd100_flat also publishes this topic"
    with live("run", "dd100_flat", "--transport", "dds", env=environment) as one:
        assert one.hear(lambda said: " Hz, " in said), one.said
        with live("run", "dd100_flat", "--transport", "dds", env=environment) as other:
            assert one.hear(lambda said: told in said), one.said
            assert other.hear(lambda said: told in said), other.said
            assert other.stop(signal.SIGINT) == 0
        assert one.stop(signal.SIGINT) == 0
        assert one.said.count(told) == 1
