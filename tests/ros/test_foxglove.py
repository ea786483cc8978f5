"""Foxglove beside a transport: clients see the bytes that the transport gets, and publish as any peer does."""

from __future__ import annotations

import itertools
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from typing import Any
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect as sync_connect

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.qos import LATCHED
from graphengine.ros.foxglove import foxglove_server, open_server, publish_gate
from graphengine.ros.foxglove.foxglove_server import FoxgloveServer
from graphengine.ros.foxglove.foxglove_transport import FoxgloveTransport
from graphengine.ros.network import LOOK_EVERY, LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from tests.ros.contract import MIXED, RCLPY, AnyTransport
from tests.ros.foxglove_client import FoxgloveClient
from tests.waiting import eventually

TWIST, STAMPED, STRING = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped", "std_msgs/msg/String"

Connect = Callable[[], FoxgloveClient]


@pytest.fixture
def memory() -> MemoryTransport:
    return MemoryTransport()


@pytest.fixture
def said() -> list[str]:
    """What the network complains of."""
    return []


@pytest.fixture
def network(memory: MemoryTransport, foxglove: FoxgloveServer, said: list[str]) -> Iterator[LiveNetwork]:
    opened = LiveNetwork(lambda domain: FoxgloveTransport(memory, foxglove), 0, said.append)
    yield opened
    opened.close()


@pytest.fixture
def connect(foxglove: FoxgloveServer) -> Iterator[Connect]:
    with ExitStack() as clients:
        yield lambda: clients.enter_context(FoxgloveClient(foxglove.url))


@pytest.fixture
def client(connect: Connect) -> FoxgloveClient:
    return connect()


def claim(
    direction: str, topic: str = "/cmd_vel", kind: str = TWIST, qos: QoS | None = None, others: Sequence[str] = ()
) -> EndpointClaim:
    return EndpointClaim("/node", "graph", topic, kind, direction, qos or QoS(), alternatives=tuple(others))


def twist(speed: float) -> messages.Twist:
    return messages.Twist(messages.Vector3(speed, 0.0, 0.0), messages.Vector3(0.0, 0.0, 0.0))


def encoded(speed: float) -> bytes:
    return messages.encode(twist(speed))


def test_published_and_read_topics_are_advertised_with_their_schema(
    network: LiveNetwork, client: FoxgloveClient
) -> None:
    network.publisher(claim("publish", "/chatter", STRING))
    network.subscription(claim("subscribe"))
    assert client.until(lambda: client.channels.keys() == {"/chatter", "/cmd_vel"})
    channel = client.channels["/cmd_vel"]
    assert (channel["encoding"], channel["schemaEncoding"], channel["schemaName"]) == ("cdr", "ros2msg", TWIST)
    assert channel["schema"] == DEFINITIONS.text(TWIST)
    assert client.info["capabilities"] == ["clientPublish"]
    assert client.info["supportedEncodings"] == ["cdr"]


def test_a_message_is_wanted_only_while_a_client_subscribes(network: LiveNetwork, client: FoxgloveClient) -> None:
    publisher = network.publisher(claim("publish"))
    assert client.until(lambda: client.channels)
    assert not publisher.wanted
    client.subscribe("/cmd_vel")
    assert eventually(lambda: publisher.wanted)
    client.unsubscribe("/cmd_vel")
    assert eventually(lambda: not publisher.wanted)


def test_a_topic_is_unwanted_after_its_client_disconnects(network: LiveNetwork, connect: Connect) -> None:
    publisher = network.publisher(claim("publish"))
    client = connect()
    client.subscribe("/cmd_vel")
    assert eventually(lambda: publisher.wanted)
    client.close()
    assert eventually(lambda: not publisher.wanted)


def test_clients_get_the_bytes_that_the_transport_gets(
    memory: MemoryTransport, network: LiveNetwork, connect: Connect
) -> None:
    publisher = network.publisher(claim("publish"))
    clients = [connect(), connect()]
    for client in clients:
        client.subscribe("/cmd_vel")

    def send() -> None:
        publisher.publish(twist(len(memory.raw("/cmd_vel"))))
        network.flush()

    for client in clients:
        assert client.until(lambda arrived=client.messages: arrived["/cmd_vel"], send)  # type: ignore[misc]
    for client in clients:
        client.until(lambda arrived=client.messages: arrived["/cmd_vel"][-1] == memory.raw("/cmd_vel")[-1])  # type: ignore[misc]
        shown = client.messages["/cmd_vel"]
        assert shown == memory.raw("/cmd_vel")[-len(shown) :]


def test_a_latched_message_reaches_a_late_client(network: LiveNetwork, connect: Connect) -> None:
    publishers = [network.publisher(claim("publish", qos=LATCHED)) for _ in range(2)]
    for speed, publisher in enumerate((*publishers, *publishers)):
        publisher.publish(twist(speed))
    network.flush()
    client = connect()
    client.subscribe("/cmd_vel")
    assert client.until(lambda: len(client.messages["/cmd_vel"]) == 2)
    assert client.messages["/cmd_vel"] == [encoded(2.0), encoded(3.0)]


def test_a_topic_is_withdrawn_with_its_last_endpoint(network: LiveNetwork, client: FoxgloveClient) -> None:
    first, second = (network.publisher(claim("publish")) for _ in range(2))
    assert client.until(lambda: client.channels)
    first.close()
    first.close()
    network.publisher(claim("publish", "/chatter", STRING))
    assert client.until(lambda: client.channels.keys() == {"/cmd_vel", "/chatter"})
    second.close()
    assert client.until(lambda: client.channels.keys() == {"/chatter"})
    network.close()
    assert client.until(lambda: not client.channels)


def test_messages_of_a_client_are_frozen_by_tick_and_reach_sinks(network: LiveNetwork, client: FoxgloveClient) -> None:
    subscription = network.subscription(claim("subscribe", qos=QoS(depth=2)))
    taken: list[bytes] = []

    class Sink:
        def write(self, claim: EndpointClaim, data: bytes) -> None: ...

        def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
            taken.extend(arrived)

    network.sinks.append(Sink())
    client.subscribe("/cmd_vel")
    publish = client.advertise("/cmd_vel", "geometry_msgs/Twist")
    for speed in (1.0, 2.0, 3.0):
        publish(encoded(speed))
    assert client.until(lambda: len(client.messages["/cmd_vel"]) == 3)
    assert list(subscription.take()) == []
    network.freeze()
    assert [message.linear.x for message in subscription.take()] == [2.0, 3.0]
    assert taken == [encoded(2.0), encoded(3.0)]
    assert network.overwritten == {"/cmd_vel": 1}


@pytest.mark.parametrize("also_written", [False, True])
def test_clients_get_each_message_of_a_read_topic_once(
    memory: MemoryTransport, network: LiveNetwork, client: FoxgloveClient, also_written: bool
) -> None:
    first, second = (network.subscription(claim("subscribe", qos=QoS(depth=1000))) for _ in range(2))
    publisher = network.publisher(claim("publish")) if also_written else None
    client.subscribe("/cmd_vel")
    speeds = itertools.count()

    def send() -> None:
        if publisher is None:
            memory.inject("/cmd_vel", twist(next(speeds)))
        else:
            publisher.publish(twist(next(speeds)))
            network.flush()

    assert client.until(lambda: client.messages["/cmd_vel"], send)
    first.close()
    send()
    last = encoded(next(speeds) - 1)
    assert client.until(lambda: client.messages["/cmd_vel"][-1] == last)
    network.freeze()
    heard = [messages.encode(message) for message in second.take()]
    shown = client.messages["/cmd_vel"]
    assert shown == heard[-len(shown) :]


def test_an_undecodable_message_is_dropped_counted_and_reported_once(
    network: LiveNetwork, client: FoxgloveClient, said: list[str]
) -> None:
    subscription = network.subscription(claim("subscribe"))
    publish = client.advertise("/cmd_vel", TWIST)
    for data in (b"\x00\x01\x00\x00rubbish!", b"", encoded(1.0)):
        publish(data)
    assert eventually(lambda: subscription.heard)
    network.freeze()
    assert [message.linear.x for message in subscription.take()] == [1.0]
    assert network.malformed == {"/cmd_vel": 2}
    assert eventually(lambda: said, network.look)
    assert said == ["/cmd_vel: a peer sends messages that do not fit the topic's type; they are dropped"]


@pytest.mark.parametrize(
    ("topic", "encoding", "warning"),
    [
        ("/cmd_vel", "json", "/cmd_vel: messages in json are not accepted, only in cdr"),
        ("/goal_pose", "cdr", "/goal_pose: no graph of the run reads it"),
    ],
)
def test_a_client_gets_a_warning_about_refused_channels(
    network: LiveNetwork, client: FoxgloveClient, topic: str, encoding: str, warning: str
) -> None:
    subscription = network.subscription(claim("subscribe"))
    client.advertise(topic, TWIST, encoding)(encoded(1.0))
    assert client.until(lambda: client.warnings)
    assert client.warnings == [warning]
    network.freeze()
    assert list(subscription.take()) == []


def test_a_client_with_another_type_is_reported_like_any_peer(
    network: LiveNetwork, client: FoxgloveClient, said: list[str]
) -> None:
    subscription = network.subscription(claim("subscribe"))
    client.advertise("/cmd_vel", STRING)(messages.encode(messages.String("forward")))
    assert eventually(lambda: said, network.look)
    (text,) = said
    assert text.startswith(f"/cmd_vel: /foxglove publishes {STRING}, /node reads {TWIST}: no messages arrive")
    network.freeze()
    assert list(subscription.take()) == []


def test_a_client_may_publish_an_alternative_type(network: LiveNetwork, client: FoxgloveClient) -> None:
    subscription = network.subscription(claim("subscribe", others=[STAMPED]))
    publish = client.advertise("/cmd_vel", STAMPED)
    stamped = messages.encode(DEFINITIONS.initial(STAMPED))

    def tick() -> None:
        for _ in range(LOOK_EVERY):
            network.freeze()
        publish(stamped)

    assert client.until(lambda: subscription.heard, tick)
    assert subscription.claim.message_type == STAMPED
    assert client.until(lambda: [channel["schemaName"] for channel in client.channels.values()] == [STAMPED])


def test_messages_outside_of_the_protocol_have_no_effect(
    network: LiveNetwork, client: FoxgloveClient, connect: Connect
) -> None:
    publisher = network.publisher(claim("publish"))
    for rubbish in ("{rubbish", "[]", b"", b"\xff\x00", b"\x01\x09\x00\x00\x00data", '{"op": "subscribe"}'):
        client.send(rubbish)
    other = connect()
    other.subscribe("/cmd_vel")
    assert eventually(lambda: publisher.wanted)


def test_publishers_of_a_disconnected_client_leave_the_graph(network: LiveNetwork, connect: Connect) -> None:
    network.subscription(claim("subscribe"))
    client = connect()
    client.advertise("/cmd_vel", TWIST)
    graph = network.transport(0).graph
    assert eventually(lambda: graph().publishers("/cmd_vel"))
    (end,) = graph().publishers("/cmd_vel")
    assert (end.full_node, end.message_type, len(end.gid)) == ("/foxglove", TWIST, 16)
    client.close()
    assert eventually(lambda: not graph().publishers("/cmd_vel"))


def test_clients_together_may_advertise_a_limited_number_of_topics(
    network: LiveNetwork, client: FoxgloveClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(foxglove_server, "MAX_PUBLISHED", 2)
    network.subscription(claim("subscribe"))
    for _ in range(3):
        client.advertise("/cmd_vel", TWIST)
    assert client.until(lambda: client.warnings)
    assert client.warnings == ["/cmd_vel: clients publish more than 2 topics"]


def test_a_client_that_does_not_read_delays_neither_ticks_nor_close(foxglove: FoxgloveServer) -> None:
    with ExitStack() as closing:
        network = LiveNetwork(lambda domain: FoxgloveTransport(MemoryTransport(keeps=False), foxglove), 0, print)
        closing.callback(network.close)
        publisher = network.publisher(claim("publish", "/chatter", STRING))
        client = closing.enter_context(FoxgloveClient(foxglove.url))
        client.subscribe("/chatter")
        assert eventually(lambda: publisher.wanted)
        large = messages.String("x" * 1_000_000)
        longest = 0.0
        for _ in range(2 * foxglove_server.BACKLOG):
            publisher.publish(large)
            begun = time.monotonic()
            network.flush()
            longest = max(longest, time.monotonic() - begun)
        assert longest < 1.0
        ending = threading.Thread(target=foxglove.close, daemon=True)
        ending.start()
        assert eventually(lambda: not ending.is_alive())


def test_an_unfinished_request_does_not_delay_close(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(publish_gate, "_OPTIONS", {**publish_gate._OPTIONS, "open_timeout": None})
    server = open_server(("127.0.0.1", 0), "test", DEFINITIONS, publish=True)
    with socket.create_connection(("127.0.0.1", urlsplit(server.url).port or 0)) as stranger:
        stranger.sendall(b"GET / HTTP/1.1\r\n")
        with FoxgloveClient(server.url):  # connected after the stranger
            ending = threading.Thread(target=server.close, daemon=True)
            ending.start()
            assert eventually(lambda: not ending.is_alive())
        assert stranger.recv(1) == b""


def test_close_disconnects_clients_and_frees_the_port(foxglove: FoxgloveServer, client: FoxgloveClient) -> None:
    foxglove.close()
    foxglove.close()
    assert client.until(lambda: client.closed)
    port = urlsplit(foxglove.url).port
    assert port
    open_server(("127.0.0.1", port), "again", DEFINITIONS).close()


def test_by_default_messages_of_clients_are_not_delivered(memory: MemoryTransport) -> None:
    with ExitStack() as closing:
        server = open_server(("127.0.0.1", 0), "test", DEFINITIONS)
        closing.callback(server.close)
        network = LiveNetwork(lambda domain: FoxgloveTransport(memory, server), 0, print)
        closing.callback(network.close)
        subscription, publisher = (
            network.subscription(claim("subscribe")),
            network.publisher(claim("publish", "/chatter", STRING)),
        )
        client = closing.enter_context(FoxgloveClient(server.url))
        assert client.info["capabilities"] == []
        client.advertise("/cmd_vel", TWIST)(encoded(1.0))
        client.subscribe("/chatter")

        def send() -> None:
            publisher.publish(messages.String("read"))
            network.flush()

        assert client.until(lambda: client.messages["/chatter"], send)  # after what it published
        network.freeze()
        assert list(subscription.take()) == []
        assert not network.transport(0).graph().publishers("/cmd_vel")


@pytest.mark.parametrize("query", ["", "/", "/?token=", "/?token=x", "/?token=%FF", "/?x=TOKEN", "/TOKEN"])
@pytest.mark.parametrize("origin", [None, "https://app.foxglove.dev", "http://evil.example", "http://127.0.0.1:1"])
def test_with_publish_a_client_needs_the_token(
    foxglove: FoxgloveServer, caplog: pytest.LogCaptureFixture, query: str, origin: str | None
) -> None:
    base, _, token = foxglove.url.partition("/?token=")
    with pytest.raises(InvalidStatus) as refused, sync_connect(base + query.replace("TOKEN", token), origin=origin):  # type: ignore[arg-type]
        pass
    assert refused.value.response.status_code == 403
    assert [record for record in caplog.records if record.name.startswith("graphengine")] == []


def test_the_server_behind_the_gate_accepts_no_messages(
    network: LiveNetwork, foxglove: FoxgloveServer, client: FoxgloveClient
) -> None:
    """Another user, or a page that tries all ports, finds the port of the SDK's server too: it is for reading only."""
    subscription = network.subscription(claim("subscribe"))
    with FoxgloveClient(f"ws://127.0.0.1:{foxglove._server.port}") as stranger:
        assert stranger.info["capabilities"] == []
        stranger.advertise("/cmd_vel", TWIST)(encoded(1.0))
        stranger.subscribe("/cmd_vel")
        publish = client.advertise("/cmd_vel", TWIST)
        assert stranger.until(lambda: stranger.messages["/cmd_vel"], lambda: publish(encoded(2.0)))
    network.freeze()
    assert {message.linear.x for message in subscription.take()} == {2.0}


@pytest.mark.parametrize(
    "channel",
    [
        7,
        {},
        {"id": -1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": TWIST},
        {"id": 2**32, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": TWIST},
        {"id": "1", "topic": "/cmd_vel", "encoding": "cdr", "schemaName": TWIST},
        {"id": 1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": "\ud800"},
        {"id": 1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": "a\x1b[31m"},
        {"id": 1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": "a" * 1000},
        {"id": 1, "topic": ["/cmd_vel"], "encoding": "cdr", "schemaName": TWIST},
        {"id": 1, "topic": "/cmd_vel", "encoding": "cdr", "schemaName": None},
    ],
)
def test_a_malformed_channel_causes_a_warning(network: LiveNetwork, client: FoxgloveClient, channel: Any) -> None:
    subscription = network.subscription(claim("subscribe"))
    client.send({"op": "advertise", "channels": [channel]})
    assert client.until(lambda: client.warnings)
    assert client.warnings == ["a channel needs an id, a topic, an encoding and a schema name, in printable characters"]
    client.advertise("/cmd_vel", TWIST)(encoded(1.0))
    assert eventually(lambda: subscription.heard)


def test_messages_on_an_unadvertised_channel_are_not_delivered(network: LiveNetwork, client: FoxgloveClient) -> None:
    subscription = network.subscription(claim("subscribe", qos=QoS(depth=100)))
    gone, stays = client.advertise("/cmd_vel", TWIST), client.advertise("/cmd_vel", TWIST)
    client.send({"op": "unadvertise", "channelIds": [1, "1", None]})
    gone(encoded(1.0))
    stays(encoded(2.0))
    assert eventually(lambda: subscription.heard)
    network.freeze()
    assert [message.linear.x for message in subscription.take()] == [2.0]


def test_clients_beyond_the_limit_are_refused(
    foxglove: FoxgloveServer, client: FoxgloveClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(publish_gate, "MAX_CLIENTS", 1)
    with (
        sync_connect(foxglove.url, subprotocols=[publish_gate.SUBPROTOCOL]) as second,
        pytest.raises(ConnectionClosed, match="there are already 1 clients"),
    ):
        second.recv(timeout=10)


def test_by_default_the_server_listens_on_loopback_only(foxglove: FoxgloveServer) -> None:
    port = urlsplit(foxglove.url).port
    assert port
    with socket.socket() as other:
        other.bind(("127.0.0.2", port))  # which a server of all addresses would have taken


def test_a_port_in_use_is_an_error_of_one_line(foxglove: FoxgloveServer) -> None:
    port = urlsplit(foxglove.url).port
    assert port
    with pytest.raises(TransportError) as error:
        open_server(("127.0.0.1", port), "second", DEFINITIONS)
    assert str(error.value) == f"Foxglove cannot be served at 127.0.0.1:{port}: Address already in use (os error 98)"
    with pytest.raises(TransportError, match=f"Foxglove cannot be served at 127.0.0.1:{port}: Address already in use"):
        open_server(("127.0.0.1", port), "second", DEFINITIONS, publish=True)


def test_without_the_sdk_the_error_names_the_package_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "graphengine.ros.foxglove.foxglove_server")
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with pytest.raises(
        TransportError, match=r"Foxglove needs foxglove-sdk and websockets: .*\n  pip install '\.\[foxglove\]'"
    ):
        open_server(("127.0.0.1", 0), "test", DEFINITIONS)


@pytest.mark.parametrize("kind", ["dds", RCLPY, *MIXED], indirect=True)
def test_a_reader_gets_messages_of_peers_and_clients_and_a_client_gets_both(
    alice: AnyTransport, bob: AnyTransport, foxglove: FoxgloveServer, client: FoxgloveClient
) -> None:
    network = LiveNetwork(lambda domain: FoxgloveTransport(alice, foxglove), 0, print)
    subscription = network.subscription(claim("subscribe", qos=QoS(depth=1000)))
    writer = bob.writer("/cmd_vel", TWIST, QoS())
    client.subscribe("/cmd_vel")
    publish = client.advertise("/cmd_vel", TWIST)
    shown = client.messages["/cmd_vel"]
    assert client.until(lambda: encoded(1.0) in shown, lambda: writer.write(encoded(1.0)))
    publish(encoded(2.0))
    assert client.until(lambda: encoded(2.0) in shown)
    network.freeze()
    heard = [messages.encode(message) for message in subscription.take()]
    assert {encoded(1.0), encoded(2.0)} == {*heard}
    network.close()


def test_closing_a_reader_waits_for_a_clients_message_in_delivery(
    foxglove: FoxgloveServer, client: FoxgloveClient
) -> None:
    taken: list[bytes] = []
    reached, go_on = threading.Event(), threading.Event()

    def take(data: bytes) -> None:
        reached.set()
        go_on.wait()
        taken.append(data)

    reader = FoxgloveTransport(MemoryTransport(), foxglove).reader("/cmd_vel", TWIST, QoS(), take)
    publish = client.advertise("/cmd_vel", TWIST)
    assert eventually(reached.is_set, lambda: publish(encoded(1.0)))
    threading.Timer(0.1, go_on.set).start()
    reader.close()
    assert taken == [encoded(1.0)]
