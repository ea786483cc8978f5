"""Peers whose definition of a type is another one: their messages are dropped and reported, never read as what they are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore
from rosbags.typesys.stores import ros2_kilted, ros2_lyrical

from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.interfaces import element_of
from graphengine.messages.messages import decode, encode
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from graphengine.ros.transports.rcl.rcl import RclTransport
from tests.ros.conftest import OpenDds
from tests.ros.contract import Inbox, text
from tests.waiting import eventually

PAIR, ASK, STRING = "my_msgs/msg/Pair", "my_msgs/srv/Ask", "std_msgs/msg/String"
FIELDS = {"ours": "uint32 first\nfloat32 second\n", "theirs": "float32 second\nuint32 first\n"}


def definitions(folder: Path, side: str) -> Definitions:
    for name, end in (("msg/Pair.msg", ""), ("srv/Ask.srv", "---\n")):
        path = folder / side / "my_msgs" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(FIELDS[side] + end)
    return DEFINITIONS.extended([folder / side / "my_msgs"])


class Side:
    """A node with definitions that it writes and announces.

    Cyclone DDS would not match two ends that announce structures which differ; those of ROS 2 announce none.
    """

    def __init__(self, dds: OpenDds, folder: Path, side: str, announced: str | None = None) -> None:
        self.known = definitions(folder, side)
        typed = definitions(folder, "ours")
        typed.type_hash = lambda message_type: (  # type: ignore[method-assign]
            self.known.type_hash(message_type) if announced is None else announced
        )
        self.transport = dds(side, definitions=typed)

    def message(self, kind: str, first: int, second: float) -> bytes:
        message = self.known.initial(kind)
        message.first, message.second = first, second
        return encode(message, self.known)


@pytest.fixture
def ours(dds: OpenDds, tmp_path: Path) -> Side:
    return Side(dds, tmp_path, "ours")


@pytest.fixture
def theirs(dds: OpenDds, tmp_path: Path) -> Side:
    return Side(dds, tmp_path, "theirs")


def test_messages_with_another_definition_are_dropped_counted_and_reported_once(ours: Side, theirs: Side) -> None:
    said: list[str] = []
    network = LiveNetwork(lambda domain: ours.transport, 0, said.append, ours.known)
    subscription = network.subscription(EndpointClaim("/World/hears", "graph", "/pair", PAIR, "subscribe", QoS()))
    writer = theirs.transport.writer("/pair", PAIR, QoS())
    fits = ours.transport.writer("/pair", PAIR, QoS())
    assert eventually(lambda: writer.matched and fits.matched)

    def are_reported() -> bool:
        writer.write(theirs.message(PAIR, 1, 2.0))
        fits.write(ours.message(PAIR, 3, 4.0))
        network.freeze()
        return bool(said) and network.malformed["/pair"] > 2

    assert eventually(are_reported)
    heard = {(message.first, message.second) for message in subscription.take()}
    subscription.close()
    network.close()
    assert heard == {(3, 4.0)}
    assert network.malformed == {}
    assert ours.transport.malformed["/pair"] > 2
    (report,) = said
    assert report.splitlines() == [
        "/pair: /theirs has another definition of my_msgs/msg/Pair than /World/hears: its messages are dropped",
        "  use one version of my_msgs on both sides; --msg-path names the folder of its definitions",
    ]


def test_a_reader_with_another_definition_is_reported(ours: Side, theirs: Side) -> None:
    said: list[str] = []
    network = LiveNetwork(lambda domain: ours.transport, 0, said.append, ours.known)
    network.publisher(EndpointClaim("/World/says", "graph", "/pair", PAIR, "publish", QoS()))
    theirs.transport.reader("/pair", PAIR, QoS(), lambda data: None)
    assert eventually(lambda: said, network.freeze)
    network.close()
    why = "/theirs has another definition of my_msgs/msg/Pair than /World/says: it cannot read the messages"
    assert [line.partition("\n")[0] for line in said] == [f"/pair: {why}"]


@pytest.mark.ros
@pytest.mark.parametrize("peer", ["dds", "rclpy"])
def test_rclpy_drops_all_messages_while_a_publisher_has_another_definition(
    domain: Domain, tmp_path: Path, peer: str
) -> None:
    said, known = list[str](), definitions(tmp_path, "ours")
    transport = RclTransport(JoinOptions(domain, "ours", definitions=known))
    bob = (DdsTransport if peer == "dds" else RclTransport)(JoinOptions(domain, "bob"))
    network = LiveNetwork(lambda domain: transport, 0, said.append, known)
    subscription = network.subscription(EndpointClaim("/World/hears", "graph", "/chatter", STRING, "subscribe", QoS()))
    writer = bob.writer("/chatter", STRING, QoS())

    def are(expected: Callable[[], object]) -> bool:
        def found() -> bool:
            writer.write(text("hello"))
            network.freeze()
            return bool(expected())

        return eventually(found)

    assert are(subscription.take)
    known.type_hash = lambda message_type: "RIHS01_00"  # type: ignore[method-assign]
    writer.close()
    writer = bob.writer("/chatter", STRING, QoS())
    other = bob.writer("/chatter", STRING, QoS())
    assert are(lambda: transport.malformed["/chatter"] > 2 if transport.malformed else False)
    assert are(lambda: said)
    heard, dropped = subscription.heard, transport.malformed["/chatter"]
    other.close()
    assert are(lambda: transport.malformed["/chatter"] > dropped)
    assert subscription.heard == heard
    network.close()
    bob.close()
    why = "/bob has another definition of std_msgs/msg/String than /World/hears: its messages are dropped"
    assert [line.partition("\n")[0] for line in said] == [f"/chatter: {why}"]


@pytest.mark.parametrize("announced", ["", "RIHS02_00"])
def test_messages_of_a_peer_without_a_known_type_hash_are_delivered(
    ours: Side, dds: OpenDds, tmp_path: Path, announced: str
) -> None:
    old, inbox = Side(dds, tmp_path, "theirs", announced), Inbox()
    ours.transport.reader("/chatter", STRING, QoS(), inbox)
    writer = old.transport.writer("/chatter", STRING, QoS())
    assert eventually(lambda: writer.matched)
    assert eventually(lambda: inbox.texts, lambda: writer.write(text("hello")))


def test_a_request_with_another_definition_is_dropped_and_reported(ours: Side, theirs: Side) -> None:
    asked: list[bytes] = []
    ours.transport.server("/ask", ASK, QoS(), lambda request_id, data: asked.append(data))
    client = theirs.transport.client("/ask", ASK, QoS(), lambda number, data: None)
    fits = ours.transport.client("/ask", ASK, QoS(), lambda number, data: None)
    assert eventually(lambda: ours.transport.malformed, lambda: client.call(theirs.message(f"{ASK}_Request", 1, 2.0)))
    assert not client.ready
    assert eventually(lambda: fits.ready)
    fits.call(ours.message(f"{ASK}_Request", 3, 4.0))
    assert eventually(lambda: asked)
    assert {decode(data, f"{ASK}_Request", ours.known).first for data in asked} == {3}
    warning = ours.transport.foreign_services["/ask"]
    assert warning.startswith("/ask: a client has another definition of my_msgs/srv/Ask than this run")


def test_a_type_that_two_distributions_share_has_one_hash() -> None:
    differing = {name: differences(store) for name, store in (("kilted", ros2_kilted), ("lyrical", ros2_lyrical))}
    # Lyrical stamps a transition with a Time, where Jazzy and Kilted write a uint64.
    assert differing == {"kilted": set(), "lyrical": {"lifecycle_msgs/msg/TransitionEvent"}}


def differences(distribution: ModuleType) -> set[str]:
    """Types whose hash in another distribution is not the one here."""
    store = Typestore(distribution)
    known = set(DEFINITIONS.names())
    return {
        name
        for name in store.fielddefs.keys() & known
        if not has_char(store, name) and not DEFINITIONS.agrees(name, store.hash_rihs01(name))
    }


def has_char(store: Typestore, name: str) -> bool:
    """Whether a type has a char somewhere, which rosbags hashes as none of ROS 2 does."""
    elements = [element_of(kind) for _, kind in store.fielddefs[name][1]]
    return any(detail[0] == "char" if kind == Nodetype.BASE else has_char(store, detail) for kind, detail in elements)
