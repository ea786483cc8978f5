"""Services within one process, with the rules of DDS on who matches whom."""

from __future__ import annotations

from collections.abc import Callable

from graphengine.context import QoS
from graphengine.diagnostics import TransportError
from graphengine.ros.calls import Calls
from graphengine.ros.qos import mismatch, settled

GID = 16
"""Bytes by which a client is known; the number of its call follows in a request's identity."""


class MemoryServer:
    """One service that is offered."""

    def __init__(
        self,
        services: MemoryServices,
        service: str,
        service_type: str,
        qos: QoS,
        deliver: Callable[[bytes, bytes], None],
    ) -> None:
        self.service = service
        self.service_type = service_type
        self.qos = settled(qos)
        self.deliver = deliver
        self._services = services

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Hand an answer to the client that asked, at once.

        Raises:
            TransportError: the server is closed.
        """
        if self not in self._services.servers:
            raise TransportError(f"{self.service}: the server is closed")
        for client in tuple(self._services.clients):
            if client.gid == request_id[:GID] and client.matches(self):
                client.receive(int.from_bytes(request_id[GID:], "big"), response)

    def close(self) -> None:
        """Withdraw the service; a second time does nothing."""
        if self in self._services.servers:
            self._services.servers.remove(self)


class MemoryClient:
    """One service that is called."""

    def __init__(
        self,
        services: MemoryServices,
        service: str,
        service_type: str,
        qos: QoS,
        deliver: Callable[[int, bytes], None],
        gid: bytes,
    ) -> None:
        self.service = service
        self.service_type = service_type
        self.qos = settled(qos)
        self.gid = gid
        self._services = services
        self._deliver = deliver
        self._calls = Calls()

    @property
    def ready(self) -> bool:
        """Whether a server is there that matches."""
        return self in self._services.clients and any(map(self.matches, self._services.servers))

    def call(self, request: bytes) -> int:
        """Hand a request to every server that matches, at once.

        Raises:
            TransportError: the client is closed.
        """
        if self not in self._services.clients:
            raise TransportError(f"{self.service}: the client is closed")
        number = self._calls.begin()
        for server in tuple(self._services.servers):
            if self.matches(server):
                server.deliver(self.gid + number.to_bytes(8, "big"), request)
        return number

    def matches(self, server: MemoryServer) -> bool:
        """Whether service, type and quality of service fit, for requests and answers."""
        same = (self.service, self.service_type) == (server.service, server.service_type)
        return same and not mismatch(self.qos, server.qos) and not mismatch(server.qos, self.qos)

    def receive(self, number: int, response: bytes) -> None:
        """Deliver the first answer to a call."""
        if self._calls.end(number):
            self._deliver(number, response)

    def close(self) -> None:
        """Leave the service; a second time does nothing."""
        if self in self._services.clients:
            self._services.clients.remove(self)


class MemoryServices:
    """Who offers and calls services."""

    def __init__(self) -> None:
        self.servers: list[MemoryServer] = []
        self.clients: list[MemoryClient] = []

    def known(self) -> set[tuple[str, str]]:
        """Names and types."""
        offered = {(server.service, server.service_type) for server in self.servers}
        return offered | {(client.service, client.service_type) for client in self.clients}

    def clear(self) -> None:
        """Close all."""
        self.servers.clear()
        self.clients.clear()
