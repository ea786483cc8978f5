"""Discovery of peers: DDS announces endpoints, and each ROS 2 process announces its nodes with their endpoints."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence, Sized
from dataclasses import dataclass, replace
from typing import Any

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsParticipant,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import InstanceState

from graphengine.format.errors import TransportError
from graphengine.messages import messages, names
from graphengine.messages.qos import LATCHED
from graphengine.ros.network_graph import Direction, Endpoint, NetworkGraph, NetworkNode, full_name, split_name
from graphengine.ros.transports import vendors
from graphengine.ros.transports.dds import cyclone

TOPIC = "ros_discovery_info"
"""DDS topic on which each ROS 2 process announces its nodes and their endpoints."""
TYPE = "rmw_dds_common/msg/ParticipantEntitiesInfo"
TELLING = LATCHED
HEARING = replace(LATCHED, history="keepAll")
"""QoS of the reader on `TOPIC`. With a depth of 1, processes would overwrite each other's messages, as the topic has no key."""

_BATCH = 50
"""Number of samples to read at a time while the lock `READING_POLICIES` is held; services wait for this lock too."""
_ENCLAVE = b"enclave="
_OWNER = re.compile(rb"(?:^|;)node=([^;]*/[^;]+);")
_PREFIX = 12
"""Length of the prefix that the GIDs of a participant and its endpoints share, bytes."""


@dataclass(frozen=True, slots=True)
class DiscoveredNode:
    """A node that a process announces, with the GIDs of the node's readers and writers."""

    namespace: str
    name: str
    readers: Sequence[bytes]
    writers: Sequence[bytes]


def announcement(participant: bytes, nodes: Sequence[DiscoveredNode]) -> bytes:
    """Return a CDR message of type `TYPE` with the nodes of a process.

    A process sends the message after each change of its endpoints, with the GIDs of all endpoints. A general codec needs 1 µs per
    GID, in all some seconds while a thousand topics are created; so this function encodes the message by hand.
    """
    parts = [b"\0\1\0\0", participant, _count(nodes)]
    for node in nodes:
        for text in (node.namespace, node.name):
            encoded = text.encode() + b"\0"
            parts += [_count(encoded), encoded, bytes(-len(encoded) & 3)]
        for gids in (node.readers, node.writers):
            parts += [_count(gids), *gids]
    return b"".join(parts)


def owner_data(node: str) -> str:
    """Return user data that name an endpoint's node, for a process that does not announce its nodes on `TOPIC`."""
    return f"node={node};"


def _count(items: Sized) -> bytes:
    return len(items).to_bytes(4, "little")


class Discovery:
    """Tracks the endpoints and nodes of a participant and its peers.

    Args:
        participant: Cyclone DDS participant.
        nodes: DDS reader on `TOPIC`.
    """

    def __init__(self, participant: Any, nodes: Any) -> None:
        self._participants = BuiltinDataReader(participant, BuiltinTopicDcpsParticipant)
        self._publications = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)
        self._subscriptions = BuiltinDataReader(participant, BuiltinTopicDcpsSubscription)
        self._told = nodes
        self._silent: set[bytes] = set()
        """GID prefixes of ROS 2 participants that have not announced their nodes yet."""
        self._nodes: dict[bytes, list[DiscoveredNode]] = {}
        """Announced nodes of each participant, by the participant's GID prefix."""
        self._owners: dict[bytes, str] = {}
        """Full name of the node of each endpoint with `owner_data`, by the endpoint's GID."""
        self._endpoints: dict[bytes, Endpoint | None] = {}
        """Endpoint of each GID; None if its DDS topic is not a ROS 2 topic, such as a service's request topic."""
        self._services: dict[bytes, tuple[str, str, Direction]] = {}
        """For the GID of each request endpoint: name and type of the service, and `publish` (client) or `subscribe` (server)."""
        self._graph: NetworkGraph | None = None
        """Result of the last call of `graph`; None if discovery data have changed since then."""

    def graph(self) -> NetworkGraph:
        """Read the new discovery data, and return all known endpoints and nodes."""
        self._hear_nodes()  # first, because `_hear_participants` removes the nodes of participants that have left
        self._hear_participants()
        self._hear_endpoints(self._publications, "publish")
        self._hear_endpoints(self._subscriptions, "subscribe")
        if self._graph is None:
            self._graph = self._drawn()
        return self._graph

    @property
    def servers(self) -> Counter[str]:
        """Number of servers of each service, as of the last `graph`."""
        return Counter(name for name, _, direction in self._services.values() if direction == "subscribe")

    def _drawn(self) -> NetworkGraph:
        nodes = self._all_nodes()
        owners = {gid: (node.name, node.namespace) for node in nodes for gid in (*node.readers, *node.writers)}
        owned = [(end, *owners.get(end.gid, ("", ""))) for end in self._endpoints.values() if end is not None]
        found = [replace(end, node=node, namespace=namespace) for end, node, namespace in owned]
        heard = {gid[:_PREFIX] for gid in self._endpoints}
        complete = self._silent <= heard and owners.keys() <= self._endpoints.keys()
        services = ((name, kind) for name, kind, _ in self._services.values())
        return NetworkGraph(found, complete, not self._silent, services, map(self._with_services, nodes))

    def _all_nodes(self) -> list[DiscoveredNode]:
        """Return the announced nodes, each also with the endpoints whose `owner_data` name it; a name may occur twice."""
        owned: dict[str, list[bytes]] = {}
        for gid, node in self._owners.items():
            owned.setdefault(node, []).append(gid)
        announced = [node for told in self._nodes.values() for node in told]
        nodes = [
            replace(node, readers=[*node.readers, *owned.pop(full_name(node.namespace, node.name), ())])
            for node in announced
        ]
        return nodes + [DiscoveredNode(*split_name(node), gids, ()) for node, gids in owned.items()]

    def _with_services(self, node: DiscoveredNode) -> NetworkNode:
        services = [self._services[gid] for gid in (*node.readers, *node.writers) if gid in self._services]
        offered, called = (
            [(name, kind) for name, kind, direction in services if direction == role]
            for role in ("subscribe", "publish")
        )
        return NetworkNode(full_name(node.namespace, node.name), offered, called)

    def _hear_participants(self) -> None:
        for sample in _samples(self._participants):
            self._graph = None
            prefix = sample.key.bytes[:_PREFIX]
            if not _is_there(sample):
                self._silent.discard(prefix)
                self._nodes.pop(prefix, None)
            elif prefix not in self._nodes and cyclone.user_data(sample.qos).startswith(_ENCLAVE):
                self._silent.add(prefix)

    def _hear_endpoints(self, reader: Any, direction: Direction) -> None:
        for sample in _samples(reader):
            self._graph = None
            gid: bytes = sample.key.bytes
            if _is_there(sample):
                self._endpoints[gid] = _endpoint(gid, direction, sample)
                if owner := _OWNER.search(cyclone.user_data(sample.qos)):
                    self._owners[gid] = owner[1].decode(errors="replace")
                if service := _service(sample):
                    self._services[gid] = (*service, direction)
            else:
                for known in (self._endpoints, self._owners, self._services):
                    known.pop(gid, None)

    def _hear_nodes(self) -> None:
        while arrived := cyclone.take(self._told):
            for data, _ in arrived:
                try:
                    info = messages.decode(data, TYPE)
                except TransportError:
                    continue  # a peer that speaks another version of ROS 2; its endpoints are known all the same
                self._graph = None
                prefix = bytes(info.gid.data)[:_PREFIX]
                self._silent.discard(prefix)
                self._nodes[prefix] = [
                    DiscoveredNode(
                        node.node_namespace,
                        node.node_name,
                        [bytes(gid.data) for gid in node.reader_gid_seq],
                        [bytes(gid.data) for gid in node.writer_gid_seq],
                    )
                    for node in info.node_entities_info_seq
                ]


def _samples(reader: Any) -> Iterator[Any]:
    while True:
        with cyclone.READING_POLICIES:
            samples = reader.take(_BATCH)
        if not samples:
            return
        yield from samples


def _is_there(sample: Any) -> bool:
    """Return whether a discovery sample describes an entity that exists; samples of deleted entities have data too."""
    return bool(sample.sample_info.instance_state == InstanceState.Alive)


def _endpoint(gid: bytes, direction: Direction, sample: Any) -> Endpoint | None:
    prefix, slash, topic = sample.topic_name.partition("/")
    if (prefix, slash) != ("rt", "/"):
        return None
    qos = cyclone.read_qos(sample.qos)
    # Only peers on Cyclone DDS announce their history, which is not part of the wire protocol.
    if not gid.startswith(vendors.CYCLONE):
        qos = replace(qos, history="systemDefault", depth=0)
    type_hash = cyclone.type_hash(cyclone.user_data(sample.qos))
    return Endpoint(gid, direction, f"/{topic}", ros_type(sample.type_name), qos, type_hash)


def _service(sample: Any) -> tuple[str, str] | None:
    """Return name and type of a service if the sample is about the service's request topic, otherwise None."""
    name = names.ros_name(sample.topic_name)
    asks = sample.topic_name == names.service_topics(name)[0]
    return (name, ros_type(sample.type_name).removesuffix("_Request")) if asks else None


def ros_type(name: str) -> str:
    """Return `nav_msgs/msg/Odometry` for the DDS type `nav_msgs::msg::dds_::Odometry_`; other names are unchanged."""
    namespace, separator, last = name.rpartition("dds_::")
    return f"{namespace}{last.removesuffix('_')}".replace("::", "/") if separator else name
