"""What a node saw is known where the run published it, or another node saw as many copies before."""

from __future__ import annotations

import pickle
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.recording import seen_messages
from graphengine.recording.seen_messages import SeenMessages

NODES = ("/World/one", "/World/other")


def test_a_published_message_is_known_for_every_node() -> None:
    topic = SeenMessages()
    topic.add(b"a")
    assert topic.see(NODES[:1], b"a")
    assert topic.see(NODES[1:], b"a")


def test_a_message_that_another_node_received_is_known() -> None:
    topic = SeenMessages()
    assert not topic.see(NODES[:1], b"a")
    assert topic.see(NODES[1:], b"a")


def test_equal_bytes_received_again_are_a_new_message() -> None:
    topic = SeenMessages()
    topic.add(b"a")
    assert topic.see(NODES, b"a")
    assert not topic.see(NODES, b"a")
    assert not topic.see(NODES[:1], b"b")


def test_a_message_that_is_new_for_one_of_several_nodes_is_not_known() -> None:
    topic = SeenMessages()
    assert not topic.see(NODES[:1], b"a")
    assert not topic.see(NODES, b"a")


def test_messages_beyond_the_limit_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seen_messages, "REMEMBERED", 2)
    topic = SeenMessages()
    for data in (b"a", b"b", b"c"):
        topic.add(data)
    assert [topic.see(NODES, data) for data in (b"b", b"c", b"a")] == [True, True, False]


def test_a_message_that_a_node_missed_is_forgotten_for_all_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seen_messages, "REMEMBERED", 2)
    topic = SeenMessages()
    topic.see(NODES[:1], b"x")
    for data in (b"a", b"b", b"c"):  # the node does not receive them
        topic.add(data)
    assert not topic.see(NODES[:1], b"a")
    assert not topic.see(NODES[:1], b"a")


def test_forgotten_messages_take_no_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(seen_messages, "REMEMBERED", 10)
    topic, sizes = SeenMessages(), []
    for number in range(1000):
        topic.see(NODES, b"%d" % number)
        sizes.append(len(pickle.dumps(topic)))
    assert max(sizes) < 2 * sizes[10]


EVENTS = st.lists(st.tuples(st.sampled_from([(), NODES[:1], NODES[1:], NODES]), st.sampled_from([b"a", b"b"])))


@given(EVENTS)
def test_a_topic_has_each_message_as_often_as_it_was_sent(events: list[tuple[tuple[str, ...], bytes]]) -> None:
    topic, kept, published = SeenMessages(), Counter[bytes](), Counter[bytes]()
    seen: dict[str, Counter[bytes]] = {node: Counter() for node in NODES}
    for nodes, data in events:
        if not nodes:
            topic.add(data)
            published[data] += 1
        if not nodes or not topic.see(nodes, data):
            kept[data] += 1
        for node in nodes:
            seen[node][data] += 1
        most = max(counts[data] for counts in seen.values())
        assert max(most, published[data]) <= kept[data] <= most + published[data]
