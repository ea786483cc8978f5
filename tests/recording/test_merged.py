"""Deliveries that several subscriptions share are kept once, and none's order changes."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.recording.recorder import merged


def claim(node: str, topic: str = "/a") -> EndpointClaim:
    return EndpointClaim(node, "graph", topic, "std_msgs/msg/String", "subscribe", QoS())


QUEUES = st.lists(
    st.tuples(st.sampled_from(["/a", "/b"]), st.lists(st.sampled_from([b"1", b"2", b"3"]), min_size=1, max_size=5)),
    max_size=4,
)


@given(QUEUES)
def test_each_subscription_gets_its_messages_in_its_order(queues: list[tuple[str, list[bytes]]]) -> None:
    arrived = [(claim(f"/node{index}", topic), data) for index, (topic, data) in enumerate(queues)]
    found = merged(arrived)
    for one, data in arrived:
        assert [seen for claims, seen in found if one in claims] == data
    assert all(len({one.topic for one in claims}) == 1 for claims, _ in found)


def test_messages_that_all_received_in_the_same_order_occur_once() -> None:
    claims = [claim("/one"), claim("/other")]
    assert merged([(one, [b"1", b"2"]) for one in claims]) == [(claims, b"1"), (claims, b"2")]


def test_a_message_that_one_received_later_occurs_for_it_alone() -> None:
    one, other = claim("/one"), claim("/other")
    assert merged([(one, [b"1", b"2"]), (other, [b"1"])]) == [([one, other], b"1"), ([one], b"2")]
