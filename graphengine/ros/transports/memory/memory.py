"""A transport whose messages stay in this process, for tests and headless runs; written messages can be read back."""

from __future__ import annotations

import itertools
from collections import defaultdict, deque
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, get_args

from graphengine.format.errors import TransportError
from graphengine.format.wording import listing
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import settled
from graphengine.ros.network_graph import Direction, Endpoint, NetworkGraph
from graphengine.ros.transport import Deliver, DeliverRequest, DeliverResponse
from graphengine.ros.transports.memory.memory_services import MemoryClient, MemoryServer


@dataclass(eq=False)
class _MemoryEnd:
    """A writer or reader of a `MemoryTransport`."""

    transport: MemoryTransport
    endpoint: Endpoint
    """Description of the endpoint; the QoS has actual values instead of `systemDefault`."""

    def close(self) -> None:
        """Close the endpoint; safe to call twice."""
        self.transport.remove(self)


@dataclass(eq=False)
class MemoryWriter(_MemoryEnd):
    """A writer on a topic of a `MemoryTransport`."""

    dropped = 0

    kept: deque[tuple[int, bytes]] = field(init=False)
    """Messages kept for late joiners, each with its number in the order of all messages; empty unless transient local."""
    is_open: bool = True
    readers: list[MemoryReader] = field(default_factory=list)
    """Matching readers in creation order."""

    def __post_init__(self) -> None:
        qos = self.endpoint.qos
        latched, unlimited = qos.durability == "transientLocal", qos.history == "keepAll"
        self.kept = deque(maxlen=(None if unlimited else qos.depth) if latched else 0)

    @property
    def matched(self) -> int:
        """Number of matching readers; at least 1 if the transport has `wants_all`, and 0 after `close`."""
        return max(len(self.readers), int(self.transport.wants_all)) if self.is_open else 0

    def write(self, data: bytes) -> None:
        """Deliver a message to all matching readers immediately.

        Raises:
            TransportError: the writer is closed.
        """
        self.transport.send(self, data)


@dataclass(eq=False)
class MemoryReader(_MemoryEnd):
    """A reader on a topic of a `MemoryTransport`."""

    deliver: Deliver


@dataclass(slots=True)
class _MemoryTopic:
    """Writers and readers of a topic, and each message that was written to the topic, with the message type."""

    writers: list[MemoryWriter] = field(default_factory=list)
    readers: list[MemoryReader] = field(default_factory=list)
    sent: list[tuple[str, bytes]] = field(default_factory=list)


class MemoryTransport:
    """A transport within one process. Endpoints match, and late joiners get kept messages, as in DDS.

    Args:
        wants_all: whether a writer without readers counts as matched too, so that nodes build all messages.
        keeps: whether `raw` and `messages` return all written messages; memory use then grows with each message.
        definitions: message types.
    """

    description = "memory: nothing leaves this process"
    notices: Sequence[str] = ()
    spin_time = 0.0
    node = ""
    identity = b""
    malformed: Mapping[str, int] = MappingProxyType({})
    foreign_services: Mapping[str, str] = MappingProxyType({})
    rival_services: Sequence[str] = ()

    def __init__(self, *, wants_all: bool = False, keeps: bool = True, definitions: Definitions = DEFINITIONS) -> None:
        self._definitions = definitions
        self.wants_all = wants_all
        self._keeps = keeps
        self.source = b""
        """GID of the writer whose message is being delivered; empty for an injected message."""
        self._closed = False
        self._numbers = itertools.count()
        self._topics: defaultdict[str, _MemoryTopic] = defaultdict(_MemoryTopic)
        self._services: list[MemoryServer | MemoryClient] = []
        """All open service servers and clients."""

    def writer(self, topic: str, message_type: str, qos: QoS) -> MemoryWriter:
        """Create a writer on a topic.

        Raises:
            MessageTypeError: the type is unknown.
            TransportError: the transport is closed.
        """
        writer = MemoryWriter(self, self._endpoint("publish", topic, message_type, qos))
        readers = self._topics[topic].readers
        writer.readers += [reader for reader in readers if writer.endpoint.serves(reader.endpoint)]
        self._topics[topic].writers.append(writer)
        return writer

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> MemoryReader:
        """Create a reader on a topic; `deliver` runs in the thread that writes the message.

        Raises:
            TransportError: as for `writer`.
        """
        reader = MemoryReader(self, self._endpoint("subscribe", topic, message_type, qos), deliver)
        self._topics[topic].readers.append(reader)
        matching = [writer for writer in self._topics[topic].writers if writer.endpoint.serves(reader.endpoint)]
        for writer in matching:
            writer.readers.append(reader)
        wanted = reader.endpoint.qos
        if wanted.durability == "transientLocal":
            missed = sorted((number, data, writer.endpoint.gid) for writer in matching for number, data in writer.kept)
            for _, data, self.source in missed if wanted.history == "keepAll" else missed[-wanted.depth :]:
                deliver(data)
        return reader

    def server(
        self, service: str, service_type: str, qos: QoS, deliver: DeliverRequest, node: str = ""
    ) -> MemoryServer:
        """Create a server of a service; `deliver` runs in the thread that calls the service, and `node` has no effect.

        Raises:
            TransportError: as for `writer`.
        """
        self._admit(service, *self._definitions.service_parts(service_type))
        server = MemoryServer(self._services, service, service_type, settled(qos), deliver)
        self._services.append(server)
        return server

    def client(self, service: str, service_type: str, qos: QoS, deliver: DeliverResponse) -> MemoryClient:
        """Create a client of a service; `deliver` runs in the thread that sends the response.

        Raises:
            TransportError: as for `writer`.
        """
        self._admit(service, *self._definitions.service_parts(service_type))
        client = MemoryClient(self._services, service, service_type, settled(qos), deliver, self.new_gid())
        self._services.append(client)
        return client

    def raw(self, topic: str) -> list[bytes]:
        """Return all messages that were written to a topic, as CDR bytes, oldest first."""
        return [data for _, data in self._topics[topic].sent]

    def messages(self, topic: str) -> list[Any]:
        """Return all messages that were written to a topic, decoded, oldest first."""
        return [messages.decode(data, kind, self._definitions) for kind, data in self._topics[topic].sent]

    def inject(self, topic: str, message: Any) -> None:
        """Deliver a message to all readers of a topic, as if a matching peer had published it; bytes are delivered unchanged.

        Raises:
            TransportError: the topic has no readers, or a reader has another type.
        """
        readers = list(self._topics[topic].readers)
        if not readers:
            read = sorted(name for name, other in self._topics.items() if other.readers)
            raise TransportError(f"{topic} has no readers\n{listing(read, 'topics with readers')}")
        if not isinstance(message, bytes):
            found = messages.message_type(message)
            for reader in readers:
                if reader.endpoint.message_type != found:
                    raise TransportError(f"{topic} is read as {reader.endpoint.message_type}, not as {found}")
            message = messages.encode(message, self._definitions)
        self.source = b""
        for reader in readers:
            reader.deliver(message)

    def log(self, severity: str, text: str) -> None:
        """Do nothing: this transport has no node."""

    def save(self) -> Any:
        """Return a copy of the messages kept for late joiners, and of the open calls."""
        kept = {name: [list(writer.kept) for writer in topic.writers] for name, topic in self._topics.items()}
        return kept, [client.calls.save() for client in self._clients]

    def restore(self, saved: Any) -> None:
        """Restore the state that `save` returned; this does not change the results of `raw` and `messages`."""
        topics, calls = saved
        for name, topic in self._topics.items():
            for writer, kept in zip(topic.writers, topics.get(name, ()), strict=False):
                writer.kept.clear()
                writer.kept.extend(kept)
        for client, state in zip(self._clients, calls, strict=False):
            client.calls.restore(state)

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Return all endpoints, or those of the topics and directions in `asked`. The endpoints have no node names.

        Raises:
            TransportError: the transport is closed.
        """
        if self._closed:
            raise TransportError("the transport is closed")
        ends: list[_MemoryEnd] = []
        for name, direction in itertools.product(tuple(self._topics), get_args(Direction)) if asked is None else asked:
            if topic := self._topics.get(name):
                ends += topic.writers if direction == "publish" else topic.readers
        services = {(end.service, end.service_type) for end in self._services}
        return NetworkGraph((end.endpoint for end in ends), services=services)

    def new_gid(self) -> bytes:
        """Return a new GID that is unique within this transport."""
        return next(self._numbers).to_bytes(16, "big")

    def close(self) -> None:
        """Close all endpoints; `raw` and `messages` still return the written messages."""
        self._closed = True
        for topic in self._topics.values():
            for writer in topic.writers:
                writer.is_open = False
            topic.writers.clear()
            topic.readers.clear()
        self._services.clear()

    def send(self, writer: MemoryWriter, data: bytes) -> None:
        """Keep a writer's message and deliver it to the matching readers.

        Raises:
            TransportError: the writer is closed.
        """
        topic = writer.endpoint.topic
        if not writer.is_open:
            raise TransportError(f"{topic}: the writer is closed")
        if self._keeps:
            self._topics[topic].sent.append((writer.endpoint.message_type, data))
        writer.kept.append((next(self._numbers), data))
        for reader in tuple(writer.readers):
            self.source = writer.endpoint.gid
            reader.deliver(data)

    def remove(self, end: _MemoryEnd) -> None:
        """Remove an endpoint from the transport; a removed writer refuses further messages."""
        topic = self._topics[end.endpoint.topic]
        if isinstance(end, MemoryWriter):
            end.is_open = False
        known: list[list[Any]] = [topic.writers, topic.readers, *(writer.readers for writer in topic.writers)]
        for ends in known:
            if end in ends:
                ends.remove(end)

    @property
    def _clients(self) -> list[MemoryClient]:
        return [end for end in self._services if isinstance(end, MemoryClient)]

    def _endpoint(self, direction: Direction, topic: str, message_type: str, qos: QoS) -> Endpoint:
        self._admit(topic, message_type)
        type_hash = self._definitions.type_hash(message_type)
        return Endpoint(self.new_gid(), direction, topic, message_type, settled(qos), type_hash)

    def _admit(self, name: str, *message_types: str) -> None:
        if self._closed:
            raise TransportError(f"{name}: the transport is closed")
        for message_type in message_types:
            self._definitions.message_class(message_type)
