"""Services of peers on RMWs that are none of ours: nothing crosses, and people are told."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.messages.messages import decode, encode
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.rcl.rcl import RclTransport
from tests.ros import needs
from tests.ros.contract import AnyTransport
from tests.ros.service_contract import NAME, Client, Server, foreign
from tests.waiting import eventually


@pytest.fixture
def fast(domain: Domain) -> Iterator[RclTransport]:
    """A node on Fast DDS."""
    transport = RclTransport(JoinOptions(domain, "fast"))
    yield transport
    transport.close()


@pytest.mark.parametrize("kind", [pytest.param("dds", marks=pytest.mark.ros(needs.fast_dds()))])
def test_a_client_on_fast_dds_is_reported_as_unreachable(bob: AnyTransport, fast: RclTransport) -> None:
    service_type = "rcl_interfaces/srv/GetParameters"
    asked: list[bytes] = []
    bob.server(NAME, service_type, QoS(), lambda request_id, data: asked.append(data))
    client = fast.client(NAME, service_type, QoS(), lambda number, data: None)
    assert eventually(lambda: foreign(bob) == ["a client on rmw_fastrtps_cpp is unreachable"])
    assert eventually(lambda: foreign(fast) == ["a server on rmw_cyclonedds_cpp is unreachable"])
    assert eventually(lambda: client.ready)  # ROS 2 does not know better
    request = DEFINITIONS.initial(f"{service_type}_Request")
    # Of what comes without a header, this would be taken for one and a request: it has two texts where there were four.
    request.names = ["aaaa", "\5", "", ""]
    client.call(encode(request))
    assert eventually(lambda: bob.malformed == {NAME: 1})
    request.names = ["a"]
    client.call(encode(request))  # this one, Cyclone DDS drops itself
    assert eventually(lambda: bob.malformed == {NAME: 2})
    assert asked == []
    own = bob.client(NAME, service_type, QoS(), lambda number, data: None)
    assert eventually(lambda: own.ready)
    own.call(encode(request))
    assert eventually(lambda: [decode(data, f"{service_type}_Request") for data in asked] == [request])


@pytest.mark.parametrize("kind", [pytest.param("dds", marks=pytest.mark.ros(needs.fast_dds()))])
def test_a_server_on_fast_dds_is_not_ready_and_is_reported(bob: AnyTransport, fast: RclTransport) -> None:
    client, server = Client(bob), Server(fast)
    assert eventually(lambda: foreign(bob) == ["a server on rmw_fastrtps_cpp is unreachable"])
    assert eventually(lambda: foreign(fast) == ["a client on rmw_cyclonedds_cpp is unreachable"])
    assert not client.end.ready
    client.call("a")
    sibling = Client(fast)
    assert eventually(lambda: sibling.end.ready)
    sibling.call("b")
    assert eventually(lambda: server.texts == ["b"])
    server.answer(0)
    assert eventually(lambda: sibling.answers == {1: "b!"})
    assert client.answers == {}
    own = Server(bob)
    assert eventually(lambda: client.end.ready)
    client.call("c")
    assert eventually(lambda: own.texts == ["c"])
