"""Services within one process, with the rules of DDS on who matches whom."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import mismatch
from graphengine.ros.transports.calls import Calls

GID = 16
"""Bytes by which a client is known; the number of its call follows in a request's identity."""


@dataclass(eq=False, slots=True)
class MemoryServer:
    """One service that is offered; its QoS is settled."""

    services: MemoryServices
    service: str
    service_type: str
    qos: QoS
    deliver: Callable[[bytes, bytes], None]

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Hand an answer to the client that asked, at once.

        Raises:
            TransportError: the server is closed.
        """
        if self not in self.services.servers:
            raise TransportError(f"{self.service}: the server is closed")
        for client in tuple(self.services.clients):
            if client.gid == request_id[:GID] and client.matches(self):
                client.receive(int.from_bytes(request_id[GID:], "big"), response)

    def close(self) -> None:
        """Withdraw the service; a second time does nothing."""
        if self in self.services.servers:
            self.services.servers.remove(self)


@dataclass(eq=False, slots=True)
class MemoryClient:
    """One service that is called; its QoS is settled."""

    services: MemoryServices
    service: str
    service_type: str
    qos: QoS
    deliver: Callable[[int, bytes], None]
    gid: bytes
    calls: Calls = field(default_factory=Calls)

    @property
    def ready(self) -> bool:
        """Whether a server is there that matches."""
        return self in self.services.clients and any(map(self.matches, self.services.servers))

    def call(self, request: bytes) -> int:
        """Hand a request to every server that matches, at once.

        Raises:
            TransportError: the client is closed.
        """
        if self not in self.services.clients:
            raise TransportError(f"{self.service}: the client is closed")
        number = self.calls.begin()
        for server in tuple(self.services.servers):
            if self.matches(server):
                server.deliver(self.gid + number.to_bytes(8, "big"), request)
        return number

    def matches(self, server: MemoryServer) -> bool:
        """Whether service, type and quality of service fit, for requests and answers."""
        same = (self.service, self.service_type) == (server.service, server.service_type)
        return same and not mismatch(self.qos, server.qos) and not mismatch(server.qos, self.qos)

    def receive(self, number: int, response: bytes) -> None:
        """Deliver the first answer to a call."""
        if self.calls.end(number):
            self.deliver(number, response)

    def close(self) -> None:
        """Leave the service; a second time does nothing."""
        if self in self.services.clients:
            self.services.clients.remove(self)


@dataclass(slots=True)
class MemoryServices:
    """Servers and clients of all services."""

    servers: list[MemoryServer] = field(default_factory=list)
    clients: list[MemoryClient] = field(default_factory=list)

    def known(self) -> set[tuple[str, str]]:
        """Names and types."""
        offered = {(server.service, server.service_type) for server in self.servers}
        return offered | {(client.service, client.service_type) for client in self.clients}

    def clear(self) -> None:
        """Close all."""
        self.servers.clear()
        self.clients.clear()
