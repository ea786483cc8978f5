"""One contract for every transport: who is there, who comes and goes, and who dies."""

from __future__ import annotations

import signal
from functools import partial

import pytest

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import LATCHED
from graphengine.ros.transport import Transport, discover
from tests.ros.conftest import StartPeer
from tests.ros.contract import COMPOSED, FAITHFUL, NETWORKED, RCLPY, STRING, AnyTransport, Inbox, Join, connect, text
from tests.waiting import eventually

SHORT_LEASE = "<CycloneDDS><Domain><Discovery><LeaseDuration>1s</LeaseDuration></Discovery></Domain></CycloneDDS>"
"""Configuration of a peer that is given up for dead after a second; by default it takes 10."""


def known(transport: Transport, topic: str) -> list[tuple[str, str, str]]:
    """Of each end of a topic: direction, type and node."""
    ends = (end for end in transport.graph().endpoints if end.topic == topic)
    return [(end.direction, end.message_type, end.full_node) for end in ends]


def test_the_graph_has_the_writers_and_readers_of_each_topic(alice: AnyTransport, bob: AnyTransport, kind: str) -> None:
    alice.writer("/chatter", STRING, LATCHED)
    bob.reader("/chatter", STRING, QoS(depth=5, reliability="bestEffort"), Inbox())
    nodes = ("", "") if kind == "memory" else ("/alice", "/bob")

    def told(asked: Transport) -> bool:
        return known(asked, "/chatter") == [("publish", STRING, nodes[0]), ("subscribe", STRING, nodes[1])]

    for transport in (alice, bob):
        assert eventually(partial(told, transport))
        writer, reader = (end for end in transport.graph().endpoints if end.topic == "/chatter")
        assert (writer.qos.reliability, writer.qos.durability) == ("reliable", "transientLocal")
        assert (reader.qos.reliability, reader.qos.durability) == ("bestEffort", "volatile")
        assert writer.type_hash == reader.type_hash == DEFINITIONS.type_hash(STRING)
        assert len({writer.gid, reader.gid}) == 2
        assert {len(writer.gid), len(reader.gid)} == {16}
        assert writer.serves(reader)


@pytest.mark.parametrize("kind", ["memory", *FAITHFUL], indirect=True)
def test_the_graph_changes_when_endpoints_open_and_close(alice: AnyTransport, bob: AnyTransport) -> None:
    assert known(alice, "/chatter") == []
    for _ in range(2):
        reader = bob.reader("/chatter", STRING, QoS(), Inbox())
        assert eventually(lambda: alice.graph().subscribers("/chatter"))
        reader.close()
        assert eventually(lambda: not alice.graph().subscribers("/chatter"))


@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_a_closed_peer_leaves_the_graph(alice: AnyTransport, bob: AnyTransport) -> None:
    bob.writer("/chatter", STRING, QoS())
    assert eventually(lambda: known(alice, "/chatter") == [("publish", STRING, "/bob")])
    bob.close()
    assert eventually(lambda: known(alice, "/chatter") == [])
    assert "/bob" not in {end.full_node for end in alice.graph().endpoints}


def test_discovery_ends_when_enough_is_found_or_after_its_time(
    alice: AnyTransport, bob: AnyTransport, kind: str
) -> None:
    assert discover(alice, 0.0).publishers("/chatter") == []
    bob.writer("/chatter", STRING, QoS())
    found = discover(alice, 60.0, lambda graph: graph.publishers("/chatter"))
    assert found.types()["/chatter"] == [STRING]
    named = discover(alice, 0.0, names=True).publishers("/chatter")
    assert [end.node for end in named] == ["" if kind == "memory" else "bob"]


def test_a_closed_transport_raises_an_error_for_its_graph(alice: AnyTransport) -> None:
    alice.close()
    with pytest.raises(TransportError, match="the transport is closed"):
        alice.graph()


def test_the_graph_can_be_asked_for_single_topics(alice: AnyTransport, bob: AnyTransport) -> None:
    alice.writer("/chatter", STRING, QoS())
    bob.reader("/chatter", STRING, QoS(), Inbox())
    assert eventually(lambda: alice.graph([("/chatter", "subscribe")]).subscribers("/chatter"))
    assert alice.graph([("/nobody", "publish")]).publishers("/nobody") == []


# Who goes


@pytest.mark.parametrize("kind", FAITHFUL, indirect=True)
def test_matched_ends_when_the_peer_leaves(bob: AnyTransport, join: Join) -> None:
    writer = join("alice").writer("/chatter", STRING, QoS())
    bob.reader("/chatter", STRING, QoS(), Inbox())
    assert eventually(lambda: writer.matched)
    bob.close()
    assert eventually(lambda: not writer.matched)


@pytest.mark.parametrize("kind", ["memory", *FAITHFUL], indirect=True)
def test_a_returning_peer_gets_messages_again(join: Join) -> None:
    writer = join("alice").writer("/chatter", STRING, QoS())
    for _ in range(2):
        inbox = Inbox()
        bob = join("bob")
        reader = bob.reader("/chatter", STRING, QoS(), inbox)
        connect(writer, inbox)
        reader.close()
        if bob.node:
            bob.close()
        assert eventually(lambda: not writer.matched)


@pytest.mark.parametrize("kind", ["dds", RCLPY, COMPOSED], indirect=True)
def test_after_a_killed_peer_its_successor_gets_messages(alice: AnyTransport, start_peer: StartPeer) -> None:
    inbox = Inbox()
    ping = alice.writer("/ping", STRING, QoS())
    alice.reader("/pong", STRING, QoS(), inbox)
    for visit in ("first", "second"):
        peer = start_peer("echo", CYCLONEDDS_URI=SHORT_LEASE)
        assert eventually(lambda: ping.matched)

        def answered(visit: str = visit) -> bool:
            ping.write(text(visit))
            return visit in inbox.texts

        assert eventually(answered)
        peer.send_signal(signal.SIGKILL)
        assert eventually(lambda: not ping.matched, lambda: ping.write(text("lost")))  # which never fails, nor lasts


@pytest.mark.parametrize("kind", ["dds"], indirect=True)
def test_messages_for_a_stopped_peer_are_dropped_and_counted(join: Join, start_peer: StartPeer) -> None:
    writer = join("alice").writer("/ping", STRING, QoS(history="keepAll"))
    peer = start_peer("echo", CYCLONEDDS_URI=SHORT_LEASE)
    assert eventually(lambda: writer.matched)
    peer.send_signal(signal.SIGSTOP)
    assert eventually(lambda: writer.dropped > 0, lambda: writer.write(text("x" * 1_000_000)))
    assert eventually(lambda: not writer.matched)
    peer.send_signal(signal.SIGKILL)
