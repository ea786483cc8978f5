"""A session's endpoints: encoded once for every sink, frozen by tick, closed by their owner."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.ros.network import LOOK_EVERY, LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport, MemoryWriter
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build

IMAGE = "sensor_msgs/msg/Image"
TWIST, STAMPED, CLOCK = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped", "rosgraph_msgs/msg/Clock"
GRAPH = """
graph: clock
nodes:
  Tick: OnPlaybackTick
  Time: ReadSimulationTime
  Publish: PublishClock
connections:
  - Tick.tick -> Publish.execIn
  - Time.simulationTime -> Publish.timeStamp
"""


def in_memory(complain: Callable[[str], None] = print) -> tuple[MemoryTransport, LiveNetwork]:
    """A transport that keeps what is written, and a network over it."""
    transport = MemoryTransport()
    return transport, LiveNetwork(lambda domain: transport, 0, complain)


def claim(direction: str, depth: int = 10) -> EndpointClaim:
    return EndpointClaim("/node", "graph", "/cmd_vel", TWIST, direction, QoS(depth=depth))


def twist(speed: float) -> messages.Twist:
    return messages.Twist(messages.Vector3(speed, 0.0, 0.0), messages.Vector3(0.0, 0.0, 0.0))


class Taker:
    def __init__(self) -> None:
        self.written: list[tuple[EndpointClaim, bytes]] = []
        self.delivered: list[tuple[EndpointClaim, list[bytes]]] = []

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        self.written.append((claim, data))

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        self.delivered.append((claim, list(arrived)))


def clock_session(folder: Path, transport: MemoryTransport) -> SessionCore:
    path = folder / "clock.yaml"
    path.write_text(GRAPH)
    return build.start(build.load(path), LiveNetwork(lambda domain: transport, 0, print))


def test_nodes_read_a_message_in_the_tick_after_its_arrival() -> None:
    transport, network = in_memory()
    subscription = network.subscription(claim("subscribe"))
    network.freeze()
    transport.inject("/cmd_vel", twist(1.0))
    assert subscription.newest() is None
    network.freeze()
    message = subscription.newest()
    assert message is not None
    assert message.linear.x == 1.0
    assert subscription.newest() is None


def test_a_queue_keeps_more_than_a_thousand_messages() -> None:
    transport, network = in_memory()
    subscription = network.subscription(claim("subscribe", depth=1500))
    for number in range(1600):
        transport.inject("/cmd_vel", twist(float(number)))
    network.freeze()
    assert [message.linear.x for message in subscription.take()] == [float(number) for number in range(100, 1600)]


def test_an_image_is_copied_once_between_camera_and_transport() -> None:
    transport = MemoryTransport(keeps=False)
    received: list[bytes] = []
    network = LiveNetwork(lambda domain: transport, 0, print)
    transport.reader("/rgb", IMAGE, QoS(), received.append)
    publisher = network.publisher(EndpointClaim("/node", "graph", "/rgb", IMAGE, "publish", QoS()))
    pixels = np.arange(640 * 480 * 3).astype(np.uint8)
    for time in (1.0, 2.0):
        received.clear()
        message = messages.Image(messages.header(time, "camera"), 480, 640, "rgb8", 0, 1920, pixels)
        tracemalloc.start()
        publisher.publish(message)
        network.flush()
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    assert received == [messages.encode(message)]
    assert pixels.nbytes <= peak < pixels.nbytes + 10_000


def test_subscribers_counts_readers_but_not_recorders() -> None:
    transport, network = in_memory()
    network.sinks.append(Taker())
    network.publisher(claim("publish"))
    network.publisher(EndpointClaim("/node", "graph", "/rgb", IMAGE, "publish", QoS()))
    assert network.subscribers == 0
    for topic, kind in (("/cmd_vel", TWIST), ("/cmd_vel", TWIST), ("/rgb", IMAGE), ("/other", IMAGE)):
        transport.reader(topic, kind, QoS(), lambda data: None)
    assert network.subscribers == 3


def test_messages_overwritten_before_a_tick_are_counted() -> None:
    transport, network = in_memory()
    subscription = network.subscription(claim("subscribe", depth=3))
    for speed in range(5):
        transport.inject("/cmd_vel", twist(float(speed)))
    assert (subscription.heard, subscription.overwritten) == (5, 2)
    network.freeze()
    transport.inject("/cmd_vel", twist(5.0))
    network.freeze()
    assert [message.linear.x for message in subscription.take()] == [3.0, 4.0, 5.0]
    transport.inject("/cmd_vel", twist(6.0))
    network.freeze()
    subscription.close()
    assert (subscription.heard, subscription.overwritten) == (7, 3)
    assert network.overwritten == {"/cmd_vel": 3}


def test_newest_counts_the_skipped_messages() -> None:
    transport, network = in_memory()
    subscription = network.subscription(claim("subscribe"))
    for speed in (1.0, 2.0, 3.0):
        transport.inject("/cmd_vel", twist(speed))
    network.freeze()
    message = subscription.newest()
    assert message is not None
    assert (message.linear.x, subscription.skipped) == (3.0, 2)


def test_malformed_bytes_are_dropped_counted_and_reported_once() -> None:
    said: list[str] = []
    _, network = in_memory(said.append)
    subscription = network.subscription(claim("subscribe"))
    for data in (b"\x00\x01\x00\x00rubbish!", b"", messages.encode(twist(2.0))):
        subscription.deliver(data)
    network.freeze()
    assert [message.linear.x for message in subscription.take()] == [2.0]
    assert subscription.malformed == 2
    assert len(said) == 1
    assert "/cmd_vel" in said[0]


def test_every_sink_gets_the_bytes_that_the_transport_gets() -> None:
    transport, network = in_memory()
    sink = Taker()
    publisher = network.publisher(claim("publish"))
    wanted_before = publisher.wanted
    network.sinks.append(sink)
    assert (wanted_before, publisher.wanted) == (False, True)
    publisher.publish(twist(1.5))
    network.flush()
    assert sink.written == [(claim("publish"), transport.raw("/cmd_vel")[0])]


def test_every_sink_gets_the_received_messages_of_each_tick() -> None:
    transport, network = in_memory()
    sink = Taker()
    network.sinks.append(sink)
    network.subscription(claim("subscribe", depth=2))
    sent = [messages.encode(twist(speed)) for speed in (1.0, 2.0, 3.0)]
    for data in sent:
        transport.inject("/cmd_vel", data)
    assert sink.delivered == []
    network.freeze()
    network.freeze()
    assert sink.delivered == [(claim("subscribe", depth=2), sent[1:])]


def test_a_publisher_whose_topic_changes_is_closed_on_the_old_topic(tmp_path: Path) -> None:
    transport = MemoryTransport(wants_all=True)
    with clock_session(tmp_path, transport) as session:
        session.step(2)
        executor = session.graphs[0].executor
        executor.node("Publish").topic_name = "time"  # type: ignore[attr-defined]
        executor.setup()
        session.step(3)
        assert [claim.topic for claim in session.services.claims] == ["/time"]
    assert len(transport.messages("/clock")) == 2
    assert len(transport.messages("/time")) == 3


def test_messages_of_a_tick_are_sent_before_their_publisher_closes() -> None:
    transport = MemoryTransport(wants_all=True)
    network = LiveNetwork(lambda domain: transport, 0, print)
    first, second = (network.publisher(claim("publish")) for _ in range(2))
    first.publish(twist(1.0))
    second.publish(twist(2.0))
    second.close()
    network.flush()
    assert [message.linear.x for message in transport.messages("/cmd_vel")] == [1.0, 2.0]


def test_messages_that_a_closed_publisher_dropped_are_counted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    _, network = in_memory()
    monkeypatch.setattr(MemoryWriter, "dropped", 3)
    publisher = network.publisher(claim("publish"))
    for _ in range(2):
        assert network.given_up == {"/cmd_vel": 3}
        publisher.close()
    assert network.given_up == {"/cmd_vel": 3}


def test_a_subscription_with_alternatives_reads_the_published_type() -> None:
    transport, network = in_memory()
    subscription = network.subscription(replace(claim("subscribe"), alternatives=(STAMPED, CLOCK)))
    transport.inject("/cmd_vel", twist(1.0))
    transport.writer("/cmd_vel", CLOCK, QoS())
    for _ in range(LOOK_EVERY):
        network.freeze()
    assert (subscription.claim.message_type, subscription.claim.alternatives) == (CLOCK, (TWIST, STAMPED))
    assert subscription.newest() is None  # what came as the other type is gone
    transport.inject("/cmd_vel", messages.Clock(messages.stamp(2.0)))
    network.freeze()
    assert subscription.newest() == messages.Clock(messages.stamp(2.0))
    subscription.close()
    assert network.subscriptions == []
    assert transport.graph().subscribers("/cmd_vel") == []


def test_a_subscription_with_alternatives_keeps_its_type_while_nobody_publishes() -> None:
    transport, network = in_memory()
    subscription = network.subscription(replace(claim("subscribe"), alternatives=(STAMPED,)))
    transport.writer("/cmd_vel", CLOCK, QoS())
    network.freeze()
    assert subscription.claim.message_type == TWIST


def test_a_handed_over_endpoint_closes_with_its_last_holder() -> None:
    _, network = in_memory()
    publisher, subscription = network.publisher(claim("publish")), network.subscription(claim("subscribe"))
    with network.handing_over():
        heir = network.publisher(replace(claim("publish"), rate=30.0))
        other = network.publisher(claim("publish"))
        deeper = network.subscription(claim("subscribe", depth=1))
    assert heir is publisher
    assert other is not publisher, "each endpoint is handed over once"
    assert deeper is not subscription, "another QoS is another endpoint"
    assert network.publisher(claim("publish")) not in (publisher, other), "nothing is handed over later"
    publisher.close()
    assert publisher in network.publishers
    heir.close()
    assert publisher not in network.publishers
