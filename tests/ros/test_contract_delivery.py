"""One contract for every transport: what is written arrives, once, in order and whole, or not at all."""

from __future__ import annotations

import logging
import threading
from dataclasses import replace

import pytest

from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import decode
from graphengine.messages.qos import LATCHED
from graphengine.ros.transport import Writer, discover
from graphengine.ros.transports.memory.memory import MemoryTransport
from tests.ros.contract import (
    COMPOSED,
    FAITHFUL,
    NETWORKED,
    RCLPY,
    STRING,
    AnyTransport,
    Inbox,
    Join,
    chatter,
    connect,
    text,
)
from tests.waiting import PATIENCE, eventually


def test_messages_arrive_in_the_order_they_were_written(join: Join) -> None:
    writer, inbox = chatter(join, QoS(depth=200))
    written = [str(number) for number in range(100)]
    for value in written:
        writer.write(text(value))
    assert eventually(lambda: len(inbox.texts) >= 100)
    assert inbox.texts == written


def test_a_reader_gets_messages_of_a_writer_on_the_same_transport(alice: AnyTransport) -> None:
    inbox = Inbox()
    writer = alice.writer("/chatter", STRING, QoS())
    alice.reader("/chatter", STRING, QoS(), inbox)
    connect(writer, inbox)
    writer.write(text("self"))
    assert eventually(lambda: inbox.texts == ["self"])


@pytest.mark.parametrize("kind", ["memory", *FAITHFUL], indirect=True)
def test_large_messages_arrive_whole(join: Join) -> None:
    writer, inbox = chatter(join)
    writer.write(text("x" * 200_000))
    assert eventually(lambda: inbox.texts == ["x" * 200_000])


@pytest.mark.parametrize("kind", ["memory", "dds", RCLPY], indirect=True)
def test_ten_megabytes_arrive_whole(join: Join) -> None:
    writer, inbox = chatter(join)
    large = "0123456789" * 1_000_000
    writer.write(text(large))
    writer.write(text("after"))
    assert eventually(lambda: len(inbox.texts) == 2)
    assert inbox.texts == [large, "after"]


@pytest.mark.parametrize(
    ("kind", "number"),
    [("memory", 1000), ("dds", 1000), pytest.param("rclpy", 300, marks=RCLPY.marks)],
    indirect=["kind"],
)
def test_many_topics_are_opened_matched_served_and_closed(
    alice: AnyTransport, number: int, caplog: pytest.LogCaptureFixture
) -> None:
    inboxes = [Inbox() for _ in range(number)]
    readers = [alice.reader(f"/topic{n}", STRING, QoS(), inbox) for n, inbox in enumerate(inboxes)]
    writers = [alice.writer(f"/topic{n}", STRING, QoS()) for n in range(number)]
    assert eventually(lambda: all(writer.matched for writer in writers))
    for n, writer in enumerate(writers):
        writer.write(text(str(n)))
    assert eventually(lambda: all(inbox.texts for inbox in inboxes))
    assert [inbox.texts for inbox in inboxes] == [[str(n)] for n in range(number)]
    for end in (*readers[::2], *writers[::2]):
        end.close()
    writers[1].write(text("still there"))
    assert eventually(lambda: inboxes[1].texts == ["1", "still there"])
    assert caplog.records == []


def test_a_late_joiner_of_a_latched_topic_gets_the_last_message(join: Join) -> None:
    writer = join("alice").writer("/map", STRING, LATCHED)
    for value in ("old", "older", "last"):
        writer.write(text(value))
    inbox = Inbox()
    join("bob").reader("/map", STRING, LATCHED, inbox)
    assert eventually(lambda: inbox.texts == ["last"])
    writer.write(text("new"))
    assert eventually(lambda: inbox.texts == ["last", "new"])


def test_a_late_joiner_gets_the_last_message_of_each_latched_writer(join: Join) -> None:
    alice, inbox = join("alice"), Inbox()
    for robot in ("first", "second", "third"):
        writer = alice.writer("/tf_static", STRING, LATCHED)
        writer.write(text(f"old {robot}"))
        writer.write(text(robot))
    join("bob").reader("/tf_static", STRING, replace(LATCHED, depth=100), inbox)
    assert eventually(lambda: len(inbox.texts) == 3)
    assert sorted(inbox.texts) == ["first", "second", "third"]


@pytest.mark.parametrize(("kept", "wanted", "expected"), [(3, 10, "cde"), (10, 2, "de")])
def test_a_late_joiner_gets_as_many_messages_as_both_depths_allow(
    join: Join, kept: int, wanted: int, expected: str
) -> None:
    writer = join("alice").writer("/map", STRING, replace(LATCHED, depth=kept))
    for value in "abcde":
        writer.write(text(value))
    inbox = Inbox()
    # A reader that keeps fewer may still be given more, where it empties its queue while they come.
    join("bob").reader("/map", STRING, replace(LATCHED, depth=wanted), inbox)
    assert eventually(lambda: "".join(inbox.texts).endswith(expected))
    assert len(inbox.texts) <= kept


def test_a_late_joiner_of_a_volatile_topic_gets_no_old_messages(join: Join) -> None:
    writer = join("alice").writer("/chatter", STRING, QoS())
    writer.write(text("old"))
    inbox = Inbox()
    join("bob").reader("/chatter", STRING, QoS(), inbox)

    assert eventually(lambda: inbox.texts, lambda: writer.write(text("new")))
    assert set(inbox.texts) == {"new"}


def test_a_closed_reader_gets_no_messages(bob: AnyTransport, join: Join) -> None:
    gone, stays = Inbox(), Inbox()
    reader = bob.reader("/chatter", STRING, QoS(), gone)
    bob.reader("/chatter", STRING, QoS(), stays)
    writer = join("alice").writer("/chatter", STRING, QoS())
    assert eventually(lambda: gone.texts and stays.texts, lambda: writer.write(text("a")))
    reader.close()
    heard = len(gone.texts)
    writer.write(text("b"))
    assert eventually(lambda: stays.texts[-1] == "b")
    assert len(gone.texts) == heard


@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_an_error_in_a_delivery_does_not_end_deliveries(join: Join, caplog: pytest.LogCaptureFixture) -> None:
    inbox = Inbox()

    def fail_at_times(data: bytes) -> None:
        inbox(data)
        if inbox.texts[-1] in "ab":
            raise RuntimeError("on purpose")

    join("bob").reader("/chatter", STRING, QoS(), fail_at_times)
    writer = join("alice").writer("/chatter", STRING, QoS())
    connect(writer, inbox)
    with caplog.at_level(logging.ERROR, "graphengine"):
        for value in "abc":
            writer.write(text(value))
        assert eventually(lambda: inbox.texts == ["a", "b", "c"])
    (record,) = caplog.records
    assert record.getMessage() == "/chatter: a message could not be delivered; further errors are not reported"


@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_log_messages_are_published_on_rosout(alice: AnyTransport, join: Join) -> None:
    assert not isinstance(alice, MemoryTransport)
    alice.log("warning", "wheel slips")
    entries: list[bytes] = []
    join("bob").reader("/rosout", "rcl_interfaces/msg/Log", replace(LATCHED, depth=100), entries.append)
    assert eventually(lambda: entries)
    entry = decode(entries[0], "rcl_interfaces/msg/Log")
    assert (entry.level, entry.name, entry.msg) == (entry.WARN, "alice", "wheel slips")
    alice.close()
    alice.log("error", "nobody hears this")


@pytest.mark.parametrize("kind", ["memory", "dds", COMPOSED], indirect=True)
def test_deliver_can_read_the_source_of_its_message(alice: AnyTransport, bob: AnyTransport) -> None:
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
    if bob.node:
        names = {end.gid: end.node for end in ends}
        assert {name: names[gid] for name, gid in senders.items()} == {"alice": "alice", "bob": "bob"}


# Leaving in the middle of it


class Flood:
    """Writes as fast as it goes in a thread of its own, until the writer refuses."""

    def __init__(self, writer: Writer) -> None:
        self.written = 0
        self.failure: BaseException | None = None
        self._writer = writer
        self.thread = threading.Thread(target=self._write)
        self.thread.start()

    def _write(self) -> None:
        try:
            while True:
                self._writer.write(text(str(self.written)))
                self.written += 1
        except BaseException as error:
            self.failure = error


@pytest.mark.parametrize("leave", ["writer", "transport"])
def test_a_writer_may_be_closed_during_delivery(alice: AnyTransport, join: Join, leave: str) -> None:
    inbox = Inbox()
    join("bob").reader("/chatter", STRING, QoS(), inbox)
    writer = alice.writer("/chatter", STRING, QoS())
    flood = Flood(writer)
    assert eventually(lambda: inbox.texts)
    (writer if leave == "writer" else alice).close()
    flood.thread.join()
    assert isinstance(flood.failure, TransportError)


@pytest.mark.parametrize("leave", ["reader", "transport"])
@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_a_reader_may_be_closed_during_delivery(join: Join, leave: str) -> None:
    gone, stays = Inbox(), Inbox()
    bob, carol = join("bob"), join("carol")
    reader = bob.reader("/chatter", STRING, QoS(), gone)
    carol.reader("/chatter", STRING, QoS(), stays)
    writer = join("alice").writer("/chatter", STRING, QoS())
    flood = Flood(writer)
    assert eventually(lambda: gone.texts and stays.texts)
    (reader if leave == "reader" else bob).close()
    heard, reached = len(gone.texts), len(stays.texts)
    assert eventually(lambda: len(stays.texts) > reached)
    assert len(gone.texts) == heard
    writer.close()
    flood.thread.join()
    assert isinstance(flood.failure, TransportError)


@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_closing_a_reader_waits_for_the_current_delivery(join: Join) -> None:
    taken: list[str] = []
    written, reached, go_on = threading.Event(), threading.Event(), threading.Event()
    stays, end = Inbox(), Inbox()

    def take(data: bytes) -> None:
        taken.append(decode(data, STRING).data)
        written.wait()
        if taken[-1] == "0":
            reached.set()
            go_on.wait()

    bob, alice = join("bob"), join("alice")
    reader = bob.reader("/chatter", STRING, QoS(), take)
    join("carol").reader("/chatter", STRING, QoS(), stays)
    writer = alice.writer("/chatter", STRING, QoS())
    connect(writer, stays)
    assert eventually(lambda: taken, lambda: writer.write(text("probe")))
    for number in range(5):
        writer.write(text(str(number)))
    assert eventually(lambda: "4" in stays.texts)
    written.set()
    assert reached.wait(PATIENCE)
    threading.Timer(0.1, go_on.set).start()
    reader.close()
    taken_before = len(taken)
    bob.reader("/end", STRING, QoS(), end)
    connect(alice.writer("/end", STRING, QoS()), end)
    assert len(taken) == taken_before


@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_a_slow_reader_does_not_delay_others(join: Join) -> None:
    taken, go_on = threading.Event(), threading.Event()
    inbox = Inbox()

    def dawdle(data: bytes) -> None:
        taken.set()
        go_on.wait()
        inbox(data)

    bob, alice = join("bob"), join("alice")
    bob.reader("/chatter", STRING, QoS(depth=2), dawdle)
    writer = alice.writer("/chatter", STRING, QoS(depth=2))
    assert eventually(lambda: writer.matched)
    assert eventually(taken.is_set, lambda: writer.write(text("first")))
    for number in range(100):
        writer.write(text(str(number)))
    writer.close()
    go_on.set()
    assert eventually(lambda: inbox.texts)
    assert inbox.texts[0] == "first"
