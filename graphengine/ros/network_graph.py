"""The ROS graph: who writes and reads which topic, as the peers of a network tell each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from graphengine.format.wording import printable
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import mismatch

Direction = Literal["publish", "subscribe"]

MAX_NAME = 500
"""Characters of a name that a peer says; those of ROS 2 have at most 256."""
PATIENCE = 5.0
"""Seconds more that a peer has, once it turned up, to tell what it writes and reads."""


def full_name(namespace: str, node: str) -> str:
    """Name of a node with its namespace, as `ros2 node list` shows it."""
    return f"{namespace.rstrip('/')}/{node}"


@dataclass(frozen=True, slots=True)
class Endpoint:
    """A writer or reader of a topic. What a peer says is made printable: it goes into messages, logs and tables.

    Args:
        gid: 16 bytes by which ROS 2 knows it.
        direction: whether it writes or reads.
        topic: absolute.
        message_type: as in `nav_msgs/msg/Odometry`.
        qos: what it offers or requests; the history is `systemDefault` where the peer does not tell it.
        type_hash: of the message's definition; empty where the peer does not tell it.
        node: name of its node; empty where it is not known.
        namespace: of its node.
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
        """Name of its node with the namespace; empty where it is not known."""
        return full_name(self.namespace, self.node) if self.node else ""

    def serves(self, other: Endpoint) -> bool:
        """Whether what this one writes reaches another one that reads."""
        same = (self.topic, self.message_type) == (other.topic, other.message_type)
        return same and not mismatch(self.qos, other.qos)


class NetworkGraph:
    """All endpoints at one moment, in order of topic and direction.

    Args:
        endpoints: in any order.
        complete: false while a peer is known that has not told what it writes and reads.
        named: false while one is known that has not told of its nodes.
        services: names and types of those that are offered or called.
    """

    def __init__(
        self,
        endpoints: Iterable[Endpoint],
        complete: bool = True,
        named: bool = True,
        services: Iterable[tuple[str, str]] = (),
    ) -> None:
        self.endpoints = sorted(endpoints, key=lambda end: (end.topic, end.direction, end.full_node, end.gid))
        self.complete = complete
        self.named = named
        self.services = sorted({(printable(name), printable(kind)) for name, kind in services})
        self._ends: dict[tuple[str, Direction], list[Endpoint]] = {}
        for end in self.endpoints:
            self._ends.setdefault((end.topic, end.direction), []).append(end)

    def without(self, node: str) -> NetworkGraph:
        """The same as if a node were not there."""
        others = (end for end in self.endpoints if end.full_node != node)
        return NetworkGraph(others, self.complete, self.named, self.services)

    def types(self) -> dict[str, list[str]]:
        """Types of each topic, of which there should be one."""
        found: dict[str, set[str]] = {}
        for end in self.endpoints:
            found.setdefault(end.topic, set()).add(end.message_type)
        return {topic: sorted(types) for topic, types in found.items()}

    def publishers(self, topic: str) -> list[Endpoint]:
        """Who writes a topic."""
        return self.ends(topic, "publish")

    def subscribers(self, topic: str) -> list[Endpoint]:
        """Who reads a topic."""
        return self.ends(topic, "subscribe")

    def ends(self, topic: str, direction: Direction) -> list[Endpoint]:
        """Who does either."""
        return list(self._ends.get((topic, direction), ()))
