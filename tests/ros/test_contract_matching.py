"""One contract for every transport: who matches whom, and what is refused."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from graphengine.format.errors import TopicError, TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import MAX_DOMAIN_ID, Domain
from graphengine.ros.transport import JoinOptions, Transport
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.rcl.rcl import RclTransport
from tests.messages.test_qos import TABLE
from tests.ros.contract import FAITHFUL, RCLPY, STRING, AnyTransport, Inbox, Join, connect, text
from tests.waiting import eventually, reserved_domain


def test_every_transport_implements_the_protocol(join: Join, domain_id: int, kind: str) -> None:
    transport: Transport = join("alice")
    assert transport.description.startswith(kind.split()[0])
    if kind != "memory":
        assert f"domain {domain_id}, discovery range LOCALHOST" in transport.description


def test_a_reader_matches_writers_that_offer_at_least_its_qos(bob: AnyTransport, alice: AnyTransport) -> None:
    inboxes = [Inbox() for _ in TABLE]
    for number, (_, requested, _) in enumerate(TABLE):
        bob.reader(f"/row{number}", STRING, requested, inboxes[number])
    writers = [alice.writer(f"/row{number}", STRING, offered) for number, (offered, _, _) in enumerate(TABLE)]
    fitting = [number for number, (_, _, fits) in enumerate(TABLE) if fits]
    eventually(lambda: all(writers[number].matched for number in fitting))
    assert [TABLE[number] for number in fitting if not writers[number].matched] == []

    def all_heard() -> bool:
        for writer in writers:
            writer.write(text("heard"))
        return all(inboxes[number].texts for number in fitting)

    assert eventually(all_heard)
    assert [number for number, writer in enumerate(writers) if writer.matched] == fitting
    assert [number for number, inbox in enumerate(inboxes) if inbox.texts] == fitting


def test_a_reader_gets_no_messages_of_another_type(join: Join) -> None:
    other: list[bytes] = []
    same = Inbox()
    join("bob").reader("/chatter", "std_msgs/msg/Bool", QoS(), other.append)
    join("carol").reader("/chatter", STRING, QoS(), same)
    writer = join("alice").writer("/chatter", STRING, QoS())
    connect(writer, same)
    assert other == []


def test_a_best_effort_reader_gets_messages_of_a_reliable_writer(join: Join) -> None:
    inbox = Inbox()
    join("bob").reader("/chatter", STRING, QoS(depth=5, reliability="bestEffort"), inbox)
    writer = join("alice").writer("/chatter", STRING, LATCHED)
    connect(writer, inbox)
    writer.write(text("heard"))
    assert eventually(lambda: inbox.texts == ["heard"])


@pytest.mark.parametrize("kind", ["memory", *FAITHFUL], indirect=True)
def test_matched_changes_when_a_reader_opens_or_closes(bob: AnyTransport, join: Join) -> None:
    writer = join("alice").writer("/chatter", STRING, QoS())
    assert not writer.matched
    for _ in range(2):
        reader = bob.reader("/chatter", STRING, QoS(), Inbox())
        assert eventually(lambda: writer.matched)
        reader.close()
        reader.close()
        assert eventually(lambda: not writer.matched)


@pytest.mark.parametrize("kind", ["memory", "dds"], indirect=True)
def test_matched_is_the_number_of_readers(bob: AnyTransport, join: Join) -> None:
    writer = join("alice").writer("/chatter", STRING, QoS())
    readers = [bob.reader("/chatter", STRING, QoS(), Inbox()) for _ in range(3)]
    assert eventually(lambda: writer.matched == 3)
    readers[0].close()
    assert eventually(lambda: writer.matched == 2)


def test_a_closed_writer_refuses_messages_and_is_not_matched(alice: AnyTransport, join: Join) -> None:
    writer = alice.writer("/chatter", STRING, QoS())
    join("bob").reader("/chatter", STRING, QoS(), Inbox())
    assert eventually(lambda: writer.matched)
    writer.close()
    writer.close()
    assert not writer.matched
    with pytest.raises(TransportError, match="/chatter"):
        writer.write(text("late"))


def test_a_closed_transport_opens_no_endpoints(alice: AnyTransport) -> None:
    writer = alice.writer("/chatter", STRING, QoS())
    alice.reader("/chatter", STRING, QoS(), Inbox())
    alice.close()
    alice.close()
    writer.close()
    assert not writer.matched
    with pytest.raises(TransportError, match="/chatter"):
        writer.write(text("late"))
    with pytest.raises(TransportError, match=r"^/chatter: the transport is closed"):
        alice.writer("/chatter", STRING, QoS())
    with pytest.raises(TransportError, match=r"^/chatter: the transport is closed"):
        alice.reader("/chatter", STRING, QoS(), Inbox())


def test_an_unknown_message_type_is_refused(alice: AnyTransport) -> None:
    with pytest.raises(MessageTypeError, match="no_msgs/msg/Nothing"):
        alice.writer("/chatter", "no_msgs/msg/Nothing", QoS())
    with pytest.raises(MessageTypeError, match="no_msgs/msg/Nothing"):
        alice.reader("/chatter", "no_msgs/msg/Nothing", QoS(), Inbox())


@pytest.mark.parametrize("kind", ["dds", RCLPY], indirect=True)
@pytest.mark.parametrize(("name", "namespace"), [("two words", "/"), ("alice", "robot"), ("", "/")])
def test_illegal_node_names_are_refused(kind: str, domain_id: int, name: str, namespace: str) -> None:
    make = DdsTransport if kind == "dds" else RclTransport
    with pytest.raises(TopicError):
        make(JoinOptions(Domain(domain_id, "LOCALHOST"), name, namespace))


@pytest.fixture
def elsewhere() -> Iterator[int]:
    with reserved_domain() as number:
        yield number


def test_messages_stay_in_their_domain(elsewhere: int, join: Join) -> None:
    near, far = Inbox(), Inbox()
    writer = join("alice").writer("/chatter", STRING, QoS())
    join("carol", elsewhere).reader("/chatter", STRING, QoS(), far)
    assert not writer.matched
    join("bob").reader("/chatter", STRING, QoS(), near)
    connect(writer, near)
    writer.write(text("near"))
    assert eventually(lambda: near.texts == ["near"])
    assert far.texts == []


@pytest.mark.parametrize("kind", ["dds", RCLPY], indirect=True)
@pytest.mark.parametrize("number", [0, MAX_DOMAIN_ID])
def test_the_first_and_the_last_domain_can_be_joined(kind: str, number: int) -> None:
    make = DdsTransport if kind == "dds" else RclTransport
    transport = make(JoinOptions(Domain(number, "OFF"), "alice"))
    try:
        inbox = Inbox()
        transport.reader("/chatter", STRING, QoS(), inbox)
        connect(transport.writer("/chatter", STRING, QoS()), inbox)
    finally:
        transport.close()
