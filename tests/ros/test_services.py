"""One contract for the services of every transport: a call is answered, late or not at all, to the client that made it."""

from __future__ import annotations

import logging
import warnings
from functools import partial
from typing import Any

import pytest

from graphengine.format.errors import TopicError, TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.ros.network_graph import NetworkGraph, NetworkNode
from graphengine.ros.transport import TransportServer
from tests.ros import needs
from tests.ros.contract import ALL, COMPOSED, MIXED, NETWORKED, RCLPY, SEEN, AnyTransport, Join
from tests.ros.service_contract import NAME, TYPE, Client, Server, foreign, question, reply
from tests.waiting import eventually

BEST_EFFORT = QoS(reliability="bestEffort")


@pytest.fixture(params=ALL)
def kind(request: pytest.FixtureRequest) -> str:
    if " to " in request.param:
        needs.skip_for(needs.cyclone())
    return str(request.param)


@pytest.fixture
def server(bob: AnyTransport) -> Server:
    return Server(bob)


@pytest.fixture
def client(alice: AnyTransport, server: Server) -> Client:
    """A client that the server is there for."""
    made = Client(alice)
    assert eventually(lambda: made.end.ready)
    return made


def test_a_call_is_answered(client: Client, server: Server) -> None:
    assert client.call("a") == 1
    assert eventually(lambda: server.texts == ["a"])
    server.answer(0)
    assert eventually(lambda: client.answers == {1: "a!"})


def test_servers_of_several_nodes_can_be_called_and_leave_one_by_one(alice: AnyTransport, bob: AnyTransport) -> None:
    nodes = ("", "/robot/one", "/robot/two", "/robot/one")
    servers = [Server(bob, f"{NAME}_{number}", node=node) for number, node in enumerate(nodes)]
    clients = [Client(alice, f"{NAME}_{number}") for number in range(len(nodes))]
    assert eventually(lambda: all(client.end.ready for client in clients))
    servers[1].end.close()
    servers[2].end.close()
    assert eventually(lambda: [client.end.ready for client in clients] == [True, False, False, True])
    for number in (0, 3):
        clients[number].call("a")
        assert eventually(lambda number=number: servers[number].asked)  # type: ignore[misc]
        servers[number].answer(0)
        assert eventually(lambda number=number: clients[number].answers == {1: "a!"})  # type: ignore[misc]
    again = Server(bob, f"{NAME}_2", node="/robot/two")
    assert eventually(lambda: clients[2].end.ready)
    again.end.close()


@pytest.mark.parametrize("kind", NETWORKED)
@pytest.mark.parametrize("node", ["/robot/my node", "/1st/robot", "robot//one"])
def test_a_server_of_a_node_without_a_legal_name_is_refused(bob: AnyTransport, node: str) -> None:
    with pytest.raises(TopicError):
        bob.server(NAME, TYPE, QoS(), lambda request_id, data: None, node)


def test_calls_arrive_in_order_and_may_be_answered_in_any_order(client: Client, server: Server) -> None:
    assert [client.call(text) for text in "abcde"] == [1, 2, 3, 4, 5]
    assert eventually(lambda: len(server.asked) == 5)
    assert server.texts == ["a", "b", "c", "d", "e"]
    for number in (3, 0, 4, 2):
        server.answer(number)
    assert eventually(lambda: len(client.answers) == 4)
    server.answer(1)
    assert eventually(lambda: len(client.answers) == 5)
    assert client.answers == {1: "a!", 2: "b!", 3: "c!", 4: "d!", 5: "e!"}


def test_a_request_is_answered_long_after_others(client: Client, server: Server) -> None:
    client.call("late")
    assert eventually(lambda: server.asked)
    for number in range(1, 60):
        client.call("early")
        assert eventually(lambda number=number: len(server.asked) == number + 1)  # type: ignore[misc]
        server.answer(number)
    assert eventually(lambda: len(client.answers) == 59)
    assert 1 not in client.answers
    server.answer(0)
    assert eventually(lambda: client.answers.get(1) == "late!")


def test_a_server_may_respond_within_the_delivery_of_a_request(bob: AnyTransport, join: Join) -> None:
    at_once = reply("at once")
    eager: TransportServer = bob.server(NAME, TYPE, QoS(), lambda request_id, _: eager.answer(request_id, at_once))
    client = Client(join("alice"))
    assert eventually(lambda: client.end.ready)
    number = client.call("a")
    assert eventually(lambda: client.answers == {number: "at once"})


def test_clients_get_only_their_own_responses(join: Join, client: Client, server: Server) -> None:
    clients = [client, Client(join("carol")), Client(join("bob"))]
    assert eventually(lambda: all(client.end.ready for client in clients))
    for client, text in zip(clients, "abc", strict=True):
        assert client.call(text) == 1
    assert eventually(lambda: len(server.asked) == 3)
    for number in range(3):
        server.answer(number)
    assert eventually(lambda: all(client.answers for client in clients))
    assert [client.answers for client in clients] == [{1: "a!"}, {1: "b!"}, {1: "c!"}]


def test_ready_changes_when_servers_open_and_close(join: Join) -> None:
    client, bob = Client(join("alice")), join("bob")
    assert not client.end.ready
    for _ in range(2):
        server = Server(bob)
        assert eventually(lambda: client.end.ready)
        server.end.close()
        server.end.close()
        assert eventually(lambda: not client.end.ready)


@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_ready_ends_when_the_server_leaves(join: Join) -> None:
    client, bob = Client(join("alice")), join("bob")
    Server(bob)
    assert eventually(lambda: client.end.ready)
    bob.close()
    assert eventually(lambda: not client.end.ready)


def test_a_call_without_a_server_is_lost(join: Join) -> None:
    client = Client(join("alice"))
    assert client.call("lost") == 1
    server = Server(join("bob"))
    assert eventually(lambda: client.end.ready)
    assert client.call("heard") == 2
    assert eventually(lambda: server.texts == ["heard"])
    server.answer(0)
    assert eventually(lambda: client.answers == {2: "heard!"})


@pytest.mark.parametrize("leaving", ["client", "process"])
def test_a_closed_client_does_not_affect_others(join: Join, client: Client, server: Server, leaving: str) -> None:
    carol = join("carol")
    gone = Client(carol)
    assert eventually(lambda: gone.end.ready)
    gone.call("a")
    assert eventually(lambda: server.asked)
    for _ in range(2):
        (carol if leaving == "process" and carol.node else gone.end).close()  # in memory, all are one process
    assert not gone.end.ready
    server.answer(0)
    client.call("b")
    assert eventually(lambda: len(server.asked) == 2)
    server.answer(0)
    server.answer(1)
    assert eventually(lambda: client.answers == {1: "b!"})
    assert gone.answers == {}


def test_each_call_gets_one_response(client: Client, server: Server) -> None:
    client.call("a")
    assert eventually(lambda: server.asked)
    for _ in range(3):
        server.answer(0)
    client.call("b")
    assert eventually(lambda: len(server.asked) == 2)
    server.answer(1)
    # By then the others would have come; the client refuses a second one.
    assert eventually(lambda: 2 in client.answers)
    assert client.answers == {1: "a!", 2: "b!"}


@pytest.mark.parametrize("kind", [RCLPY], indirect=True)
@pytest.mark.parametrize("drops", [0, 3, 19, 20])
def test_a_response_waits_until_its_client_is_discovered(
    client: Client, server: Server, drops: int, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from rclpy.service import Service

    send, dropped = Service.send_response, 0

    def drop_then_send(self: Any, response: Any, header: Any) -> None:
        nonlocal dropped
        if self is getattr(server.end, "entity", None) and dropped < drops:
            dropped += 1
            warnings.warn("failed to send response (timeout): client will not receive response", RuntimeWarning, 1)
        else:
            send(self, response, header)

    client.call("a")
    assert eventually(lambda: server.asked)
    monkeypatch.setattr(Service, "send_response", drop_then_send)
    with caplog.at_level(logging.WARNING, "graphengine"):
        server.answer(0)
        assert eventually(lambda: client.answers == ({} if drops == 20 else {1: "a!"}) and dropped == drops)
        client.call("b")
        assert eventually(lambda: len(server.asked) == 2)
        server.answer(1)
        assert eventually(lambda: 2 in client.answers)
    assert list(client.answers) == ([2] if drops == 20 else [1, 2])
    assert ["was dropped" in record.getMessage() for record in caplog.records] == [True] * (drops == 20)


def test_requests_and_responses_of_a_megabyte_arrive(client: Client, server: Server) -> None:
    client.call("x" * 1_000_000)
    assert eventually(lambda: server.texts == ["x" * 1_000_000])
    server.answer(0)
    assert eventually(lambda: client.answers == {1: "x" * 1_000_000 + "!"})


@pytest.mark.parametrize(("asked", "offered"), [(BEST_EFFORT, QoS()), (QoS(), BEST_EFFORT)], ids=["asked", "offered"])
def test_best_effort_and_reliable_services_do_not_match(
    alice: AnyTransport, bob: AnyTransport, asked: QoS, offered: QoS
) -> None:
    Server(bob, qos=offered)
    other = Server(bob, "/other")
    client, marker = Client(alice, qos=asked), Client(alice, "/other")
    assert eventually(lambda: marker.end.ready)
    assert not client.end.ready
    client.call("a")
    marker.call("b")
    assert eventually(lambda: other.texts == ["b"])
    other.answer(0)
    assert eventually(lambda: marker.answers)
    assert client.answers == {}
    assert alice.malformed == bob.malformed == {}


def test_services_with_different_names_or_types_do_not_match(alice: AnyTransport, bob: AnyTransport) -> None:
    server, marker = Server(bob), Server(bob, "/other")
    strange = alice.client(NAME, "std_srvs/srv/Trigger", QoS(), lambda number, data: None)
    client = Client(alice, "/other")
    assert eventually(lambda: client.end.ready)
    assert not strange.ready
    client.call("a")
    assert eventually(lambda: marker.texts == ["a"])
    assert server.texts == []


def test_closed_servers_and_clients_refuse_calls(client: Client, server: Server) -> None:
    client.call("a")
    assert eventually(lambda: server.asked)
    server.end.close()
    client.end.close()
    with pytest.raises(TransportError, match=NAME):
        server.answer(0)
    with pytest.raises(TransportError, match=NAME):
        client.call("b")
    assert not client.end.ready


def test_a_transport_that_is_closed_has_no_services(alice: AnyTransport) -> None:
    server, client = Server(alice), Client(alice)
    alice.close()
    assert not client.end.ready
    with pytest.raises(TransportError, match=NAME):
        client.call("a")
    with pytest.raises(TransportError, match=NAME):
        server.end.answer(bytes(24), reply("a"))
    server.end.close()
    client.end.close()
    with pytest.raises(TransportError, match=f"^{NAME}: the transport is closed"):
        Server(alice)
    with pytest.raises(TransportError, match=f"^{NAME}: the transport is closed"):
        Client(alice)


@pytest.mark.parametrize(
    "service_type", ["std_srvs/srv/Nothing", "std_msgs/msg/String", "tf2_msgs/action/LookupTransform"]
)
def test_a_type_that_is_not_a_service_is_refused(alice: AnyTransport, service_type: str) -> None:
    with pytest.raises(MessageTypeError, match=service_type):
        alice.server(NAME, service_type, QoS(), lambda request_id, data: None)
    with pytest.raises(MessageTypeError, match=service_type):
        alice.client(NAME, service_type, QoS(), lambda number, data: None)


@pytest.mark.parametrize("request_id", [b"", b"\0", bytes(24), bytes(1000)])
def test_responses_to_unknown_requests_are_ignored(client: Client, server: Server, request_id: bytes) -> None:
    server.end.answer(request_id, reply("nobody asked"))
    client.call("a")
    assert eventually(lambda: server.asked)
    server.answer(0)
    assert eventually(lambda: client.answers == {1: "a!"})


@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_an_error_in_a_delivery_does_not_end_deliveries(join: Join, caplog: pytest.LogCaptureFixture) -> None:
    asked: list[bytes] = []
    answered: list[int] = []

    def serve(request_id: bytes, data: bytes) -> None:
        asked.append(request_id)
        raise RuntimeError("on purpose")

    def take(number: int, data: bytes) -> None:
        answered.append(number)
        raise RuntimeError("on purpose")

    server = join("bob").server(NAME, TYPE, QoS(), serve)
    client = join("alice").client(NAME, TYPE, QoS(), take)
    assert eventually(lambda: client.ready)
    with caplog.at_level(logging.ERROR, "graphengine"):
        for count in (1, 2, 3):
            client.call(question("a"))
            assert eventually(lambda count=count: len(asked) == count)  # type: ignore[misc]
            server.answer(asked[-1], reply("b"))
            assert eventually(lambda count=count: len(answered) == count)  # type: ignore[misc]
    told = [record.getMessage() for record in caplog.records]
    assert told == [f"{NAME}: a message could not be delivered; further errors are not reported"] * 2


@pytest.mark.parametrize("kind", ["dds", RCLPY, COMPOSED], indirect=True)
@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", b"\0\1\0\0\xff\xff\xff\xff", b"\0\1\0\0\5\0\0\0a"])
def test_malformed_bytes_are_not_sent(client: Client, server: Server, data: bytes) -> None:
    with pytest.raises(TransportError, match=NAME):
        client.end.call(data)
    client.call("a")
    assert eventually(lambda: server.texts == ["a"])
    with pytest.raises(TransportError, match=NAME):
        server.end.answer(server.asked[0][0], data)


def test_two_servers_of_one_service_give_one_response(join: Join, client: Client, server: Server) -> None:
    both = (server, Server(join("bob")))
    assert eventually(lambda: all(server.asked for server in both), lambda: client.call("a"))
    number = client.call("b")
    assert eventually(lambda: all(server.texts[-1] == "b" for server in both))
    for server in both:
        server.answer(-1)
    assert eventually(lambda: number in client.answers)


def test_the_graph_has_the_services(alice: AnyTransport, bob: AnyTransport) -> None:
    server, client = Server(bob), Client(bob, "/called")

    def told(transport: AnyTransport) -> bool:
        return {(NAME, TYPE), ("/called", TYPE)} <= set(transport.graph().services)

    for transport in (alice, bob):
        assert eventually(partial(told, transport))
    server.end.close()
    client.end.close()
    assert eventually(lambda: TYPE not in {kind for _, kind in alice.graph().services})


@pytest.mark.parametrize("kind", ["dds", SEEN, RCLPY, COMPOSED, *MIXED], indirect=True)
def test_the_graph_has_the_services_of_each_node(alice: AnyTransport, bob: AnyTransport) -> None:
    server, client = Server(bob), Client(bob, "/called")

    def services(transport: AnyTransport) -> list[tuple[bool, bool]]:
        nodes = [node for node in transport.graph().nodes if node.name == "/bob"]
        return [((NAME, TYPE) in node.servers, ("/called", TYPE) in node.clients) for node in nodes]

    def told(transport: AnyTransport) -> bool:
        return services(transport) == [(True, True)]

    for transport in (alice, bob):
        assert eventually(partial(told, transport))
    others = alice.graph().without("/bob")
    assert [node.name for node in others.nodes] == ["/alice"]
    assert not {(NAME, TYPE), ("/called", TYPE)} & set(others.services)
    server.end.close()
    client.end.close()
    assert eventually(lambda: services(alice) == [(False, False)])
    bob.close()
    assert eventually(lambda: services(alice) == [])


def test_without_keeps_services_that_other_nodes_use() -> None:
    own, offered, called = ("/own", TYPE), ("/offered", TYPE), ("/called", TYPE)
    nodes = [
        NetworkNode("/alice", servers=[own, offered], clients=[called]),
        NetworkNode("/bob", servers=[offered]),
        NetworkNode("/carol", clients=[called]),
    ]
    others = NetworkGraph((), services=[own, offered, called], nodes=nodes).without("/alice")
    assert set(others.services) == {offered, called}


@pytest.mark.parametrize("kind", NETWORKED, indirect=True)
def test_a_second_program_with_the_same_service_is_reported(alice: AnyTransport, bob: AnyTransport) -> None:
    for name in (NAME, NAME, "/other"):
        Server(alice, name)
    Client(bob, "/other")
    rival = Server(bob)

    def rivals(transport: AnyTransport) -> list[str]:
        transport.graph()
        return list(transport.rival_services)

    assert eventually(lambda: rivals(alice) == [NAME])
    assert eventually(lambda: rivals(bob) == [NAME])
    rival.end.close()
    assert eventually(lambda: rivals(alice) == [])
    assert rivals(bob) == []


def test_service_peers_on_the_same_rmw_cause_no_warning(join: Join, client: Client, server: Server) -> None:
    client.call("a")
    assert eventually(lambda: server.asked)
    assert foreign(join("bob")) == []
