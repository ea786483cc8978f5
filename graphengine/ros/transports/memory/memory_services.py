"""Service servers and clients of the memory transport; they match by the rules of DDS."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import mismatch
from graphengine.ros.transports.calls import Calls

GID = 16
"""Size of a client's GID, bytes. A request's identity is the client's GID, followed by the number of the call."""


@dataclass(eq=False)
class _MemoryService:
    """A service server or client; its QoS has actual values instead of `systemDefault`."""

    services: list[Any]
    """All open servers and clients of the transport."""
    service: str
    service_type: str
    qos: QoS
    deliver: Callable[[Any, bytes], None]

    def matches(self, other: _MemoryService) -> bool:
        """Return whether a peer has the same service and service type, and a QoS that is compatible in both directions."""
        same = (self.service, self.service_type) == (other.service, other.service_type)
        return same and not mismatch(self.qos, other.qos) and not mismatch(other.qos, self.qos)

    def close(self) -> None:
        """Close the endpoint; safe to call twice."""
        if self in self.services:
            self.services.remove(self)

    def _peers(self, kind: type[Any]) -> list[Any]:
        """Return the matching endpoints of class `kind`; empty after `close`."""
        open_ends = self.services if self in self.services else ()
        return [end for end in open_ends if isinstance(end, kind) and self.matches(end)]

    def _admit(self) -> None:
        if self not in self.services:
            raise TransportError(f"{self.service} is closed")


class MemoryServer(_MemoryService):
    """A service server of a `MemoryTransport`."""

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Deliver a response to the client of a request immediately.

        Raises:
            TransportError: the server is closed.
        """
        self._admit()
        for client in self._peers(MemoryClient):
            if client.gid == request_id[:GID]:
                client.receive(int.from_bytes(request_id[GID:], "big"), response)


@dataclass(eq=False)
class MemoryClient(_MemoryService):
    """A service client of a `MemoryTransport`."""

    gid: bytes
    calls: Calls = field(default_factory=Calls)

    @property
    def ready(self) -> bool:
        """Whether a matching server exists."""
        return bool(self._peers(MemoryServer))

    def call(self, request: bytes) -> int:
        """Deliver a request to all matching servers immediately; return the number of the call.

        Raises:
            TransportError: the client is closed.
        """
        self._admit()
        number = self.calls.begin()
        for server in self._peers(MemoryServer):
            server.deliver(self.gid + number.to_bytes(8, "big"), request)
        return number

    def receive(self, number: int, response: bytes) -> None:
        """Deliver the first response to a call; later responses are ignored."""
        if self.calls.end(number):
            self.deliver(number, response)
