"""The seam to Cyclone DDS: the two functions that are not public, and the configuration of domains."""

from __future__ import annotations

import importlib.metadata
import os
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from cyclonedds import _clayer
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import String, encode
from graphengine.ros.domain import Domain
from graphengine.ros.transports.dds import cyclone
from graphengine.ros.transports.dds.idl import idl_type

STRING = "std_msgs/msg/String"


@pytest.fixture
def participant(domain_id: int) -> Iterator[Any]:
    domain = Domain(domain_id, "OFF")
    joined = cyclone.join(domain, "")
    yield joined
    cyclone.leave(domain, joined)


@pytest.fixture
def endpoints(participant: Any) -> tuple[Any, Any]:
    topic = Topic(participant, "rt/chatter", idl_type(STRING))
    policies = cyclone.endpoint_qos(QoS(depth=200), "")
    return DataWriter(participant, topic, qos=policies), DataReader(participant, topic, qos=policies)


def test_cyclonedds_has_the_pinned_version() -> None:
    assert importlib.metadata.version("cyclonedds") == "11.0.1"


def test_the_private_functions_have_the_expected_arguments(endpoints: tuple[Any, Any]) -> None:
    writer, reader = endpoints
    data = encode(String("hi"))
    assert _clayer.ddspy_write(writer._ref, data) == 0
    ((taken, info),) = _clayer.ddspy_take(reader._ref, 0x7F, 10)
    assert taken == data
    assert info.valid_data is True
    assert _clayer.ddspy_take(reader._ref, 0x7F, 10) == []


def test_handles_of_deleted_entities_give_negative_codes(endpoints: tuple[Any, Any]) -> None:
    for entity in endpoints:
        cyclone.delete(entity)
        cyclone.delete(entity)
    assert _clayer.ddspy_write(endpoints[0]._ref, encode(String("hi"))) < 0
    assert _clayer.ddspy_take(endpoints[1]._ref, 0x7F, 10) < 0


def test_repeated_takes_empty_the_queue(endpoints: tuple[Any, Any]) -> None:
    writer, reader = endpoints
    for number in range(150):
        assert cyclone.write(writer, encode(String(str(number)))) == 0
    taken = []
    while batch := cyclone.take(reader):
        taken += [data for data, _ in batch]
    assert taken == [encode(String(str(number))) for number in range(150)]


@pytest.mark.parametrize("data", [b"", b"\0\1", b"\0\1\0\0", b"\0\1\0\0\xff\xff\xff\xff", b"\0\7\0\0abcd"])
def test_malformed_bytes_give_an_error_code(endpoints: tuple[Any, Any], data: bytes) -> None:
    assert cyclone.write(endpoints[0], data) < 0
    assert "Bad parameter" in cyclone.reason(cyclone.write(endpoints[0], data))


def parsed(domain: Domain) -> list[dict[str, Any]]:
    found = []
    for text in cyclone.configurations(domain):
        root = ElementTree.fromstring(text)
        peers = [peer.get("address") for peer in root.iter("Peer")]
        found.append({element.tag: element.text for element in root.iter() if element.text} | {"peers": peers})
    return found


SIZE = {"FragmentSize": "14600B", "MaxMessageSize": "14720B"} if sys.platform == "linux" else {}


def test_the_subnet_is_searched_by_multicast_and_the_host_by_unicast() -> None:
    both, loopback = parsed(Domain(0, "SUBNET"))
    expected = SIZE | {"AllowMulticast": "true", "ParticipantIndex": "auto", "MaxAutoParticipantIndex": "32"}
    assert both == loopback == expected | {"peers": ["127.0.0.1"]}
    assert "autodetermine" in cyclone.configurations(Domain())[0]
    assert "autodetermine" not in cyclone.configurations(Domain())[1]


def test_the_range_localhost_has_no_multicast() -> None:
    assert all(found["AllowMulticast"] == "false" for found in parsed(Domain(0, "LOCALHOST")))


def test_the_range_off_has_a_tag_of_this_process() -> None:
    (found,) = parsed(Domain(0, "OFF", ("127.0.0.1",)))
    tag = f"ros_discovery_off_{os.getpid()}"
    assert found == SIZE | {"AllowMulticast": "false", "ParticipantIndex": "none", "Tag": tag, "peers": []}


def test_the_range_system_default_is_an_empty_configuration() -> None:
    assert cyclone.configurations(Domain(0, "SYSTEM_DEFAULT")) == [""]


def test_static_peers_are_resolved_to_addresses() -> None:
    peers = parsed(Domain(0, "SUBNET", ("localhost", "192.0.2.7")))[0]["peers"]
    assert peers == ["127.0.0.1", "127.0.0.1", "192.0.2.7"]
    with pytest.raises(TransportError, match="ROS_STATIC_PEERS has an unknown host 'no such host'"):
        cyclone.join(Domain(0, "SUBNET", ("no such host",)), "")


def test_the_configuration_of_the_user_is_last_and_so_wins() -> None:
    own = '<CycloneDDS><Domain Id="any"><General><AllowMulticast>spdp</AllowMulticast></General></Domain></CycloneDDS>'
    (text,) = cyclone.configurations(Domain(0, "LOCALHOST", (), own))
    assert text.endswith(f",{own}")
    assert "Interfaces" not in text


def test_the_configuration_of_the_user_is_used(domain_id: int, capfd: pytest.CaptureFixture[str]) -> None:
    own = '<CycloneDDS><Domain Id="any"><NoSuchElement/></Domain></CycloneDDS>'
    with pytest.raises(TransportError, match=f"cannot join domain {domain_id}"):
        cyclone.join(Domain(domain_id, "LOCALHOST", (), own), "")
    assert "NoSuchElement" in capfd.readouterr().err


def test_the_configuration_of_the_user_can_change_the_datagram_size(domain_id: int) -> None:
    sizes = "<General><FragmentSize>1344B</FragmentSize><MaxMessageSize>65500B</MaxMessageSize></General>"
    own = f'<CycloneDDS><Domain Id="any">{sizes}</Domain></CycloneDDS>'
    domain = Domain(domain_id, "LOCALHOST", (), own)
    cyclone.leave(domain, cyclone.join(domain, ""))


def test_a_domain_stays_open_until_its_last_participant_leaves(domain_id: int) -> None:
    domain = Domain(domain_id, "OFF")
    first, second = cyclone.join(domain, ""), cyclone.join(domain, "")
    cyclone.leave(domain, first)
    assert second.guid
    cyclone.leave(domain, second)
    other = Domain(domain_id, "LOCALHOST")
    cyclone.leave(other, cyclone.join(other, ""))


def test_a_joined_domain_cannot_be_joined_with_another_configuration(domain_id: int) -> None:
    stranger = DomainParticipant(domain_id)
    with pytest.raises(TransportError, match=f"cannot join domain {domain_id}"):
        cyclone.join(Domain(domain_id, "LOCALHOST"), "")
    cyclone.delete(stranger)


@pytest.mark.parametrize("make", [DataWriter, DataReader])
def test_an_entity_is_deleted_without_the_garbage_collector(domain_id: int, make: Callable[..., Any]) -> None:
    domain = Domain(domain_id, "OFF")
    participant = cyclone.join(domain, "")
    entity = make(participant, Topic(participant, "rt/chatter", idl_type(STRING)))
    cyclone.leave(domain, participant)
    assert entity._ref > 0
    cyclone.delete(entity)


def test_the_gid_of_a_messages_writer_is_found_from_the_handle(endpoints: tuple[Any, Any]) -> None:
    writer, reader = endpoints
    assert cyclone.write(writer, encode(String("hi"))) == 0
    ((_, handle),) = cyclone.take(reader)
    assert cyclone.writer_of(reader, handle).gid == writer.guid.bytes
    cyclone.delete(writer)
    assert cyclone.writer_of(reader, handle) == (b"", b"")


@pytest.mark.parametrize(
    "qos",
    [
        QoS(liveliness="automatic"),
        QoS(depth=7, reliability="bestEffort", liveliness="automatic"),
        QoS("keepAll", 0, durability="transientLocal", lifespan=10.0, liveliness="automatic"),
        QoS(deadline=0.25, liveliness="manualByTopic", lease_duration=1.5),
    ],
)
def test_policies_are_read_back_as_the_same_profile(participant: Any, qos: QoS) -> None:
    writer = DataWriter(participant, Topic(participant, "rt/t", idl_type(STRING)), qos=cyclone.endpoint_qos(qos, ""))
    assert cyclone.read_qos(writer.get_qos()) == qos
