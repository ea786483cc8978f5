"""Nodes of one process that exchange messages; each delivers in a thread of its own, as a transport over a network does."""

from __future__ import annotations

import queue
import threading
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import Any

from graphengine.messages.endpoints import QoS
from graphengine.ros.graph import Direction, Graph
from graphengine.ros.transport import JoinOptions, Reader, ServiceClient, ServiceServer, TransportKind, Writer
from graphengine.ros.transports.handing_over import HandingOver
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
    malformed: Mapping[str, int] = MappingProxyType({})
    foreign_services: Mapping[str, str] = MappingProxyType({})

    def __init__(self, options: JoinOptions) -> None:
        super().__init__(options.node_name, options.node_namespace, options.definitions)
        self.description = f"acme, {options.domain}"
        self.source = b""
        self._hub = HUBS.setdefault(
            options.domain.id, Hub(MemoryTransport(keeps=False, definitions=options.definitions))
        )
        self._ends: list[Any] = []
        self._offered = Counter[str]()
        self._arrived: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._deliver_all, name=self.description, daemon=True)
        self._thread.start()
        self._rosout = self.writer(*ROSOUT)

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """A writer on a topic."""
        self._admit(topic)
        writer = self._hub.memory.writer(topic, message_type, qos)
        self._hub.owners[writer.gid] = self._name, self._namespace
        self._ends.append(writer)
        return writer

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Callable[[bytes], None]) -> Reader:
        """A reader on a topic."""
        self._admit(topic)
        end = _End(self, topic, deliver)
        end.inner = self._hub.memory.reader(topic, message_type, qos, end.arrive)
        self._hub.owners[end.inner.gid] = self._name, self._namespace
        return end

    def server(
        self, service: str, service_type: str, qos: QoS, deliver: Callable[[bytes, bytes], None]
    ) -> ServiceServer:
        """A server of a service."""
        self._admit(service)
        end = _Server(self, service, deliver)
        end.inner = self._hub.memory.server(service, service_type, qos, end.arrive)
        for counts in (self._offered, self._hub.offered):
            counts[service] += 1
        return end

    def client(self, service: str, service_type: str, qos: QoS, deliver: Callable[[int, bytes], None]) -> ServiceClient:
        """A client of a service."""
        self._admit(service)
        end = _Client(self, service, deliver)
        end.inner = self._hub.memory.client(service, service_type, qos, end.arrive)
        return end

    @property
    def rival_services(self) -> Sequence[str]:
        """Services that another node offers too."""
        return [name for name, number in self._offered.items() if 0 < number < self._hub.offered[name]]

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> Graph:
        """Who writes and reads which topic."""
        self._admit()
        found = self._hub.memory.graph(asked)
        owned = [(end, *self._hub.owners[end.gid]) for end in found.endpoints]
        ends = [replace(end, node=node, namespace=namespace) for end, node, namespace in owned]
        return Graph(ends, services=found.services)

    def close(self) -> None:
        """Leave the hub."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            for end in tuple(self._ends):
                end.close()
        self._arrived.put(None)
        if threading.current_thread() is not self._thread:
            self._thread.join()

    def _deliver_all(self) -> None:
        while (deliver := self._arrived.get()) is not None:
            deliver()


class _End:
    """An endpoint that takes messages in the thread of its node, until it is closed."""

    def __init__(self, node: AcmeTransport, name: str, deliver: Callable[..., None]) -> None:
        self.inner: Any = None
        """The endpoint of the hub."""
        self._node = node
        self._name = name
        self._deliver = deliver
        self._hand_over = HandingOver(name)
        self._open = True
        node._ends.append(self)

    def arrive(self, *message: Any) -> None:
        """Take a message in the thread of the one who sends it."""
        self._node._arrived.put(partial(self._take, self._node._hub.memory.source, message))

    def close(self) -> None:
        """Leave the hub; a second time does nothing."""
        with self._node._lock:
            if self._open:
                self._open = False
                self._node._ends.remove(self)
                if self.inner is not None:
                    self.inner.close()

    def _take(self, source: bytes, message: tuple[Any, ...]) -> None:
        with self._node._lock:
            if self._open:
                self._node.source = source
                self._hand_over(self._deliver, *message)


class _Server(_End):
    def answer(self, request_id: bytes, response: bytes) -> None:
        """Answer a request."""
        self.inner.answer(request_id, response)

    def close(self) -> None:
        """Withdraw the service."""
        with self._node._lock:
            if self._open:
                for counts in (self._node._offered, self._node._hub.offered):
                    counts[self._name] -= 1
            super().close()


class _Client(_End):
    @property
    def ready(self) -> bool:
        """Whether a server is there."""
        return bool(self.inner.ready)

    def call(self, request: bytes) -> int:
        """Call the service."""
        return int(self.inner.call(request))


TRANSPORT = TransportKind("acme", "other nodes of the same process", AcmeTransport, reaches_others=False)
