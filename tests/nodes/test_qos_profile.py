"""ROS2QoSProfile."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import parse_qos
from graphengine.nodes.ros2.qos_profile import ROS2QoSProfile
from tests.nodes.harness import Player


def profile(**inputs: Any) -> QoS:
    node = ROS2QoSProfile(**inputs)
    node.compute()
    return parse_qos(node.qos_profile)


# isaacsim.ros2.nodes/nodes/OgnROS2QoSProfile.cpp, _applyPreset
@pytest.mark.parametrize(
    ("preset", "expected"),
    [
        ("Default for publishers/subscribers", QoS("keepLast", 10, "reliable", "volatile")),
        ("Services", QoS("keepLast", 10, "reliable", "volatile")),
        ("Sensor Data", QoS("keepLast", 5, "bestEffort", "volatile")),
        ("System Default", QoS("systemDefault", 0, "systemDefault", "systemDefault")),
    ],
)
def test_each_preset_has_the_policies_of_isaac_sim(preset: str, expected: QoS) -> None:
    assert profile(create_profile=preset) == expected


@pytest.mark.parametrize("preset", ["defaultPubSub", "Custom"])
def test_without_a_preset_the_policies_are_the_inputs(preset: str) -> None:
    policies: dict[str, Any] = {"history": "keepAll", "depth": 20, "reliability": "bestEffort", "deadline": 1.5}
    policies |= {"durability": "transientLocal", "lifespan": 2.0, "liveliness": "automatic", "lease_duration": 3.0}
    assert profile(create_profile=preset, **policies) == QoS(**policies)
    assert profile(create_profile=preset) == QoS()


def test_a_policy_that_is_set_overrides_the_preset() -> None:
    expected = QoS("keepLast", 50, "bestEffort", "volatile", deadline=0.5)
    assert profile(create_profile="Sensor Data", depth=50, deadline=0.5) == expected


def test_the_policy_unknown_is_refused() -> None:
    with pytest.raises(ValueError, match="reliability must be a policy that ROS 2 has, it is 'unknown'"):
        ROS2QoSProfile(reliability="unknown").compute()


def test_in_a_graph_publishers_and_subscribers_use_the_profile(play: Player) -> None:
    text = """
        nodes:
          Tick: OnPlaybackTick
          Profile: {type: QoSProfile, inputs: {createProfile: Sensor Data, durability: transientLocal}}
          Clock: PublishClock
          Twist: SubscribeTwist
        connections:
          - Tick.tick -> Clock.execIn
          - Tick.tick -> Twist.execIn
          - Profile.qosProfile -> Clock.qosProfile
          - Profile.qosProfile -> Twist.qosProfile
        """
    claims = play.graph(text).session.services.claims
    assert {claim.qos for claim in claims} == {QoS("keepLast", 5, "bestEffort", "transientLocal")}
