"""A transport over DDS without ROS: the process looks to every ROS 2 program like an ordinary node.

Python code of it runs in its callers' threads and in one thread of its own, which waits for messages and for readers that come
or go. It uses no listeners, which Cyclone DDS calls from its threads: these would wait for the interpreter's lock while they
hold locks that a write needs, and a write holds the interpreter's lock.
"""

from __future__ import annotations

import atexit
import logging
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
from cyclonedds.core import DDSException, DDSStatus, GuardCondition, WaitSet
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from graphengine.context import QoS
from graphengine.diagnostics import TransportError
from graphengine.ros import cyclone, discovery, messages, names, rosout
from graphengine.ros.definitions import DEFINITIONS, Definitions
from graphengine.ros.discovery import Discovery
from graphengine.ros.domain import Domain
from graphengine.ros.graph import Graph
from graphengine.ros.idl import idl_type
from graphengine.ros.qos import PARAMETER_EVENTS

_log = logging.getLogger(__name__)

_FOREVER = duration(infinite=True)


class DdsWriter:
    """A DDS writer."""

    def __init__(self, topic: str, entity: Any, remove: Callable[[DdsWriter], None]) -> None:
        self.topic = topic
        self.entity = entity
        self.matched = False
        self.dropped = 0
        """Messages given up because a reader did not keep up."""
        self._remove = remove
        self._lock = threading.Lock()

    def write(self, data: bytes) -> None:
        """Send one message; one that a reader blocks for longer than 100 ms is dropped and counted.

        Raises:
            TransportError: it is no message of the topic's type, or the writer is closed.
        """
        if len(data) & 3:
            data += bytes(-len(data) & 3)
        code = cyclone.write(self.entity, data)
        if code == cyclone.TIMEOUT:
            self.dropped += 1
        elif code < 0:
            raise TransportError(f"{self.topic}: {len(data)} bytes were not sent: {cyclone.reason(code)}")

    def refresh(self) -> None:
        """Look whether readers are there."""
        # Two threads that look must not note down what they saw in the wrong order.
        with self._lock:
            try:
                self.matched = self.entity.get_publication_matched_status().current_count > 0
            except DDSException:
                self.matched = False

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self._remove(self)


class DdsReader:
    """A DDS reader."""

    def __init__(
        self, topic: str, entity: Any, deliver: Callable[[bytes], None], remove: Callable[[DdsReader], None]
    ) -> None:
        self.topic = topic
        self.entity = entity
        self._deliver = deliver
        self._remove = remove
        self._failed = False
        self._writer = 0
        self._gids: dict[int, bytes] = {}

    @property
    def source(self) -> bytes:
        """GID of the writer of the message that is being delivered; empty when it is gone already."""
        if self._writer not in self._gids:
            self._gids[self._writer] = cyclone.writer_gid(self.entity, self._writer)
        return self._gids[self._writer]

    def drain(self) -> bool:
        """Deliver some of what has arrived; false when there was nothing."""
        arrived = cyclone.take(self.entity)
        for data, self._writer in arrived:
            try:
                self._deliver(data)
            except Exception:
                if not self._failed:
                    _log.exception("%s: a message could not be delivered; told once", self.topic)
                self._failed = True
        return bool(arrived)

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self._remove(self)


class DdsTransport:
    """A ROS 2 node on a DDS network.

    Args:
        domain: where to be.
        node_name: what `ros2 node list` shows.
        node_namespace: absolute; `/` for none.
        because: why this transport was chosen, for the description.
        definitions: message types.

    Raises:
        TopicError: ROS 2 would refuse the node's name or namespace.
        TransportError: the domain cannot be joined.
    """

    def __init__(
        self,
        domain: Domain,
        node_name: str,
        node_namespace: str = "/",
        because: str = "",
        definitions: Definitions = DEFINITIONS,
    ) -> None:
        names.check_node_name(node_name)
        names.check_namespace(node_namespace)
        self.description = f"dds (Eclipse Cyclone DDS), {domain}" + (f"; {because}" if because else "")
        self.spin_time = 0.0 if domain.discovery_range == "OFF" else 0.5
        self._domain = domain
        self._definitions = definitions
        self._name = node_name
        self._namespace = node_namespace
        self._lock = threading.RLock()
        self._closed = False
        self._topics: dict[str, tuple[str, Any]] = {}
        self._writers: list[DdsWriter] = []
        self._readers: list[DdsReader] = []
        self._delivering: DdsReader | None = None
        self._discovery: Discovery | None = None
        self._thread = threading.Thread(target=self._receive, name=f"dds domain {domain.id}", daemon=True)
        # An enclave is what makes ROS 2 take a participant for one of its own.
        self._participant = cyclone.join(domain, "enclave=/;")
        try:
            self._wake = GuardCondition(self._participant)
            self._waitset = WaitSet(self._participant)
            self._waitset.attach(self._wake)
            self._told = self._endpoint(DataWriter, discovery.TOPIC, discovery.TYPE, discovery.TELLING)
            self._rosout = self.writer(rosout.TOPIC, rosout.TYPE, rosout.QOS)
            self.writer("/parameter_events", "rcl_interfaces/msg/ParameterEvent", PARAMETER_EVENTS)
        except BaseException:
            cyclone.leave(domain, self._participant)
            raise
        self._thread.start()
        atexit.register(self.close)

    def writer(self, topic: str, message_type: str, qos: QoS) -> DdsWriter:
        """A writer on a topic.

        Raises:
            MessageTypeError: there is no such type.
            TransportError: the topic has another type here, or the transport is closed.
        """
        with self._lock:
            writer = DdsWriter(topic, self._endpoint(DataWriter, f"rt{topic}", message_type, qos), self._remove)
            self._writers.append(writer)
            self._watch(writer.entity, DDSStatus.PublicationMatched)
        writer.refresh()
        return writer

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Callable[[bytes], None]) -> DdsReader:
        """A reader on a topic; `deliver` runs in the transport's thread, and should do little.

        Raises:
            TransportError: as for `writer`.
        """
        with self._lock:
            entity = self._endpoint(DataReader, f"rt{topic}", message_type, qos)
            reader = DdsReader(topic, entity, deliver, self._remove)
            self._readers.append(reader)
            self._watch(reader.entity, DDSStatus.DataAvailable)
        return reader

    @property
    def source(self) -> bytes:
        """GID of the writer of the message that is being delivered; empty when it is gone already."""
        return self._delivering.source if self._delivering else b""

    def graph(self) -> Graph:
        """Who writes and reads which topic, as far as it is known.

        Raises:
            TransportError: the transport is closed.
        """
        with self._lock:
            if self._closed:
                raise TransportError("the transport is closed")
            if self._discovery is None:
                nodes = self._endpoint(DataReader, discovery.TOPIC, discovery.TYPE, discovery.HEARING)
                self._discovery = Discovery(self._participant, nodes)
            return self._discovery.graph()

    def log(self, severity: str, text: str) -> None:
        """Tell people who watch /rosout; severities are info, warning and error."""
        with self._lock:
            if not self._closed:
                self._rosout.write(rosout.record(self._namespace, self._name, severity, text))

    def close(self) -> None:
        """Withdraw the node, end the thread, and leave the network; safe to call twice."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            self._announce(())
        self._wake.set(True)
        self._thread.join()
        cyclone.leave(self._domain, self._participant)
        for writer in self._writers:
            writer.matched = False
        atexit.unregister(self.close)

    def _endpoint(self, make: Callable[..., Any], topic: str, message_type: str, qos: QoS) -> Any:
        shown = topic.removeprefix("rt")
        if self._closed:
            raise TransportError(f"{shown}: the transport is closed")
        known, described = self._topics.get(topic, (message_type, None))
        if known != message_type:
            raise TransportError(f"{shown} has the type {known} here, it cannot have {message_type} besides")
        policies = cyclone.endpoint_qos(qos, f"typehash={self._definitions.type_hash(message_type)};")
        try:
            described = described or Topic(self._participant, topic, idl_type(message_type, self._definitions))
            self._topics[topic] = (message_type, described)
            return make(self._participant, described, qos=policies)
        except DDSException as error:
            raise TransportError(f"{shown} cannot be opened: {error}") from error

    def _watch(self, entity: Any, status: int) -> None:
        entity.set_status_mask(status)
        self._waitset.attach(entity)
        self._announce((self._node(),))

    def _remove(self, endpoint: DdsWriter | DdsReader) -> None:
        with self._lock:
            endpoints: list[Any] = self._writers if isinstance(endpoint, DdsWriter) else self._readers
            if self._closed or endpoint not in endpoints:
                return
            endpoints.remove(endpoint)
            self._waitset.detach(endpoint.entity)
            cyclone.delete(endpoint.entity)
            others: list[DdsWriter | DdsReader] = [*self._writers, *self._readers]
            if all(other.topic != endpoint.topic for other in others):
                cyclone.delete(self._topics.pop(f"rt{endpoint.topic}")[1])
            self._announce((self._node(),))
        if isinstance(endpoint, DdsWriter):
            endpoint.refresh()

    def _node(self) -> messages.NodeEntitiesInfo:
        readers = [_gid(reader.entity) for reader in self._readers]
        writers = [_gid(writer.entity) for writer in self._writers]
        return messages.NodeEntitiesInfo(self._namespace, self._name, readers, writers)

    def _announce(self, nodes: tuple[messages.NodeEntitiesInfo, ...]) -> None:
        info = messages.ParticipantEntitiesInfo(_gid(self._participant), list(nodes))
        cyclone.write(self._told, messages.encode(info))

    def _receive(self) -> None:
        while not self._closed:
            triggered = self._waitset.wait(_FOREVER)
            arrived = busy = [reader for reader in tuple(self._readers) if self._drain(reader)]
            while busy and not self._closed:
                busy = [reader for reader in busy if self._drain(reader)]
            # More entities triggered than readers had messages: some are writers, whose readers came or went.
            if triggered > len(arrived):
                for writer in tuple(self._writers):
                    writer.refresh()

    def _drain(self, reader: DdsReader) -> bool:
        self._delivering = reader
        return reader.drain()


def _gid(entity: Any) -> Any:
    """How ROS 2 calls an entity: the 16 bytes of its RTPS GUID, as a Gid."""
    return messages.Gid(np.frombuffer(entity.guid.bytes, np.uint8))
