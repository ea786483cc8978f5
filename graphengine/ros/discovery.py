"""What a DDS participant learns of others: DDS tells of endpoints, ROS 2 processes tell which of them belongs to which node."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from cyclonedds.builtin import (
    BuiltinDataReader,
    BuiltinTopicDcpsParticipant,
    BuiltinTopicDcpsPublication,
    BuiltinTopicDcpsSubscription,
)
from cyclonedds.core import InstanceState
from cyclonedds.qos import Policy

from graphengine.diagnostics import TransportError
from graphengine.ros import cyclone, messages
from graphengine.ros.graph import Direction, Endpoint, Graph
from graphengine.ros.qos import LATCHED

TOPIC = "ros_discovery_info"
"""Where every ROS 2 process tells which nodes it has, and which endpoints these have."""
TYPE = "rmw_dds_common/msg/ParticipantEntitiesInfo"
TELLING = LATCHED
HEARING = replace(LATCHED, history="keepAll")
"""Of one reader for all processes: with a depth of 1, one would overwrite what another told."""

_BATCH = 1000
_TYPE_HASH = re.compile(rb"typehash=(RIHS[0-9A-Fa-f_]+);")
_ENCLAVE = b"enclave="
_CYCLONE = b"\x01\x10"
"""What GIDs of Eclipse Cyclone DDS begin with. Its peers alone tell their history, which is no part of the wire protocol."""
_PREFIX = 12
"""Bytes of a GID that all endpoints of a participant share."""


@dataclass(frozen=True, slots=True)
class _Node:
    name: str
    namespace: str


class Discovery:
    """The peers of one participant and itself.

    Args:
        participant: what to ask.
        nodes: a reader of `TOPIC`.
    """

    def __init__(self, participant: Any, nodes: Any) -> None:
        self._participants = BuiltinDataReader(participant, BuiltinTopicDcpsParticipant)
        self._publications = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)
        self._subscriptions = BuiltinDataReader(participant, BuiltinTopicDcpsSubscription)
        self._told = nodes
        self._silent: set[bytes] = set()
        """ROS 2 participants, by the prefix of their GIDs, that have not told of nodes."""
        self._nodes: dict[bytes, dict[bytes, _Node]] = {}
        """By participant, then by endpoint."""
        self._endpoints: dict[bytes, Endpoint | None] = {}
        """None for one that is no ROS 2 topic, such as a service's."""

    def graph(self) -> Graph:
        """What is known by now."""
        self._hear_nodes()  # first: a participant that is gone takes with it what it told before
        self._hear_participants()
        self._hear_endpoints(self._publications, "publish")
        self._hear_endpoints(self._subscriptions, "subscribe")
        owners = {gid: node for nodes in self._nodes.values() for gid, node in nodes.items()}
        found = [_owned(end, owners.get(end.gid)) for end in self._endpoints.values() if end is not None]
        heard = {gid[:_PREFIX] for gid in self._endpoints}
        complete = self._silent <= heard and owners.keys() <= self._endpoints.keys()
        return Graph(found, complete, named=not self._silent)

    def _hear_participants(self) -> None:
        for sample in _samples(self._participants):
            prefix = sample.key.bytes[:_PREFIX]
            if not _is_there(sample):
                self._silent.discard(prefix)
                self._nodes.pop(prefix, None)
            elif prefix not in self._nodes and _user_data(sample.qos).startswith(_ENCLAVE):
                self._silent.add(prefix)

    def _hear_endpoints(self, reader: Any, direction: Direction) -> None:
        for sample in _samples(reader):
            gid: bytes = sample.key.bytes
            if _is_there(sample):
                self._endpoints[gid] = _endpoint(gid, direction, sample)
            else:
                self._endpoints.pop(gid, None)

    def _hear_nodes(self) -> None:
        while arrived := cyclone.take(self._told):
            for data, _ in arrived:
                try:
                    info = messages.decode(data, TYPE)
                except TransportError:
                    continue  # a peer that speaks another version of ROS 2; its endpoints are known all the same
                prefix = bytes(info.gid.data)[:_PREFIX]
                self._silent.discard(prefix)
                self._nodes[prefix] = {
                    bytes(gid.data): _Node(node.node_name, node.node_namespace)
                    for node in info.node_entities_info_seq
                    for gid in (*node.reader_gid_seq, *node.writer_gid_seq)
                }


def _samples(reader: Any) -> Iterator[Any]:
    while samples := reader.take(_BATCH):
        yield from samples


def _is_there(sample: Any) -> bool:
    """Whether a sample tells of what is there; one of what came and went since has its data all the same."""
    return bool(sample.sample_info.instance_state == InstanceState.Alive)


def _endpoint(gid: bytes, direction: Direction, sample: Any) -> Endpoint | None:
    prefix, slash, topic = sample.topic_name.partition("/")
    if (prefix, slash) != ("rt", "/"):
        return None
    qos = cyclone.read_qos(sample.qos)
    if not gid.startswith(_CYCLONE):
        qos = replace(qos, history="systemDefault", depth=0)
    found = _TYPE_HASH.search(_user_data(sample.qos))
    return Endpoint(gid, direction, f"/{topic}", ros_type(sample.type_name), qos, found[1].decode() if found else "")


def _owned(end: Endpoint, owner: _Node | None) -> Endpoint:
    return replace(end, node=owner.name, namespace=owner.namespace) if owner else end


def ros_type(name: str) -> str:
    """`nav_msgs/msg/Odometry` for `nav_msgs::msg::dds_::Odometry_`; another name stays as it is."""
    namespace, separator, last = name.rpartition("dds_::")
    return f"{namespace}{last.removesuffix('_')}".replace("::", "/") if separator else name


def _user_data(policies: Any) -> bytes:
    policy = policies[Policy.Userdata]
    return bytes(policy.data) if policy else b""
