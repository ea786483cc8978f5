"""The DDS transport, which uses no ROS libraries; other ROS 2 programs see this process as an ordinary node.

One thread of the transport waits for messages and for changes of peers. The transport uses no DDS listeners, because these could
deadlock: a listener would wait for Python's GIL while its thread holds locks of Cyclone DDS, and the thread with the GIL would
wait for these locks in a write.
"""

from __future__ import annotations

import itertools
import threading
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeVar

from cyclonedds.core import DDSException, GuardCondition, WaitSet
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from graphengine.format.errors import TransportError
from graphengine.messages import names
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import PARAMETER_EVENTS, settled
from graphengine.ros.network_graph import Direction, NetworkGraph, split_name
from graphengine.ros.transport import Deliver, DeliverRequest, DeliverResponse, JoinOptions
from graphengine.ros.transports.dds import cyclone, dds_services, discovery
from graphengine.ros.transports.dds.cyclone_log import LOG
from graphengine.ros.transports.dds.dds_endpoints import DdsEnd, DdsReader, DdsWriter, gid_of
from graphengine.ros.transports.dds.dds_services import DdsClient, DdsServer, Pair
from graphengine.ros.transports.dds.discovery import Discovery
from graphengine.ros.transports.dds.idl import idl_type
from graphengine.ros.transports.ros_node import ROSOUT, RosNode

_FOREVER = duration(infinite=True)

_BACKLOG = 1000
"""Minimum queue depth of a volatile reader, so that no messages are lost while this process is busy."""

_End = TypeVar("_End", bound=DdsEnd)


@dataclass(slots=True)
class _DdsTopic:
    """A DDS topic that this process uses, with the number of the topic's open endpoints."""

    message_type: str
    entity: Any
    endpoints: int = 0


class DdsTransport(RosNode):
    """A transport that joins a DDS domain as a ROS 2 node, without an installed ROS 2.

    Args:
        options: domain and name of the node.
        announces: whether the process announces the node on `ros_discovery_info`, and has writers for /rosout and
            /parameter_events. If not, ROS 2 programs see endpoints without a node; the endpoints' user data name the node for
            other processes of graphengine.
    """

    def __init__(self, options: JoinOptions, announces: bool = True) -> None:
        self._announces = announces
        super().__init__(options)

    def _join(self) -> str:
        domain = self._domain
        self.spin_time = 0.0 if domain.discovery_range == "OFF" else 0.5
        self._hearing = threading.Lock()
        """Lock for reading discovery data, which may take long; acquire this lock before the lock of the node."""
        self._topics: dict[str, _DdsTopic] = {}
        self._service_numbers = itertools.count(1)
        self._delivering: DdsEnd | None = None
        self._discovery: Discovery | None = None
        self._thread = threading.Thread(target=self._receive, name=f"dds domain {domain.id}", daemon=True)
        # ROS 2 treats only participants with an enclave as ROS 2 processes.
        self._participant = cyclone.join(domain, "enclave=/;" if self._announces else "")
        self._gid = gid_of(self._participant)
        try:
            self._wake = GuardCondition(self._participant)
            self._waitset = WaitSet(self._participant)
            self._waitset.attach(self._wake)
            if self._announces:
                self._told = self._endpoint(DataWriter, discovery.TOPIC, discovery.TYPE, discovery.TELLING)
                self._rosout = self.writer(*ROSOUT)
                self.writer("/parameter_events", "rcl_interfaces/msg/ParameterEvent", PARAMETER_EVENTS)
        except BaseException:
            cyclone.leave(domain, self._participant)
            raise
        self._thread.start()
        return "dds (Eclipse Cyclone DDS)"

    def writer(self, topic: str, message_type: str, qos: QoS) -> DdsWriter:
        """Create a writer on a topic.

        Raises:
            MessageTypeError: the type is unknown.
            TransportError: this process uses the topic with another type, Cyclone DDS refuses it, or the transport is closed.
        """
        with self._lock:
            policies = _lossless(qos) if self._patient else qos
            entity = self._endpoint(DataWriter, f"rt{topic}", message_type, policies)
            return self._open(DdsWriter(topic, self._remove, entity))

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> DdsReader:
        """Create a reader on a topic; `deliver` runs in the transport's thread and should be fast.

        Raises:
            TransportError: as for `writer`.
        """
        with self._lock:
            entity = self._endpoint(DataReader, f"rt{topic}", message_type, _deep(qos))
            agrees = partial(self._definitions.agrees, message_type)
            return self._open(DdsReader(topic, self._remove, entity, agrees, deliver))

    def server(self, service: str, service_type: str, qos: QoS, deliver: DeliverRequest, node: str = "") -> DdsServer:
        """Create a server of a service; `deliver` runs in the transport's thread and should be fast.

        Raises:
            TopicError: the name of the node is not legal.
            TransportError: as for `writer`.
        """
        self._check_node(node)
        with self._lock:
            pair = self._pair("service", service, service_type, qos, node)
            server = DdsServer(service, self._remove, pair, deliver)
            server.node = node
            return self._open(server)

    def client(self, service: str, service_type: str, qos: QoS, deliver: DeliverResponse) -> DdsClient:
        """Create a client of a service; `deliver` runs in the transport's thread and should be fast.

        Raises:
            TransportError: as for `writer`.
        """
        with self._lock:
            pair = self._pair("client", service, service_type, qos)
            return self._open(DdsClient(service, self._remove, pair, deliver))

    @property
    def source(self) -> bytes:
        """GID of the writer whose message is being delivered; empty if the writer is gone."""
        return self._delivering.source if isinstance(self._delivering, DdsReader) else b""

    @property
    def malformed(self) -> Mapping[str, int]:
        """Number of malformed messages of each topic or service, also of this process's other transports in the domain."""
        return Counter(LOG.malformed(self._domain.id)) + Counter(super().malformed)

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Return all known endpoints and nodes; `asked` has no effect.

        Raises:
            TransportError: the transport is closed.
        """
        with self._hearing:
            with self._lock:
                self._admit()
                if self._discovery is None:
                    nodes = self._endpoint(DataReader, discovery.TOPIC, discovery.TYPE, discovery.HEARING)
                    self._discovery = Discovery(self._participant, nodes)
            return self._discovery.graph()

    def _leave(self) -> None:
        self._announce()
        self._wake.set(True)
        self._thread.join()
        with self._hearing:
            cyclone.leave(self._domain, self._participant)

    def _count_servers(self, services: Iterable[str]) -> Mapping[str, int]:
        return self._discovery.servers if self._discovery is not None else {}

    def _endpoint(
        self, make: Callable[..., Any], topic: str, message_type: str, qos: QoS, identity: str = "", node: str = ""
    ) -> Any:
        """Create a DDS writer or reader.

        Args:
            make: class of the entity.
            topic: name of the DDS topic.
            message_type: as in `nav_msgs/msg/Odometry`.
            qos: profile of the endpoint.
            identity: user data that a service's reader and writer share; empty for a topic.
            node: full name of the node that has the endpoint; empty for the transport's own node.
        """
        shown = names.ros_name(topic)
        self._admit(shown)
        known = self._topics.get(topic)
        if known and known.message_type != message_type:
            what = f"{shown} has the type {known.message_type} in this process"
            raise TransportError(f"{what}; it cannot also have the type {message_type}")
        owner = "" if self._announces else discovery.owner_data(node or self.node)
        policies = cyclone.endpoint_qos(qos, f"{identity}{owner}typehash={self._definitions.type_hash(message_type)};")
        try:
            described = idl_type(message_type, self._definitions, is_call=bool(identity))
            entity = known.entity if known else Topic(self._participant, topic, described)
            made = make(self._participant, entity, qos=policies)
        except DDSException as error:
            raise TransportError(f"{shown} cannot be created: {error}") from error
        self._topics.setdefault(topic, _DdsTopic(message_type, entity)).endpoints += 1
        return made

    def _pair(self, role: str, service: str, service_type: str, qos: QoS, node: str = "") -> Pair:
        """Create the DDS reader and writer of a service server or client; equal user data identify them as a pair."""
        asked, answered = zip(names.service_topics(service), self._definitions.service_parts(service_type), strict=True)
        heard, told = (asked, answered) if role == "service" else (answered, asked)
        identity = f"{role}id={dds_services.identity(self._gid, next(self._service_numbers))};"
        reader = self._endpoint(DataReader, *heard, qos, identity, node)
        try:
            writer = self._endpoint(DataWriter, *told, qos, identity, node)
        except BaseException:
            self._discard(reader)
            raise
        agrees = [partial(self._definitions.agrees, message_type) for _, message_type in (heard, told)]
        return Pair(reader, writer, service_type, *agrees)

    def _open(self, end: _End) -> _End:
        """Start to serve an endpoint in the transport's thread, announce the endpoint to peers, and return it."""
        (self._writers if isinstance(end, DdsWriter) else self._readers).append(end)
        for entity, status in zip(end.entities, end.statuses, strict=True):
            entity.set_status_mask(status)
            self._waitset.attach(entity)
        self._announce(*self._nodes())
        end.refresh()
        return end

    def _delete(self, end: DdsEnd) -> None:
        for entity in end.entities:
            self._waitset.detach(entity)
            self._discard(entity)
        self._announce(*self._nodes())

    def _discard(self, entity: Any) -> None:
        """Delete a DDS reader or writer, and its DDS topic if no other endpoint uses it."""
        topic = entity.topic.name
        cyclone.delete(entity)
        self._topics[topic].endpoints -= 1
        if not self._topics[topic].endpoints:
            cyclone.delete(self._topics.pop(topic).entity)

    def _nodes(self) -> Sequence[discovery.DiscoveredNode]:
        """Return the nodes to announce: first the transport's own node, then the other nodes that offer services."""
        nodes: dict[str, tuple[list[bytes], list[bytes]]] = {self.node: ([], [])}
        for end in (*self._writers, *self._readers):
            readers, writers = nodes.setdefault(end.node or self.node, ([], []))
            if not isinstance(end, DdsWriter):
                readers.append(end.gids[0])
            if not isinstance(end, DdsReader):
                writers.append(end.gids[-1])
        return [discovery.DiscoveredNode(*split_name(node), *gids) for node, gids in nodes.items()]

    def _announce(self, *nodes: discovery.DiscoveredNode) -> None:
        if self._announces:
            cyclone.write(self._told, discovery.announcement(self._gid, nodes))

    def _receive(self) -> None:
        while not self._closed:
            triggered = self._waitset.wait(_FOREVER)
            arrived = busy = [end for end in tuple(self._readers) if self._drain(end)]
            while busy and not self._closed:
                busy = [end for end in busy if self._drain(end)]
            # More entities triggered than readers had messages: the peers of some endpoints have changed.
            if triggered > len(arrived):
                for end in (*self._writers, *self._readers):
                    end.refresh()

    def _drain(self, end: DdsEnd) -> bool:
        self._delivering = end
        return end.drain()


def _lossless(qos: QoS) -> QoS:
    """Return the profile with which a writer waits for slow readers: keepAll if the profile is reliable and volatile."""
    qos = settled(qos)
    return replace(qos, history="keepAll") if (qos.reliability, qos.durability) == ("reliable", "volatile") else qos


def _deep(qos: QoS) -> QoS:
    """Return the profile of a reader with a large queue: Cyclone DDS does not report messages that a full queue loses.

    Peers see this larger depth, for example in `ros2 topic info -v` on Cyclone DDS. The depth of a latched topic stays, because
    this depth determines how many old messages the reader receives.
    """
    qos = settled(qos)
    return replace(qos, depth=max(qos.depth, _BACKLOG)) if qos.durability == "volatile" else qos
