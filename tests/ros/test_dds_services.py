"""How services look on a DDS network, as rmw_cyclonedds_cpp of ROS 2 Jazzy was seen to write them."""

from __future__ import annotations

import struct
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from cyclonedds.core import DDSException
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import String, encode
from graphengine.ros.domain import Domain
from graphengine.ros.transports.dds import cyclone
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.dds.dds_services import identity, with_header, without_header
from graphengine.ros.transports.dds.idl import idl_type
from tests.ros.conftest import OpenDds, StartPeer
from tests.ros.contract import STRING
from tests.ros.test_malformed import send_forged
from tests.waiting import eventually

TRIGGER = "std_srvs/srv/Trigger"
# The first call of a client on rmw_cyclonedds_cpp, as it came: encapsulation, client, number, a placeholder and padding.
SEEN = bytes.fromhex("00010000 e766f6aa23160de2 0100000000000000 00000000")
QUESTION, ANSWER = (encode(DEFINITIONS.initial(f"{TRIGGER}_{part}")) for part in ("Request", "Response"))
CLIENT = 0xE20D1623AAF666E7


@pytest.fixture
def bob(dds: OpenDds) -> DdsTransport:
    return dds("bob")


class Participant:
    """A program on Cyclone DDS that opens single endpoints."""

    def __init__(self, domain: Domain) -> None:
        self.participant = cyclone.join(domain, "enclave=/;")
        self.topics: dict[str, Any] = {}
        self.opened: list[Any] = []

    def open(self, make: Any, topic: str, part: str, user_data: str) -> Any:
        if topic not in self.topics:
            self.topics[topic] = Topic(self.participant, topic, idl_type(f"{TRIGGER}_{part}", is_call=True))
        self.opened.append(make(self.participant, self.topics[topic], qos=cyclone.endpoint_qos(QoS(), user_data)))
        return self.opened[-1]


def heard(reader: Any) -> list[bytes]:
    """What a reader holds, once it holds something."""
    taken: list[tuple[bytes, int]] = []
    assert eventually(lambda: taken, lambda: taken.extend(cyclone.take(reader)))
    return [data for data, _ in taken]


@pytest.fixture
def peer(domain: Domain) -> Iterator[Participant]:
    opened = Participant(domain)
    yield opened
    cyclone.leave(domain, opened.participant)


def test_the_call_header_is_between_encapsulation_and_message() -> None:
    message = SEEN[:4] + SEEN[20:]
    assert without_header(SEEN) == (CLIENT, 1, message)
    assert with_header(message, CLIENT, 1) == SEEN
    assert with_header(message[:5], CLIENT, 1) == SEEN  # ROS 2 ends a message with its last byte, DDS pads it


@given(st.integers(0, 2**64 - 1), st.integers(-(2**63), 2**63 - 1), st.binary(min_size=1), st.booleans())
def test_a_message_is_unchanged_after_adding_and_removing_a_header(
    client: int, number: int, body: bytes, little: bool
) -> None:
    message = bytes((0, little, 0, 0)) + body
    sent = with_header(message, client, number)
    assert len(sent) % 4 == 0
    assert struct.unpack_from("<Qq" if little else ">Qq", sent, 4) == (client, number)
    found = without_header(sent)
    assert found is not None
    assert found[:2] == (client, number)
    assert found[2].rstrip(b"\0") == message.rstrip(b"\0")


@given(st.binary(max_size=40))
def test_any_bytes_have_a_header_or_are_reported_as_malformed(data: bytes) -> None:
    found = without_header(data)
    assert (found is not None) == (len(data) > 20 and data[1] in (0, 1))


def test_identities_are_written_as_rmw_cyclonedds_cpp_writes_them() -> None:
    participant = bytes.fromhex("01105c5cf8578dcfc02b1d8b000001c1")
    assert identity(participant, 8) == " 1.10.5c.5c.f8.57.8d.cf.c0.2b.1d.8b.0.0.0.8"


def test_reader_and_writer_of_a_service_announce_identity_and_type_hashes(bob: DdsTransport, peer: Participant) -> None:
    server = bob.server("/trigger", TRIGGER, QoS(), lambda request_id, data: None)
    asking = peer.open(DataWriter, "rq/triggerRequest", "Request", "")
    hearing = peer.open(DataReader, "rr/triggerReply", "Response", "")
    assert eventually(lambda: cyclone.readers_of(asking) and cyclone.writers_of(hearing))
    (asked,), (answering,) = cyclone.readers_of(asking).values(), cyclone.writers_of(hearing).values()
    own = identity(asked.gid, 1)
    assert asked.user_data.decode() == f"serviceid={own};typehash={DEFINITIONS.type_hash(f'{TRIGGER}_Request')};"
    assert answering.user_data.decode() == f"serviceid={own};typehash={DEFINITIONS.type_hash(f'{TRIGGER}_Response')};"
    server.close()
    assert eventually(lambda: not cyclone.readers_of(asking) and not cyclone.writers_of(hearing))


def test_a_response_waits_for_the_discovery_of_the_clients_reader(bob: DdsTransport, peer: Participant) -> None:
    asked: list[bytes] = []
    server = bob.server("/trigger", TRIGGER, QoS(), lambda request_id, data: asked.append(request_id))
    asking = peer.open(DataWriter, "rq/triggerRequest", "Request", "clientid=ours;")
    other = peer.open(DataReader, "rr/triggerReply", "Response", "clientid=another;")
    assert eventually(lambda: cyclone.readers_of(asking) and cyclone.writers_of(other))
    assert cyclone.write(asking, SEEN) == 0
    assert eventually(lambda: len(asked) == 1)
    server.answer(asked[0], ANSWER)
    assert cyclone.take(other) == []
    ours = peer.open(DataReader, "rr/triggerReply", "Response", "clientid=ours;")
    assert heard(ours) == [with_header(ANSWER, CLIENT, 1)]


def test_a_held_response_is_discarded_when_the_client_leaves(bob: DdsTransport, peer: Participant) -> None:
    asked: list[bytes] = []
    server = bob.server("/trigger", TRIGGER, QoS(), lambda request_id, data: asked.append(request_id))
    asking = peer.open(DataWriter, "rq/triggerRequest", "Request", "clientid=ours;")
    assert eventually(lambda: cyclone.readers_of(asking))
    cyclone.write(asking, SEEN)
    assert eventually(lambda: asked)
    server.answer(asked[0], ANSWER)
    cyclone.delete(asking)
    again = peer.open(DataReader, "rr/triggerReply", "Response", "clientid=ours;")
    own = bob.client("/trigger", TRIGGER, QoS(), lambda number, data: None)
    assert eventually(lambda: own.ready and cyclone.writers_of(again))
    server.answer(asked[0], ANSWER)
    assert cyclone.take(again) == []


def test_clients_and_servers_of_early_versions_have_no_identity(bob: DdsTransport, peer: Participant) -> None:
    client = bob.client("/trigger", TRIGGER, QoS(), lambda number, data: None)
    peer.open(DataReader, "rq/triggerRequest", "Request", "")
    assert not client.ready
    peer.open(DataWriter, "rr/triggerReply", "Response", "")
    assert eventually(lambda: client.ready)
    asked: list[bytes] = []
    server = bob.server("/early", TRIGGER, QoS(), lambda request_id, data: asked.append(request_id))
    asking = peer.open(DataWriter, "rq/earlyRequest", "Request", "")
    hearing = peer.open(DataReader, "rr/earlyReply", "Response", "")
    assert eventually(lambda: cyclone.readers_of(asking) and cyclone.writers_of(hearing))
    cyclone.write(asking, SEEN)
    assert eventually(lambda: asked)
    server.answer(asked[0], ANSWER)
    assert eventually(lambda: cyclone.take(hearing))


def test_a_reader_and_a_writer_with_different_identities_are_not_a_server(bob: DdsTransport, peer: Participant) -> None:
    client = bob.client("/trigger", TRIGGER, QoS(), lambda number, data: None)
    asked = peer.open(DataReader, "rq/triggerRequest", "Request", "serviceid=one;")
    answering = peer.open(DataWriter, "rr/triggerReply", "Response", "serviceid=another;")
    assert eventually(lambda: cyclone.writers_of(asked) and cyclone.readers_of(answering))
    assert not client.ready
    peer.open(DataWriter, "rr/triggerReply", "Response", "serviceid=one;")
    assert eventually(lambda: client.ready)


def test_responses_to_other_clients_and_unknown_calls_are_ignored(bob: DdsTransport, peer: Participant) -> None:
    answers: list[int] = []
    client = bob.client("/trigger", TRIGGER, QoS(), lambda number, data: answers.append(number))
    asked = peer.open(DataReader, "rq/triggerRequest", "Request", "serviceid=one;")
    answering = peer.open(DataWriter, "rr/triggerReply", "Response", "serviceid=one;")
    assert eventually(lambda: client.ready and cyclone.readers_of(answering))
    client.call(QUESTION)
    call = without_header(heard(asked)[0])
    assert call is not None
    for to, number in ((call[0] ^ 1, 1), (call[0], 2), (call[0], 0), (call[0], -1), (call[0], 1), (call[0], 1)):
        assert cyclone.write(answering, with_header(ANSWER, to, number)) == 0
    assert eventually(lambda: answers)
    client.call(QUESTION)
    cyclone.write(answering, with_header(ANSWER, call[0], 2))
    assert eventually(lambda: len(answers) == 2)
    assert answers == [1, 2]


@pytest.mark.parametrize("data", [b"\0\1\0\0", SEEN[:12], SEEN[:20], b"\0\1\0\0rubbish!"])
def test_a_request_without_a_header_or_a_message_is_dropped_and_counted(
    bob: DdsTransport, domain_id: int, start_peer: StartPeer, data: bytes
) -> None:
    asked: list[bytes] = []
    server = bob.server("/trigger", TRIGGER, QoS(), lambda request_id, data: asked.append(request_id))
    ping = bob.writer("/ping", STRING, QoS())
    start_peer("ask")
    assert eventually(lambda: ping.matched and cyclone.writers_of(server.entities[0]))
    (client,) = cyclone.writers_of(server.entities[0]).values()
    assert eventually(lambda: bob.malformed, lambda: send_forged(domain_id, client.gid, data))
    assert set(bob.malformed) == {"/trigger"}
    assert asked == []
    assert eventually(lambda: asked, lambda: ping.write(encode(String("call"))))


def test_a_service_that_cannot_be_opened_leaves_no_entities(bob: DdsTransport, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object, **options: object) -> None:
        raise DDSException(DDSException.DDS_RETCODE_OUT_OF_RESOURCES)

    with monkeypatch.context() as patched:
        patched.setattr("graphengine.ros.transports.dds.dds.DataWriter", refuse)
        with pytest.raises(TransportError, match="/trigger cannot be created"):
            bob.server("/trigger", TRIGGER, QoS(), lambda request_id, data: None)
    bob.server("/trigger", "std_srvs/srv/SetBool", QoS(), lambda request_id, data: None)


def test_a_service_of_another_type_cannot_have_the_same_name(bob: DdsTransport) -> None:
    first = bob.client("/trigger", TRIGGER, QoS(), lambda number, data: None)
    told = r"^/trigger has the type std_srvs/srv/Trigger_\w+ in this process; it cannot also have the type std_srvs"
    with pytest.raises(TransportError, match=told):
        bob.server("/trigger", "std_srvs/srv/SetBool", QoS(), lambda request_id, data: None)
    first.close()
    bob.server("/trigger", "std_srvs/srv/SetBool", QoS(), lambda request_id, data: None).close()
    bob.reader("/triggerRequest", "std_msgs/msg/String", QoS(), lambda data: None)


def test_concurrent_threads_read_the_right_policies(domain_id: int) -> None:
    domain = Domain(domain_id, "OFF")
    participant = cyclone.join(domain, "")
    texts = ["", "clientid=1;", "x" * 500]
    topics = {text: Topic(participant, f"rt/{len(text)}", idl_type("std_msgs/msg/Empty")) for text in texts}
    writers = [DataWriter(participant, topic, qos=cyclone.endpoint_qos(QoS(), text)) for text, topic in topics.items()]
    plain = cyclone.endpoint_qos(QoS(), "")
    readers = {text: DataReader(participant, topic, qos=plain) for text, topic in topics.items()}
    wrong: list[bytes] = []

    def read(text: str) -> None:
        for _ in range(1000):
            (peer,) = cyclone.writers_of(readers[text]).values()
            if peer.user_data != text.encode():
                wrong.append(peer.user_data)

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    threads = [threading.Thread(target=read, args=(text,)) for text in texts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    sys.setswitchinterval(interval)
    cyclone.leave(domain, participant)
    del writers
    assert wrong == []
