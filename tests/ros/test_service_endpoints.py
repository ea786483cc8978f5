"""A session's servers and clients: what arrives is frozen by tick, what is said leaves in order, sinks see events."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.messages import MessageError
from graphengine.ros.network import LiveNetwork
from graphengine.ros.service_endpoints import MAX_OPEN
from graphengine.ros.transports.memory.memory import MemoryTransport

SET_BOOL = "std_srvs/srv/SetBool"
EVENT = f"{SET_BOOL}_Event"
ASK, ANSWER = messages.message_class(f"{SET_BOOL}_Request"), messages.message_class(f"{SET_BOOL}_Response")
INFO = messages.message_class("service_msgs/msg/ServiceEventInfo")

CLOCK = EndpointClaim("/World/graph/clock", "graph", "/clock", "rosgraph_msgs/msg/Clock", "publish", QoS())


class Taker:
    """A sink: its topics, and what the events on them say."""

    def __init__(self) -> None:
        self.said: list[tuple[str, str, Any]] = []

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        self._take("said", claim, data)

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        for data in arrived:
            self._take("heard", claim, data)

    def _take(self, which: str, claim: EndpointClaim, data: bytes) -> None:
        self.said.append((which, claim.topic, messages.decode(data, claim.message_type)))


def claim(direction: str, node: str = "/World/graph/node") -> EndpointClaim:
    return EndpointClaim(node, "graph", "/light", SET_BOOL, direction, QoS())


def network(transport: MemoryTransport, complain: Any = print) -> LiveNetwork:
    return LiveNetwork(lambda domain: transport, 0, complain)


def asked(*wanted: bool) -> tuple[LiveNetwork, Any, list[bytes], Any]:
    """A network with a server that was asked; the answers that its peer gets, and the peer."""
    transport, answers = MemoryTransport(), list[bytes]()
    net = network(transport)
    server = net.server(claim("serve"), 1)
    peer = transport.client("/light", SET_BOOL, QoS(), lambda number, data: answers.append(data))
    for data in wanted:
        peer.call(messages.encode(ASK(data)))
    return net, server, answers, peer


def calling() -> tuple[LiveNetwork, Any, list[str], list[bytes], Any]:
    """A network with a client; what is complained of, the identities of requests that its peer gets, and the peer."""
    transport, said, requests = MemoryTransport(), list[str](), list[bytes]()
    net = network(transport, said.append)
    peer = transport.server("/light", SET_BOOL, QoS(), lambda request_id, data: requests.append(request_id))
    return net, net.client(claim("call")), said, requests, peer


def test_nodes_read_a_request_in_the_tick_after_its_arrival() -> None:
    net, server, _, peer = asked()
    net.freeze()
    peer.call(messages.encode(ASK(True)))
    assert server.take() == ()
    net.freeze()
    assert [request for _, request in server.take()] == [ASK(True)]
    assert server.take() == ()


def test_responses_and_messages_are_sent_in_order_at_the_end_of_the_tick() -> None:
    net, server, answers, _ = asked(True)
    clock = net.publisher(CLOCK)
    taker = Taker()
    net.sinks.append(taker)
    net.freeze()
    ((request_id, _),) = server.take()
    clock.publish(messages.Clock(messages.stamp(1.0)))
    server.answer(request_id, ANSWER(True, "on"))
    clock.publish(messages.Clock(messages.stamp(2.0)))
    assert answers == []
    net.flush()
    assert answers == [messages.encode(ANSWER(True, "on"))]
    assert [topic for which, topic, _ in taker.said if which == "said"] == ["/clock", "/light/_service_event", "/clock"]


def test_responses_are_sent_before_their_server_closes() -> None:
    net, server, answers, peer = asked(True)
    net.freeze()
    ((request_id, _),) = server.take()
    server.answer(request_id, ANSWER(True, ""))
    server.close()
    assert len(answers) == 1
    assert peer.ready is False
    assert net.hearing == []


def test_an_unknown_request_gets_no_response() -> None:
    net, server, answers, _ = asked(True)
    net.freeze()
    server.take()
    server.answer(b"somebody else's", ANSWER(True, ""))
    net.flush()
    assert answers == []


def test_a_response_of_another_type_is_refused() -> None:
    net, server, _, _ = asked(True)
    net.freeze()
    ((request_id, _),) = server.take()
    told = "/light takes std_srvs/srv/SetBool_Response, not std_srvs/srv/SetBool_Request"
    with pytest.raises(MessageError, match=told):
        server.answer(request_id, ASK(True))


def test_malformed_requests_are_dropped_counted_and_reported_once() -> None:
    said: list[str] = []
    transport = MemoryTransport()
    net = network(transport, said.append)
    server = net.server(claim("serve"), 1)
    peer = transport.client("/light", SET_BOOL, QoS(), lambda number, data: None)
    for data in (b"", b"\0\1", messages.encode(ASK(True)), b"\0\1\0\0"):
        peer.call(data)
    net.freeze()
    assert [request for _, request in server.take()] == [ASK(True)]
    assert net.undecoded == {"/light": 3}
    assert said == [f"/light: a peer sends malformed {SET_BOOL}_Request messages; they are dropped"]


def test_malformed_responses_are_dropped_and_end_their_calls() -> None:
    net, client, said, requests, peer = calling()
    numbers = [client.call(ASK(True)), client.call(ASK(False))]
    net.flush()
    peer.answer(requests[0], b"\0\1\0\0\1")
    peer.answer(requests[1], messages.encode(ANSWER(True, "")))
    net.freeze()
    assert numbers == [1, 2]
    assert client.take() == ((2, ANSWER(True, "")),)
    assert said == [f"/light: a peer sends malformed {SET_BOOL}_Response messages; they are dropped"]


def test_any_number_of_calls_is_sent_in_a_tick_in_order_with_messages() -> None:
    transport, taker = MemoryTransport(), Taker()
    net = network(transport)
    net.sinks.append(taker)
    client = net.client(claim("call"))
    clock = net.publisher(CLOCK)
    heard: list[bytes] = []
    transport.server("/light", SET_BOOL, QoS(), lambda request_id, data: heard.append(data))
    transport.reader("/clock", "rosgraph_msgs/msg/Clock", QoS(), heard.append)
    expected = []
    for number in range(3 * QoS().depth):
        request, time = ASK(number % 2 == 0), messages.Clock(messages.stamp(float(number)))
        client.call(request)
        clock.publish(time)
        expected += [messages.encode(request), messages.encode(time)]
    net.flush()
    assert heard == expected


def test_the_number_of_unanswered_calls_is_limited() -> None:
    net, client, said, requests, peer = calling()
    for _ in range(MAX_OPEN + 2):
        client.call(ASK(True))
        net.flush()
    for request_id in requests:
        peer.answer(request_id, messages.encode(ANSWER(True, "")))
    net.freeze()
    assert [number for number, _ in client.take()] == list(range(3, MAX_OPEN + 3))
    assert said == [f"/light: more than {MAX_OPEN} calls have no response; the oldest are discarded"]


# service_msgs/msg/ServiceEventInfo: REQUEST_SENT 0, REQUEST_RECEIVED 1, RESPONSE_SENT 2, RESPONSE_RECEIVED 3
def test_sinks_get_introspection_events_of_requests_and_responses() -> None:
    net, taker = network(MemoryTransport()), Taker()
    net.sinks.append(taker)
    server, client = net.server(claim("serve"), 1), net.client(claim("call"))
    client.call(ASK(True))
    net.flush()
    net.freeze()
    ((request_id, _),) = server.take()
    server.answer(request_id, ANSWER(True, "on"))
    net.flush()
    net.freeze()
    assert [(which, topic, e.info.event_type, e.request, e.response) for which, topic, e in taker.said] == [
        ("said", "/light/_service_event", INFO.REQUEST_SENT, [ASK(True)], []),
        ("heard", "/light/_service_event", INFO.REQUEST_RECEIVED, [ASK(True)], []),
        ("said", "/light/_service_event", INFO.RESPONSE_SENT, [], [ANSWER(True, "on")]),
        ("heard", "/light/_service_event", INFO.RESPONSE_RECEIVED, [], [ANSWER(True, "on")]),
    ]
    ours, theirs = taker.said[0][2].info, taker.said[1][2].info
    assert bytes(theirs.client_gid) + theirs.sequence_number.to_bytes(8, "big") == request_id
    assert ours.sequence_number == 1


def test_events_identify_a_call_by_node_and_number() -> None:
    found = []
    for node, calls in (("/World/a", 1), ("/World/a", 2), ("/World/b", 1)):
        net, taker = network(MemoryTransport()), Taker()
        net.sinks.append(taker)
        client = net.client(claim("call", node))
        for _ in range(calls):
            client.call(ASK(True))
        net.flush()
        info = taker.said[-1][2].info
        found.append((bytes(info.client_gid), info.sequence_number))
    assert [number for _, number in found] == [1, 2, 1]
    assert found[0][0] == found[1][0] != found[2][0]


@given(st.binary(min_size=1, max_size=40), st.booleans())
def test_a_recorded_event_delivers_its_request(request_id: bytes, wanted: bool) -> None:
    taken, events = [], [messages.encode(DEFINITIONS.initial(EVENT))]
    for again in (False, True):
        net, taker = network(MemoryTransport()), Taker()
        net.sinks.append(taker)
        server = net.server(claim("serve"), 1)
        if again:
            for event in events:
                server.deliver(event)
        else:
            server._receive(request_id, messages.encode(ASK(wanted)))
        net.freeze()
        ((identity, request),) = server.take()
        server.answer(identity, ANSWER(request.data, ""))
        net.flush()
        taken.append([messages.encode(event) for _, _, event in taker.said])
        events.append(taken[0][0])
    assert taken[0] == taken[1]


def test_a_queue_keeps_more_requests_than_the_default_limit() -> None:
    wanted, transport, said = MAX_OPEN + 500, MemoryTransport(), list[str]()
    net = network(transport, said.append)
    longer = EndpointClaim("/World/graph/node", "graph", "/light", SET_BOOL, "serve", QoS(depth=wanted))
    server = net.server(longer, 1)
    peer = transport.client("/light", SET_BOOL, QoS(), lambda number, data: None)
    for _ in range(wanted):
        peer.call(messages.encode(ASK(True)))
    net.freeze()
    assert (len(server.take()), said) == (wanted, [])
