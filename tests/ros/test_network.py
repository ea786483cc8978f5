"""A session's endpoints: encoded once for every sink, frozen by tick, closed by their owner."""

from __future__ import annotations

from pathlib import Path

from graphengine import build
from graphengine.backend import TopicClaim
from graphengine.context import QoS
from graphengine.ros import messages
from graphengine.ros.memory import MemoryTransport
from graphengine.ros.network import LiveNetwork
from graphengine.session import Session

TWIST = "geometry_msgs/msg/Twist"
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


def claim(direction: str, depth: int = 10) -> TopicClaim:
    return TopicClaim("/node", "graph", "/cmd_vel", TWIST, direction, QoS(depth=depth))


def twist(speed: float) -> messages.Twist:
    return messages.Twist(messages.Vector3(speed, 0.0, 0.0), messages.Vector3(0.0, 0.0, 0.0))


def clock_session(folder: Path, transport: MemoryTransport) -> Session:
    path = folder / "clock.yaml"
    path.write_text(GRAPH)
    return build.start(build.assemble(path), LiveNetwork(lambda domain: transport, 0, print))


def test_what_arrives_in_a_tick_is_seen_in_the_next() -> None:
    transport = MemoryTransport()
    network = LiveNetwork(lambda domain: transport, 0, print)
    subscription = network.subscription(claim("subscribe"))
    network.freeze()
    transport.inject("/cmd_vel", twist(1.0))
    assert subscription.newest() is None
    network.freeze()
    message = subscription.newest()
    assert message is not None
    assert message.linear.x == 1.0
    assert subscription.newest() is None


def test_the_newest_message_counts_those_it_skips() -> None:
    transport = MemoryTransport()
    network = LiveNetwork(lambda domain: transport, 0, print)
    subscription = network.subscription(claim("subscribe"))
    for speed in (1.0, 2.0, 3.0):
        transport.inject("/cmd_vel", twist(speed))
    network.freeze()
    message = subscription.newest()
    assert message is not None
    assert (message.linear.x, subscription.skipped) == (3.0, 2)


def test_malformed_bytes_are_dropped_counted_and_told_once() -> None:
    said: list[str] = []
    transport = MemoryTransport()
    network = LiveNetwork(lambda domain: transport, 0, said.append)
    subscription = network.subscription(claim("subscribe"))
    for data in (b"\x00\x01\x00\x00rubbish!", b"", messages.encode(twist(2.0))):
        subscription.deliver(data)
    network.freeze()
    assert [message.linear.x for message in subscription.take()] == [2.0]
    assert subscription.malformed == 2
    assert len(said) == 1
    assert "/cmd_vel" in said[0]


def test_every_sink_gets_the_bytes_that_the_transport_gets() -> None:
    taken: list[tuple[str, str, bytes]] = []

    class Recorder:
        def write(self, topic: str, message_type: str, data: bytes) -> None:
            taken.append((topic, message_type, data))

    transport = MemoryTransport()
    network = LiveNetwork(lambda domain: transport, 0, print)
    publisher = network.publisher(claim("publish"))
    wanted_before = publisher.wanted
    network.sinks.append(Recorder())
    assert (wanted_before, publisher.wanted) == (False, True)
    publisher.publish(twist(1.5))
    network.flush()
    assert taken == [("/cmd_vel", TWIST, transport.raw("/cmd_vel")[0])]


def test_a_publisher_whose_topic_changes_leaves_the_old_one(tmp_path: Path) -> None:
    transport = MemoryTransport(wants_all=True)
    with clock_session(tmp_path, transport) as session:
        session.step(2)
        executor = session.graphs[0].executor
        index = next(i.index for i in executor.plan.graph.instances if i.id == "Publish")
        executor.set_constant(index, "topic_name", "time")
        session.step(3)
        assert [claim.topic for claim in session.services.claims] == ["/time"]
    assert len(transport.messages("/clock")) == 2
    assert len(transport.messages("/time")) == 3
