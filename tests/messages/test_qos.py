from __future__ import annotations

import contextlib
import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.errors import TopicError
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED, PRESETS, mismatch, parse_qos, policy_json, qos_json, settled, short_of

DEFAULT = {
    "history": "keepLast",
    "depth": 10,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": 0.0,
    "lifespan": 0.0,
    "liveliness": "systemDefault",
    "leaseDuration": 0.0,
}
SYSTEM_DEFAULT = DEFAULT | dict.fromkeys(("history", "reliability", "durability"), "systemDefault") | {"depth": 0}
OTHERS = "keepAll", 20, "bestEffort", "transientLocal", 1.5, 2.0, "automatic", 3.0
CUSTOM = dict(zip(DEFAULT, OTHERS, strict=True))


# The table "QoS compatibilities" of the ROS 2 documentation.
TABLE = [
    (QoS(), QoS(), True),
    (QoS(reliability="reliable"), QoS(reliability="bestEffort"), True),
    (QoS(reliability="bestEffort"), QoS(reliability="bestEffort"), True),
    (QoS(reliability="bestEffort"), QoS(reliability="reliable"), False),
    (QoS(durability="transientLocal"), QoS(durability="transientLocal"), True),
    (QoS(durability="transientLocal"), QoS(durability="volatile"), True),
    (QoS(durability="volatile"), QoS(durability="transientLocal"), False),
    (QoS(deadline=1.0), QoS(), True),
    (QoS(deadline=1.0), QoS(deadline=1.0), True),
    (QoS(deadline=1.0), QoS(deadline=2.0), True),
    (QoS(deadline=2.0), QoS(deadline=1.0), False),
    (QoS(), QoS(deadline=1.0), False),
    (QoS(liveliness="manualByTopic"), QoS(liveliness="automatic"), True),
    (QoS(liveliness="automatic"), QoS(liveliness="manualByTopic"), False),
    (QoS(lease_duration=1.0), QoS(), True),
    (QoS(lease_duration=1.0), QoS(lease_duration=2.0), True),
    (QoS(lease_duration=2.0), QoS(lease_duration=1.0), False),
    (QoS(), QoS(lease_duration=1.0), False),
    (QoS(history="keepAll", depth=1, lifespan=10.0), QoS(history="keepLast", depth=50), True),
    (QoS(history="keepLast", depth=1), QoS(history="keepAll"), True),
]


# isaacsim.ros2.nodes/python/tests/test_qos_profile.py
@pytest.mark.parametrize(
    ("name", "profile"),
    [
        ("Default for publishers/subscribers", DEFAULT),
        ("Services", DEFAULT),
        ("System Default", SYSTEM_DEFAULT),
        ("Sensor Data", DEFAULT | {"depth": 5, "reliability": "bestEffort"}),
    ],
)
def test_presets_are_those_of_isaac_sim(name: str, profile: dict[str, Any]) -> None:
    assert json.loads(qos_json(PRESETS[name])) == profile


# isaacsim.ros2.nodes/python/tests/test_qos_profile.py
@pytest.mark.parametrize("profile", [DEFAULT, SYSTEM_DEFAULT, CUSTOM])
def test_a_profile_passes_through_unchanged(profile: dict[str, Any]) -> None:
    assert json.loads(qos_json(parse_qos(json.dumps(profile)))) == profile


def test_the_queue_size_counts_only_without_a_profile() -> None:
    assert parse_qos("", 3) == QoS(depth=3)
    assert parse_qos("  ", 3) == QoS(depth=3)
    assert parse_qos(json.dumps(DEFAULT), 3) == QoS()


def test_a_static_publisher_overrides_every_profile() -> None:
    latched = QoS("keepLast", 1, "reliable", "transientLocal")
    assert parse_qos("", 10, latched=True) == latched
    assert parse_qos(json.dumps(CUSTOM), 10, latched=True) == latched == LATCHED


@pytest.mark.parametrize(
    ("text", "message", "help_line"),
    [
        ("{", "is not JSON", "keys: history, depth"),
        ("[]", "is not a JSON object", "leaseDuration"),
        ('{"dept": 3}', "no key 'dept'", "did you mean 'depth'?"),
        ('{"reliability": "besteffort"}', "reliability cannot be 'besteffort'", "did you mean 'bestEffort'?"),
        ('{"history": "unknown"}', "history cannot be 'unknown'", "legal: keepLast, keepAll, systemDefault"),
        ('{"history": 1}', "history cannot be 1", "legal:"),
        ('{"history": ["keepLast"]}', "history cannot be", "legal:"),
        ('{"depth": -1}', "depth cannot be -1", "a whole number from 0"),
        ('{"depth": true}', "depth cannot be True", "a whole number from 0"),
        ('{"depth": 2147483648}', "depth cannot be 2147483648", "to 2147483647"),
        ('{"deadline": -0.1}', "deadline cannot be -0.1", "seconds, 0 for unlimited"),
        ('{"lifespan": NaN}', "lifespan cannot be nan", "seconds"),
        ('{"leaseDuration": Infinity}', "leaseDuration cannot be inf", "seconds"),
        ('{"deadline": "1"}', "deadline cannot be '1'", "seconds"),
        ("[" * 100_000, "is not JSON", "keys"),
    ],
)
def test_the_error_of_an_illegal_profile_lists_the_legal_values(text: str, message: str, help_line: str) -> None:
    with pytest.raises(TopicError) as caught:
        parse_qos(text)
    assert message in caught.value.message
    assert help_line in "\n".join(caught.value.help)
    assert caught.value.value == text


def test_a_negative_queue_size_is_an_error() -> None:
    with pytest.raises(TopicError, match="queue size cannot be -1"):
        parse_qos("", -1)


@given(st.one_of(st.text(max_size=40), st.recursive(st.none() | st.integers() | st.text(), st.lists).map(json.dumps)))
def test_any_text_gives_a_profile_or_a_topic_error(text: str) -> None:
    with contextlib.suppress(TopicError):
        assert isinstance(parse_qos(text), QoS)


def test_system_defaults_become_the_policies_of_rmw_cyclonedds() -> None:
    assert settled(PRESETS["System Default"]) == QoS("keepLast", 1, "reliable", "volatile", liveliness="automatic")


@pytest.mark.parametrize(("offered", "requested", "fits"), TABLE)
def test_incompatible_policies_are_exactly_those_of_dds(offered: QoS, requested: QoS, fits: bool) -> None:
    assert (mismatch(offered, requested) == "") == fits


@pytest.mark.parametrize(
    ("offered", "requested", "why"),
    [
        (QoS(reliability="bestEffort"), QoS(), "R asks for reliable, W offers bestEffort"),
        (QoS(), QoS(deadline=0.5), "R asks for a deadline of 0.5 s, W offers no deadline"),
        (QoS(deadline=2.0), QoS(deadline=1.0), "R asks for a deadline of 1 s, W offers a deadline of 2 s"),
        (QoS(), QoS(lease_duration=1.0), "R asks for a lease of 1 s, W offers no lease"),
        (
            QoS(reliability="bestEffort"),
            QoS(liveliness="manualByTopic"),
            "R asks for reliable and liveliness manualByTopic, W offers bestEffort and liveliness automatic",
        ),
    ],
)
def test_a_mismatch_names_the_requested_and_the_offered_policies(offered: QoS, requested: QoS, why: str) -> None:
    assert mismatch(offered, requested, "W", "R") == why


def test_a_reader_with_the_offered_policies_is_compatible() -> None:
    offered, requested = QoS(reliability="bestEffort"), QoS(durability="transientLocal", deadline=1.0)
    policies = short_of(offered, requested)
    assert policies == ("reliability", "durability", "deadline")
    asked = {key: value for key, value in json.loads(qos_json(requested)).items() if key not in policies}
    assert not mismatch(offered, parse_qos(json.dumps(asked | json.loads(profile(offered, policies)))))


def profile(qos: QoS, policies: tuple[str, ...]) -> str:
    return "{" + ", ".join(policy_json(qos, policy) for policy in policies) + "}"
