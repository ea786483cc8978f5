"""Nodes of one process that exchange messages; each delivers in a thread of its own, as a transport over a network does."""

from __future__ import annotations

import queue
import threading
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from graphengine.messages.endpoints import QoS
from graphengine.ros.network_graph import Direction, NetworkGraph
from graphengine.ros.transport import (
    JoinOptions,
    Reader,
    Transport,
    TransportClient,
    TransportKind,
    TransportServer,
    Writer,
)
from graphengine.ros.transports.ends import RosEnd
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.ros.transports.ros_node import ROSOUT, RosNode


@dataclass
class Hub:
    """Where the nodes of one domain meet."""

    memory: MemoryTransport
    owners: dict[bytes, tuple[str, str]] = field(default_factory=dict)
    """Name and namespace of the node that has an endpoint, by its GID."""
    offered: Counter[str] = field(default_factory=Counter)
    """Number of servers of each service."""


HUBS: dict[int, Hub] = {}


class AcmeTransport(RosNode):
    """A node among those of the same domain in this process."""

    spin_time = 0.0
    source = b""

    def _join(self) -> str:
        memory = MemoryTransport(keeps=False, definitions=self._definitions)
        self._hub = HUBS.setdefault(self._domain.id, Hub(memory))
        self._arrived: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._deliver_all, name=self.node, daemon=True)
        self._rosout = self.writer(*ROSOUT)
        self._thread.start()
        return "acme"

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """A writer on a topic."""
        self._admit(topic)
        end = _Writer(topic, self._remove, self._hub.memory.writer(topic, message_type, qos))
        self._hub.owners[end.inner.endpoint.gid] = self._name, self._namespace
        self._writers.append(end)
        return end

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Callable[[bytes], None]) -> Reader:
        """A reader on a topic."""
        self._admit(topic)
        end = _Hearing(topic, self._remove, self, deliver)
        end.inner = self._hub.memory.reader(topic, message_type, qos, end.arrive)
        self._hub.owners[end.inner.endpoint.gid] = self._name, self._namespace
        self._readers.append(end)
        return end

    def server(
        self, service: str, service_type: str, qos: QoS, deliver: Callable[[bytes, bytes], None], node: str = ""
    ) -> TransportServer:
        """A server of a service; all are of one node."""
        self._check_node(node)
        self._admit(service)
        end = _Server(service, self._remove, self, deliver)
        end.inner = self._hub.memory.server(service, service_type, qos, end.arrive)
        self._hub.offered[service] += 1
        self._readers.append(end)
        return end

    def client(
        self, service: str, service_type: str, qos: QoS, deliver: Callable[[int, bytes], None]
    ) -> TransportClient:
        """A client of a service."""
        self._admit(service)
        end = _Client(service, self._remove, self, deliver)
        end.inner = self._hub.memory.client(service, service_type, qos, end.arrive)
        self._readers.append(end)
        return end

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Who writes and reads which topic."""
        self._admit()
        found = self._hub.memory.graph(asked)
        owned = [(end, *self._hub.owners[end.gid]) for end in found.endpoints]
        ends = [replace(end, node=node, namespace=namespace) for end, node, namespace in owned]
        return NetworkGraph(ends, services=found.services)

    def take(self, end: _Hearing, source: bytes, message: tuple[Any, ...]) -> None:
        """Deliver a message, unless its endpoint was closed since it arrived."""
        with self._lock:
            if end in self._readers and not self._closed:
                self.source = source
                end.hand_over(end.deliver, *message)

    def arrive(self, end: _Hearing, message: tuple[Any, ...]) -> None:
        """Leave a message to the thread of the node."""
        self._arrived.put(partial(self.take, end, self._hub.memory.source, message))

    def _leave(self) -> None:
        for end in (*self._writers, *self._readers):
            self._delete(end)
        self._arrived.put(None)
        self._thread.join()

    def _delete(self, end: _Writer | _Hearing) -> None:
        end.inner.close()
        if end.peer == "client":
            self._hub.offered[end.name] -= 1

    def _count_servers(self, services: Iterable[str]) -> Mapping[str, int]:
        return self._hub.offered

    def _deliver_all(self) -> None:
        while (deliver := self._arrived.get()) is not None:
            deliver()


class _Writer(RosEnd):
    def __init__(self, name: str, remove: Callable[[Any], None], inner: Any) -> None:
        super().__init__(name, remove)
        self.inner = inner
        """The endpoint of the hub."""

    @property
    def matched(self) -> bool:
        """Whether a reader is there."""
        return bool(self.inner.matched)

    def write(self, data: bytes) -> None:
        """Send a message."""
        self.inner.write(data)


class _Hearing(RosEnd):
    """An endpoint that takes messages in the thread of its node, until it is closed."""

    inner: Any = None

    def __init__(
        self, name: str, remove: Callable[[Any], None], node: AcmeTransport, deliver: Callable[..., None]
    ) -> None:
        super().__init__(name, remove)
        self.deliver = deliver
        self._node = node

    def arrive(self, *message: Any) -> None:
        """Take a message in the thread of the one who sends it."""
        self._node.arrive(self, message)


class _Server(_Hearing):
    peer = "client"

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Answer a request."""
        self.inner.answer(request_id, response)


class _Client(_Hearing):
    peer = "server"

    @property
    def ready(self) -> bool:
        """Whether a server is there."""
        return bool(self.inner.ready)

    def call(self, request: bytes) -> int:
        """Call the service."""
        return int(self.inner.call(request))


def _open(options: JoinOptions) -> Transport:
    return AcmeTransport(options)


TRANSPORT = TransportKind("acme", "other nodes of the same process", _open, reaches_others=False)
