"""One contract for every transport: what is written arrives, or does not, as ROS 2 promises."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import pytest

from graphengine.context import QoS
from graphengine.diagnostics import TopicError, TransportError
from graphengine.ros import rcl
from graphengine.ros.dds import DdsTransport
from graphengine.ros.domain import Domain
from graphengine.ros.graph import discover
from graphengine.ros.interfaces import MessageTypeError
from graphengine.ros.memory import MemoryTransport
from graphengine.ros.messages import String, decode, encode, type_hash
from graphengine.ros.qos import LATCHED
from graphengine.ros.rcl import RclTransport
from graphengine.ros.transport import Transport, Writer

AnyTransport: TypeAlias = MemoryTransport | DdsTransport | RclTransport
Join: TypeAlias = Callable[[int, str], AnyTransport]
Eventually: TypeAlias = Callable[[Callable[[], object]], bool]

STRING = "std_msgs/msg/String"
RCLPY_MISSING = rcl.import_error()
needs_rclpy = [pytest.mark.ros, pytest.mark.skipif(RCLPY_MISSING is not None, reason=str(RCLPY_MISSING))]
RCLPY = pytest.param("rclpy", marks=needs_rclpy)
# The node called alice is of the first kind, all others are of the second.
MIXED = [pytest.param(kind, marks=needs_rclpy) for kind in ("dds to rclpy", "rclpy to dds")]
# A writer of Fast DDS may lose the first large message to a reader of Cyclone DDS, and does not notice when that one goes:
# so it is between nodes of ROS 2 itself too.
FAITHFUL = ["dds", RCLPY, MIXED[0]]


@pytest.fixture(params=["memory", "dds", RCLPY, *MIXED])
def kind(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def join(kind: str) -> Iterator[Join]:
    """Joins a domain as a node; in memory, all that join one domain are one transport."""
    joined: list[AnyTransport] = []
    in_memory: dict[int, MemoryTransport] = {}

    def join(domain_id: int, name: str) -> AnyTransport:
        domain = Domain(domain_id, "LOCALHOST")
        transport: AnyTransport
        if kind == "memory":
            transport = in_memory.setdefault(domain_id, MemoryTransport())
        else:
            side = kind.partition(" to ")[0] if name == "alice" else kind.rpartition(" to ")[2]
            transport = DdsTransport(domain, name) if side == "dds" else RclTransport(domain, name)
        joined.append(transport)
        return transport

    yield join
    for transport in joined:
        transport.close()


class Inbox:
    """What a reader was given, as text."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def __call__(self, data: bytes) -> None:
        assert type(data) is bytes
        self.texts.append(decode(data, STRING).data)


def text(value: str) -> bytes:
    return encode(String(value))


def connect(writer: Writer, inbox: Inbox, eventually: Eventually) -> None:
    """Wait until both ends know of each other: that one is matched does not tell that the other is."""
    assert eventually(lambda: writer.matched)

    def probed() -> bool:
        writer.write(text("probe"))
        return bool(inbox.texts)

    assert eventually(probed)
    writer.write(text("ready"))
    assert eventually(lambda: inbox.texts[-1] == "ready")
    inbox.texts.clear()


def test_every_transport_is_a_transport(join: Join, domain_id: int, kind: str) -> None:
    transport: Transport = join(domain_id, "alice")
    assert transport.description.startswith(kind.partition(" to ")[0])
    if kind != "memory":
        assert f"domain {domain_id}, discovery range LOCALHOST" in transport.description


def test_messages_arrive_in_the_order_they_were_written(join: Join, domain_id: int, eventually: Eventually) -> None:
    inbox = Inbox()
    join(domain_id, "bob").reader("/chatter", STRING, QoS(depth=200), inbox)
    writer = join(domain_id, "alice").writer("/chatter", STRING, QoS(depth=200))
    connect(writer, inbox, eventually)
    written = [str(number) for number in range(100)]
    for value in written:
        writer.write(text(value))
    assert eventually(lambda: len(inbox.texts) >= 100)
    assert inbox.texts == written


def test_a_node_hears_itself(join: Join, domain_id: int, eventually: Eventually) -> None:
    inbox = Inbox()
    alice = join(domain_id, "alice")
    writer = alice.writer("/chatter", STRING, QoS())
    alice.reader("/chatter", STRING, QoS(), inbox)
    connect(writer, inbox, eventually)
    writer.write(text("self"))
    assert eventually(lambda: inbox.texts == ["self"])


@pytest.mark.parametrize("kind", ["memory", *FAITHFUL], indirect=True)
def test_large_messages_arrive_whole(join: Join, domain_id: int, eventually: Eventually) -> None:
    inbox = Inbox()
    join(domain_id, "bob").reader("/chatter", STRING, QoS(), inbox)
    writer = join(domain_id, "alice").writer("/chatter", STRING, QoS())
    connect(writer, inbox, eventually)
    writer.write(text("x" * 200_000))
    assert eventually(lambda: inbox.texts == ["x" * 200_000])


def test_a_late_joiner_of_a_latched_topic_gets_the_last_message(
    join: Join, domain_id: int, eventually: Eventually
) -> None:
    writer = join(domain_id, "alice").writer("/map", STRING, LATCHED)
    for value in ("old", "older", "last"):
        writer.write(text(value))
    inbox = Inbox()
    join(domain_id, "bob").reader("/map", STRING, LATCHED, inbox)
    assert eventually(lambda: inbox.texts == ["last"])
    writer.write(text("new"))
    assert eventually(lambda: inbox.texts == ["last", "new"])


@pytest.mark.parametrize(("kept", "wanted", "expected"), [(3, 10, "cde"), (10, 2, "de")])
def test_a_late_joiner_gets_as_many_as_both_depths_allow(
    join: Join, domain_id: int, eventually: Eventually, kept: int, wanted: int, expected: str
) -> None:
    writer = join(domain_id, "alice").writer("/map", STRING, replace(LATCHED, depth=kept))
    for value in "abcde":
        writer.write(text(value))
    inbox = Inbox()
    # A reader that keeps fewer may still be given more, where it empties its queue while they come.
    join(domain_id, "bob").reader("/map", STRING, replace(LATCHED, depth=wanted), inbox)
    assert eventually(lambda: "".join(inbox.texts).endswith(expected))
    assert len(inbox.texts) <= kept


def test_a_late_joiner_of_a_volatile_topic_gets_nothing_old(join: Join, domain_id: int, eventually: Eventually) -> None:
    writer = join(domain_id, "alice").writer("/chatter", STRING, QoS())
    writer.write(text("old"))
    inbox = Inbox()
    join(domain_id, "bob").reader("/chatter", STRING, QoS(), inbox)

    def heard() -> bool:
        writer.write(text("new"))
        return bool(inbox.texts)

    assert eventually(heard)
    assert set(inbox.texts) == {"new"}


@pytest.mark.parametrize(
    ("offered", "requested"),
    [
        (QoS(reliability="bestEffort"), QoS(reliability="reliable")),
        (QoS(durability="volatile"), QoS(durability="transientLocal")),
        (QoS(deadline=2.0), QoS(deadline=1.0)),
    ],
)
def test_a_reader_that_wants_more_than_is_offered_gets_nothing(
    join: Join, domain_id: int, eventually: Eventually, offered: QoS, requested: QoS
) -> None:
    strict, lenient = Inbox(), Inbox()
    bob = join(domain_id, "bob")
    bob.reader("/chatter", STRING, requested, strict)
    alice = join(domain_id, "alice")
    writer = alice.writer("/chatter", STRING, offered)
    marker = alice.writer("/marker", STRING, QoS())
    bob.reader("/marker", STRING, QoS(), lenient)
    connect(marker, lenient, eventually)
    assert not writer.matched
    writer.write(text("lost"))
    marker.write(text("seen"))
    assert eventually(lambda: lenient.texts == ["seen"])
    assert strict.texts == []


def test_best_effort_readers_hear_reliable_writers(join: Join, domain_id: int, eventually: Eventually) -> None:
    inbox = Inbox()
    join(domain_id, "bob").reader("/chatter", STRING, QoS(depth=5, reliability="bestEffort"), inbox)
    writer = join(domain_id, "alice").writer("/chatter", STRING, LATCHED)
    connect(writer, inbox, eventually)
    writer.write(text("heard"))
    assert eventually(lambda: inbox.texts == ["heard"])


@pytest.mark.parametrize("kind", ["memory", *FAITHFUL], indirect=True)
def test_matched_follows_readers_that_come_and_go(join: Join, domain_id: int, eventually: Eventually) -> None:
    writer = join(domain_id, "alice").writer("/chatter", STRING, QoS())
    assert not writer.matched
    bob = join(domain_id, "bob")
    for _ in range(2):
        reader = bob.reader("/chatter", STRING, QoS(), Inbox())
        assert eventually(lambda: writer.matched)
        reader.close()
        reader.close()
        assert eventually(lambda: not writer.matched)


def test_a_reader_that_is_closed_gets_no_more(join: Join, domain_id: int, eventually: Eventually) -> None:
    gone, stays = Inbox(), Inbox()
    bob = join(domain_id, "bob")
    reader = bob.reader("/chatter", STRING, QoS(), gone)
    bob.reader("/chatter", STRING, QoS(), stays)
    writer = join(domain_id, "alice").writer("/chatter", STRING, QoS())

    def both_heard() -> bool:
        writer.write(text("a"))
        return bool(gone.texts and stays.texts)

    assert eventually(both_heard)
    reader.close()
    heard = len(gone.texts)
    writer.write(text("b"))
    assert eventually(lambda: stays.texts[-1] == "b")
    assert len(gone.texts) == heard


def test_a_writer_that_is_closed_refuses_and_is_not_matched(join: Join, domain_id: int, eventually: Eventually) -> None:
    alice = join(domain_id, "alice")
    writer = alice.writer("/chatter", STRING, QoS())
    join(domain_id, "bob").reader("/chatter", STRING, QoS(), Inbox())
    assert eventually(lambda: writer.matched)
    writer.close()
    writer.close()
    assert not writer.matched
    with pytest.raises(TransportError, match="/chatter"):
        writer.write(text("late"))


def test_a_transport_that_is_closed_is_left_for_good(join: Join, domain_id: int) -> None:
    alice = join(domain_id, "alice")
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


def test_a_type_that_does_not_exist_cannot_be_opened(join: Join, domain_id: int) -> None:
    alice = join(domain_id, "alice")
    with pytest.raises(MessageTypeError, match="no_msgs/msg/Nothing"):
        alice.writer("/chatter", "no_msgs/msg/Nothing", QoS())
    with pytest.raises(MessageTypeError, match="no_msgs/msg/Nothing"):
        alice.reader("/chatter", "no_msgs/msg/Nothing", QoS(), Inbox())


def test_domains_do_not_hear_each_other(join: Join, domain_id: int, eventually: Eventually) -> None:
    near, far = Inbox(), Inbox()
    writer = join(domain_id, "alice").writer("/chatter", STRING, QoS())
    join(domain_id + 1, "carol").reader("/chatter", STRING, QoS(), far)
    assert not writer.matched
    join(domain_id, "bob").reader("/chatter", STRING, QoS(), near)
    connect(writer, near, eventually)
    writer.write(text("near"))
    assert eventually(lambda: near.texts == ["near"])
    assert far.texts == []


@pytest.mark.parametrize("kind", FAITHFUL, indirect=True)
def test_matched_ends_when_the_peer_leaves(join: Join, domain_id: int, eventually: Eventually) -> None:
    writer = join(domain_id, "alice").writer("/chatter", STRING, QoS())
    bob = join(domain_id, "bob")
    bob.reader("/chatter", STRING, QoS(), Inbox())
    assert eventually(lambda: writer.matched)
    bob.close()
    assert eventually(lambda: not writer.matched)


@pytest.mark.parametrize("kind", ["dds", RCLPY, *MIXED], indirect=True)
def test_an_error_in_a_delivery_does_not_end_deliveries(
    join: Join, domain_id: int, eventually: Eventually, caplog: pytest.LogCaptureFixture
) -> None:
    inbox = Inbox()

    def fail_at_times(data: bytes) -> None:
        inbox(data)
        if inbox.texts[-1] in "ab":
            raise RuntimeError("on purpose")

    join(domain_id, "bob").reader("/chatter", STRING, QoS(), fail_at_times)
    writer = join(domain_id, "alice").writer("/chatter", STRING, QoS())
    connect(writer, inbox, eventually)
    with caplog.at_level(logging.ERROR, "graphengine"):
        for value in "abc":
            writer.write(text(value))
        assert eventually(lambda: inbox.texts == ["a", "b", "c"])
    assert [record.getMessage() for record in caplog.records] == [
        "/chatter: a message could not be delivered; told once"
    ]


@pytest.mark.parametrize("kind", ["dds", RCLPY, *MIXED], indirect=True)
def test_people_can_read_the_log_on_rosout(join: Join, domain_id: int, eventually: Eventually) -> None:
    alice = join(domain_id, "alice")
    assert not isinstance(alice, MemoryTransport)
    alice.log("warning", "wheel slips")
    entries: list[bytes] = []
    join(domain_id, "bob").reader("/rosout", "rcl_interfaces/msg/Log", replace(LATCHED, depth=100), entries.append)
    assert eventually(lambda: entries)
    entry = decode(entries[0], "rcl_interfaces/msg/Log")
    assert (entry.level, entry.name, entry.msg) == (entry.WARN, "alice", "wheel slips")
    alice.close()
    alice.log("error", "nobody hears this")


@pytest.mark.parametrize("kind", ["dds", RCLPY], indirect=True)
@pytest.mark.parametrize(("name", "namespace"), [("two words", "/"), ("alice", "robot"), ("", "/")])
def test_names_that_ros_refuses_are_refused(kind: str, domain_id: int, name: str, namespace: str) -> None:
    make = DdsTransport if kind == "dds" else RclTransport
    with pytest.raises(TopicError):
        make(Domain(domain_id, "LOCALHOST"), name, namespace)


# Who is there


def known(transport: Transport, topic: str) -> list[tuple[str, str, str]]:
    """Of each end of a topic: direction, type and node."""
    return [
        (end.direction, end.message_type, end.full_node) for end in transport.graph().endpoints if end.topic == topic
    ]


def test_the_graph_tells_who_writes_and_reads_what(
    join: Join, kind: str, domain_id: int, eventually: Eventually
) -> None:
    alice, bob = join(domain_id, "alice"), join(domain_id, "bob")
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
        assert writer.type_hash == reader.type_hash == type_hash(STRING)
        assert len({writer.gid, reader.gid}) == 2
        assert {len(writer.gid), len(reader.gid)} == {16}
        assert writer.serves(reader)


@pytest.mark.parametrize("kind", ["memory", *FAITHFUL], indirect=True)
def test_the_graph_follows_who_comes_and_goes(join: Join, domain_id: int, eventually: Eventually) -> None:
    alice, bob = join(domain_id, "alice"), join(domain_id, "bob")
    assert known(alice, "/chatter") == []
    for _ in range(2):
        reader = bob.reader("/chatter", STRING, QoS(), Inbox())
        assert eventually(lambda: alice.graph().subscribers("/chatter"))
        reader.close()
        assert eventually(lambda: not alice.graph().subscribers("/chatter"))


@pytest.mark.parametrize("kind", ["dds", RCLPY, *MIXED], indirect=True)
def test_a_peer_that_leaves_is_gone_from_the_graph(join: Join, domain_id: int, eventually: Eventually) -> None:
    alice, bob = join(domain_id, "alice"), join(domain_id, "bob")
    bob.writer("/chatter", STRING, QoS())
    assert eventually(lambda: known(alice, "/chatter") == [("publish", STRING, "/bob")])
    bob.close()
    assert eventually(lambda: known(alice, "/chatter") == [])
    assert "/bob" not in {end.full_node for end in alice.graph().endpoints}


def test_discovery_ends_when_it_is_enough_or_when_the_time_is_up(join: Join, kind: str, domain_id: int) -> None:
    alice, bob = join(domain_id, "alice"), join(domain_id, "bob")
    assert discover(alice, 0.0).publishers("/chatter") == []
    bob.writer("/chatter", STRING, QoS())
    found = discover(alice, 60.0, lambda graph: graph.publishers("/chatter"))
    assert found.types()["/chatter"] == [STRING]
    named = discover(alice, 0.0, names=True).publishers("/chatter")
    assert [end.node for end in named] == ["" if kind == "memory" else "bob"]


@pytest.mark.parametrize("kind", ["memory", "dds"], indirect=True)
def test_who_takes_a_message_can_ask_who_sent_it(join: Join, domain_id: int, eventually: Eventually) -> None:
    alice, bob = join(domain_id, "alice"), join(domain_id, "bob")
    senders: dict[str, bytes] = {}
    writers = [transport.writer("/map", STRING, LATCHED) for transport in (alice, bob)]
    for writer, name in zip(writers, ("alice", "bob"), strict=True):
        writer.write(text(name))
    bob.reader(
        "/map", STRING, replace(LATCHED, depth=10), lambda data: senders.update({decode(data, STRING).data: bob.source})
    )
    assert eventually(lambda: len(senders) == 2)
    ends = discover(bob, 20.0, lambda graph: len(graph.publishers("/map")) == 2).publishers("/map")
    assert set(senders.values()) == {end.gid for end in ends}
    if isinstance(bob, DdsTransport):
        names = {end.gid: end.node for end in ends}
        assert {name: names[gid] for name, gid in senders.items()} == {"alice": "alice", "bob": "bob"}


def test_a_transport_that_is_closed_tells_of_nobody(join: Join, domain_id: int) -> None:
    alice = join(domain_id, "alice")
    alice.close()
    with pytest.raises(TransportError, match="the transport is closed"):
        alice.graph()
