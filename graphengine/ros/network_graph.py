"""The ROS graph that peers announce: nodes with their services, and the writers and readers of each topic."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from graphengine.format.wording import printable
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import mismatch

Direction = Literal["publish", "subscribe"]

MAX_NAME = 500
"""Maximum length of a name from a peer; longer names are cut. Legal names in ROS 2 have at most 256 characters."""
PATIENCE = 5.0
"""Additional time for a discovered peer to announce its endpoints, s."""


def full_name(namespace: str, node: str) -> str:
    """Return the name of a node with its namespace, as in `ros2 node list`."""
    return f"{namespace.rstrip('/')}/{node}"


def split_name(node: str) -> tuple[str, str]:
    """Split the full name of a node into its namespace (`/` if none) and its name."""
    namespace, _, name = node.rpartition("/")
    return namespace or "/", name


@dataclass(frozen=True, slots=True)
class Endpoint:
    """A writer or reader of a topic. The strings of a peer are made printable, because messages and tables show them.

    Args:
        gid: 16 bytes that identify the endpoint in ROS 2.
        direction: `publish` for a writer, `subscribe` for a reader.
        topic: absolute name.
        message_type: as in `nav_msgs/msg/Odometry`.
        qos: offered or requested profile; the history is `systemDefault` if the peer announces no history.
        type_hash: hash of the message definition; empty if the peer announces no hash.
        node: name of the node; empty if unknown.
        namespace: namespace of the node.
    """

    gid: bytes
    direction: Direction
    topic: str
    message_type: str
    qos: QoS
    type_hash: str = ""
    node: str = ""
    namespace: str = ""

    def __post_init__(self) -> None:
        for name in ("topic", "message_type", "type_hash", "node", "namespace"):
            text = getattr(self, name)
            if not text.isprintable() or len(text) > MAX_NAME:
                object.__setattr__(self, name, printable(text[:MAX_NAME]))

    @property
    def full_node(self) -> str:
        """Name of the node with its namespace; empty if unknown."""
        return full_name(self.namespace, self.node) if self.node else ""

    def serves(self, other: Endpoint) -> bool:
        """Return whether messages of this writer reach the given reader."""
        same = (self.topic, self.message_type) == (other.topic, other.message_type)
        return same and not mismatch(self.qos, other.qos)


@dataclass(frozen=True, slots=True)
class NetworkNode:
    """A node on the network. The strings of a peer are made printable.

    Args:
        name: name with the namespace.
        servers: names and types of the services that the node offers, sorted.
        clients: names and types of the services that the node calls, sorted.
    """

    name: str
    servers: Sequence[tuple[str, str]] = ()
    clients: Sequence[tuple[str, str]] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", printable(self.name[:MAX_NAME]))
        for field in ("servers", "clients"):
            object.__setattr__(self, field, tuple(_printable_services(getattr(self, field))))


class NetworkGraph:
    """All known endpoints at one moment, sorted by topic and direction.

    Args:
        endpoints: endpoints in any order.
        complete: whether all known peers have announced their endpoints.
        named: whether all known peers have announced their nodes.
        services: names and types of the services that are offered or called.
        nodes: all nodes, including nodes without endpoints; several nodes can have the same name.
    """

    def __init__(
        self,
        endpoints: Iterable[Endpoint],
        complete: bool = True,
        named: bool = True,
        services: Iterable[tuple[str, str]] = (),
        nodes: Iterable[NetworkNode] = (),
    ) -> None:
        self.endpoints = sorted(endpoints, key=lambda end: (end.topic, end.direction, end.full_node, end.gid))
        self.complete = complete
        self.named = named
        self.services = _printable_services(services)
        self.nodes = sorted(nodes, key=lambda node: node.name)
        self._ends: dict[tuple[str, Direction], list[Endpoint]] = {}
        for end in self.endpoints:
            self._ends.setdefault((end.topic, end.direction), []).append(end)

    def without(self, node: str) -> NetworkGraph:
        """Return a copy of the graph without a node, without its endpoints, and without services that only this node uses."""
        ends = (end for end in self.endpoints if end.full_node != node)
        nodes = [other for other in self.nodes if other.name != node]
        removed = {pair for own in self.nodes if own.name == node for pair in (*own.servers, *own.clients)}
        removed.difference_update(*(other.servers for other in nodes), *(other.clients for other in nodes))
        services = (pair for pair in self.services if pair not in removed)
        return NetworkGraph(ends, self.complete, self.named, services, nodes)

    def with_endpoints(self, endpoints: Iterable[Endpoint]) -> NetworkGraph:
        """Return a copy of the graph with additional endpoints."""
        return NetworkGraph([*self.endpoints, *endpoints], self.complete, self.named, self.services, self.nodes)

    def types(self) -> dict[str, list[str]]:
        """Return the sorted message types of each topic; a topic with several types is an error in the ROS system."""
        found: dict[str, set[str]] = {}
        for end in self.endpoints:
            found.setdefault(end.topic, set()).add(end.message_type)
        return {topic: sorted(types) for topic, types in found.items()}

    def publishers(self, topic: str) -> list[Endpoint]:
        """Return the writers of a topic."""
        return self.ends(topic, "publish")

    def subscribers(self, topic: str) -> list[Endpoint]:
        """Return the readers of a topic."""
        return self.ends(topic, "subscribe")

    def ends(self, topic: str, direction: Direction) -> list[Endpoint]:
        """Return the writers or the readers of a topic."""
        return list(self._ends.get((topic, direction), ()))


def _printable_services(services: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the sorted names and types of services, printable and without duplicates."""
    return sorted({(printable(name), printable(kind)) for name, kind in services})


def another_definition(
    name: str, peer: str, message_type: str, own: str, effect: str = "no messages are exchanged"
) -> tuple[str, str]:
    """Return a warning about a peer that has another definition of a message or service type, and a remedy.

    Args:
        name: name of the topic or service.
        peer: name of the peer.
        message_type: ROS name of the type.
        own: name of the endpoint with the definition of this session.
        effect: consequence of the difference.
    """
    package = message_type.partition("/")[0]
    what = f"{name}: {peer} has another definition of {message_type} than {own}: {effect}"
    return what, f"use one version of {package} on both sides; --msg-path names the folder of its definitions"
