"""Services within one process, with the rules of DDS on who matches whom."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import mismatch
from graphengine.ros.transports.calls import Calls

GID = 16
"""Bytes by which a client is known; the number of its call follows in a request's identity."""


@dataclass(eq=False)
class _MemoryService:
    """A server or client; its QoS is settled."""

    services: list[Any]
    """All servers and clients that are open."""
    service: str
    service_type: str
    qos: QoS
    deliver: Callable[[Any, bytes], None]

    def matches(self, other: _MemoryService) -> bool:
        """Whether service, type and quality of service fit, for requests and answers."""
        same = (self.service, self.service_type) == (other.service, other.service_type)
        return same and not mismatch(self.qos, other.qos) and not mismatch(other.qos, self.qos)

    def close(self) -> None:
        """Leave the service; a second time does nothing."""
        if self in self.services:
            self.services.remove(self)

    def _peers(self, kind: type[Any]) -> list[Any]:
        """Those of a kind that match, while this end is open."""
        open_ends = self.services if self in self.services else ()
        return [end for end in open_ends if isinstance(end, kind) and self.matches(end)]

    def _admit(self) -> None:
        if self not in self.services:
            raise TransportError(f"{self.service} is closed")


class MemoryServer(_MemoryService):
    """One service that is offered."""

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Hand an answer to the client that asked, at once.

        Raises:
            TransportError: the server is closed.
        """
        self._admit()
        for client in self._peers(MemoryClient):
            if client.gid == request_id[:GID]:
                client.receive(int.from_bytes(request_id[GID:], "big"), response)


@dataclass(eq=False)
class MemoryClient(_MemoryService):
    """One service that is called."""

    gid: bytes
    calls: Calls = field(default_factory=Calls)

    @property
    def ready(self) -> bool:
        """Whether a server is there that matches."""
        return bool(self._peers(MemoryServer))

    def call(self, request: bytes) -> int:
        """Hand a request to every server that matches, at once.

        Raises:
            TransportError: the client is closed.
        """
        self._admit()
        number = self.calls.begin()
        for server in self._peers(MemoryServer):
            server.deliver(self.gid + number.to_bytes(8, "big"), request)
        return number

    def receive(self, number: int, response: bytes) -> None:
        """Deliver the first answer to a call."""
        if self.calls.end(number):
            self.deliver(number, response)
