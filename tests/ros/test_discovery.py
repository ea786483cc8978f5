"""What a participant learns of peers that are unlike itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

import numpy as np
import pytest
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from hypothesis import given
from hypothesis import strategies as st

from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import Gid, NodeEntitiesInfo, ParticipantEntitiesInfo, String, encode
from graphengine.messages.qos import LATCHED
from graphengine.ros.domain import Domain
from graphengine.ros.transport import discover
from graphengine.ros.transports.dds import cyclone, discovery
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.dds.discovery import ros_type
from graphengine.ros.transports.dds.idl import idl_type
from tests.ros.conftest import OpenDds
from tests.waiting import eventually

Join: TypeAlias = "Callable[[str], Stranger]"

GIDS = st.binary(min_size=16, max_size=16)
NAMES = st.text("/abc_1", max_size=9)
STRING = "std_msgs/msg/String"


@pytest.fixture
def domain(domain_id: int) -> Domain:
    return Domain(domain_id, "OFF")


@pytest.fixture
def alice(dds: OpenDds) -> DdsTransport:
    return dds("alice")


class Stranger:
    """A participant that tells of no nodes."""

    def __init__(self, domain: Domain, user_data: str) -> None:
        self.participant = cyclone.join(domain, user_data)
        self.writers: list[Any] = []

    def write(self, topic: str, user_data: str = "") -> Any:
        """A writer of texts on a DDS topic."""
        described = Topic(self.participant, topic, idl_type(STRING))
        policies = cyclone.endpoint_qos(discovery.TELLING, user_data)
        self.writers.append(DataWriter(self.participant, described, qos=policies))
        return self.writers[-1]


@pytest.fixture
def join(domain: Domain) -> Iterator[Join]:
    """A stranger with that user data."""
    joined: list[Stranger] = []

    def join(user_data: str) -> Stranger:
        joined.append(Stranger(domain, user_data))
        return joined[-1]

    yield join
    for stranger in joined:
        cyclone.leave(domain, stranger.participant)


def test_discovery_does_not_wait_for_a_program_without_a_ros_node(alice: DdsTransport, join: Join) -> None:
    join("").write("rt/chatter")
    assert eventually(lambda: alice.graph().publishers("/chatter"))
    graph = discover(alice, 0.0, names=True)
    (writer,) = graph.publishers("/chatter")
    assert (writer.full_node, writer.type_hash) == ("", "")
    assert (graph.complete, graph.named) == (True, True)


def test_discovery_waits_for_a_ros_process_that_has_announced_nothing(alice: DdsTransport, join: Join) -> None:
    assert alice.graph().complete
    silent = join("enclave=/;")
    graph = alice.graph()
    assert (graph.complete, graph.named) == (False, False)
    silent.write("rt/chatter")
    graph = alice.graph()
    assert (graph.complete, graph.named) == (True, False)


def test_user_data_name_the_node_of_a_process_that_announces_none(alice: DdsTransport, dds: OpenDds) -> None:
    bob = dds("bob", node_namespace="/robot", announces=False)
    bob.writer("/chatter", STRING, QoS())
    server = bob.server("/add", "std_srvs/srv/Trigger", QoS(), lambda request_id, data: None, "/other/node")
    bob.client("/call", "std_srvs/srv/Trigger", QoS(), lambda number, data: None)

    def services() -> dict[str, tuple[list[str], list[str]]]:
        return {
            node.name: ([name for name, _ in node.servers], [name for name, _ in node.clients])
            for node in alice.graph().nodes
        }

    assert eventually(
        lambda: services() == {"/alice": ([], []), "/other/node": (["/add"], []), "/robot/bob": ([], ["/call"])}
    )
    graph = alice.graph()
    assert (graph.complete, graph.named) == (True, True)
    assert {end.topic for end in graph.endpoints if end.node != "alice"} == {"/chatter"}
    (writer,) = graph.publishers("/chatter")
    assert (writer.full_node, writer.type_hash) == ("/robot/bob", DEFINITIONS.type_hash(STRING))
    server.close()
    bob.close()
    assert eventually(lambda: list(services()) == ["/alice"])


def test_endpoints_that_name_an_announced_node_are_endpoints_of_this_node(alice: DdsTransport, dds: OpenDds) -> None:
    dds("bob", announces=False).server("/add", "std_srvs/srv/Trigger", QoS(), lambda request_id, data: None)
    dds("bob").client("/call", "std_srvs/srv/Trigger", QoS(), lambda number, data: None)
    both = [("/add", "std_srvs/srv/Trigger")], [("/call", "std_srvs/srv/Trigger")]
    assert eventually(
        lambda: (
            [(list(node.servers), list(node.clients)) for node in alice.graph().nodes if node.name == "/bob"] == [both]
        )
    )


@pytest.mark.parametrize(
    "user_data", ["node=;", "node=bob;", "node=/bob", "mynode=/bob;", "typehash=node=/bob;", "node=\xff"]
)
def test_user_data_without_a_node_name_are_ignored(alice: DdsTransport, join: Join, user_data: str) -> None:
    join("").write("rt/chatter", user_data)
    assert eventually(lambda: alice.graph().publishers("/chatter"))
    assert [end.full_node for end in alice.graph().publishers("/chatter")] == [""]


def test_malformed_announcements_are_ignored(alice: DdsTransport, dds: OpenDds, join: Join) -> None:
    liar = join("").write(discovery.TOPIC)
    assert cyclone.write(liar, encode(String("rubbish"))) == 0
    dds("bob").writer("/chatter", STRING, QoS())
    assert eventually(lambda: [end.node for end in alice.graph().publishers("/chatter")] == ["bob"])


def test_a_node_that_left_before_the_next_graph_call_is_absent(alice: DdsTransport, dds: OpenDds) -> None:
    ready: list[bytes] = []
    alice.reader("/chatter", STRING, LATCHED, ready.append)
    alice.graph()
    bob = dds("bob")
    bob.writer("/chatter", STRING, LATCHED).write(encode(String("told")))
    assert eventually(lambda: ready)
    bob.close()
    assert eventually(lambda: {end.node for end in alice.graph().endpoints} == {"alice"})
    assert eventually(lambda: alice.graph().complete and alice.graph().named)


def test_services_and_foreign_dds_topics_are_not_ros_topics(alice: DdsTransport, join: Join) -> None:
    stranger = join("")
    for name in ("rq/addRequest", "rr/addReply", "rt", "plain", "other/rt/x"):
        stranger.write(name)
    stranger.write("rt/marker")
    assert {end.topic for end in alice.graph().endpoints if not end.node} == {"/marker"}


@given(
    st.binary(min_size=16, max_size=16),
    st.lists(st.tuples(NAMES, NAMES, st.lists(GIDS, max_size=3), st.lists(GIDS, max_size=3)), max_size=3),
)
def test_the_handmade_announcement_equals_the_encoded_message(
    participant: bytes, nodes: list[tuple[str, str, list[bytes], list[bytes]]]
) -> None:
    data = discovery.announcement(participant, [discovery.DiscoveredNode(*node) for node in nodes])

    def gids(listed: list[bytes]) -> list[Any]:
        return [Gid(np.frombuffer(gid, np.uint8)) for gid in listed]

    infos = [NodeEntitiesInfo(space, name, gids(readers), gids(writers)) for space, name, readers, writers in nodes]
    assert data == encode(ParticipantEntitiesInfo(gids([participant])[0], infos))


@pytest.mark.parametrize(
    ("dds", "ros"),
    [
        ("nav_msgs::msg::dds_::Odometry_", "nav_msgs/msg/Odometry"),
        ("my_msgs::msg::dds_::Odd__", "my_msgs/msg/Odd_"),
        ("Shapes::ShapeType", "Shapes::ShapeType"),
        ("", ""),
    ],
)
def test_dds_type_names_become_ros_names(dds: str, ros: str) -> None:
    assert ros_type(dds) == ros
