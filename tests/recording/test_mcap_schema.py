"""Ticks as nanoseconds, and profiles as rosbag2 writes them."""

from __future__ import annotations

from fractions import Fraction

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from graphengine.recording.mcap_schema import DEFAULT_QOS, Stream, TickTimes, failure_of, offered_qos

INFINITE = {"sec": 9223372036, "nsec": 854775807}


@given(st.integers(0, 10**12), st.integers(1, 1000), st.integers(1, 10_000))
def test_a_ticks_time_converts_back_to_the_tick(tick: int, numerator: int, denominator: int) -> None:
    times = TickTimes((numerator, denominator))
    exact = Fraction(tick * numerator, denominator) * 10**9
    assert 0 <= exact - times.nanoseconds(tick) < 1
    assert times.tick(times.nanoseconds(tick)) == tick


def test_a_profile_is_yaml_with_the_numbers_of_rmw() -> None:
    assert yaml.safe_load(offered_qos(DEFAULT_QOS)) == [
        {
            "history": 1,
            "depth": 10,
            "reliability": 1,
            "durability": 2,
            "deadline": INFINITE,
            "lifespan": INFINITE,
            "liveliness": 1,
            "liveliness_lease_duration": INFINITE,
            "avoid_ros_namespace_conventions": False,
        }
    ]


@pytest.mark.parametrize(
    ("qos", "expected"),
    [
        (LATCHED, {"durability": 1, "depth": 1}),
        (QoS(reliability="bestEffort", history="keepAll"), {"reliability": 2, "history": 2}),
        (QoS(liveliness="manualByTopic", lease_duration=0.5), {"liveliness": 3}),
        (QoS(deadline=1.25), {"deadline": {"sec": 1, "nsec": 250_000_000}}),
        (QoS(lifespan=1e300), {"lifespan": INFINITE}),
        (QoS("systemDefault", 0, "systemDefault", "systemDefault"), {"history": 1, "reliability": 1, "durability": 2}),
    ],
)
def test_every_policy_has_its_number(qos: QoS, expected: dict[str, object]) -> None:
    (found,) = yaml.safe_load(offered_qos(qos))
    assert {key: found[key] for key in expected} == expected


@pytest.mark.parametrize("known", [False, True])
def test_a_streams_channel_converts_back_to_the_stream(known: bool) -> None:
    stream = Stream("/a", "std_msgs/msg/String", QoS(), known)
    found = Stream.of_channel(stream.channel, stream.message_type, stream.metadata())
    assert found is not None
    assert (found.topic, found.message_type, found.known) == ("/a", "std_msgs/msg/String", known)


def test_the_channel_of_known_messages_is_hidden_in_ros() -> None:
    assert Stream("/a", "std_msgs/msg/String").channel == "/a"
    assert Stream("/a", "std_msgs/msg/String", known=True).channel == "/_graphengine/delivered/a"


def test_a_channel_of_another_program_has_no_stream() -> None:
    assert Stream.of_channel("/a", "std_msgs/msg/String", {"offered_qos_profiles": ""}) is None


def test_the_failure_of_a_run_has_no_file_position() -> None:
    error = RuntimeError("/home/alice/drive.yaml:12:3: node Sum raised ValueError: 1:2:3: no\n  at tick 7")
    assert failure_of(error) == "node Sum raised ValueError: 1:2:3: no"
