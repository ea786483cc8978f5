"""A network without peers: endpoints that lead nowhere."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from graphengine.messages.endpoints import EndpointClaim, OwnedClient, OwnedPublisher, OwnedServer, OwnedSubscription


class DryNetwork:
    """Endpoints that lead nowhere."""

    def publisher(self, claim: EndpointClaim) -> OwnedPublisher:
        """Nobody listens."""
        return DryEndpoint(claim.topic)

    def subscription(self, claim: EndpointClaim) -> OwnedSubscription:
        """Nobody speaks."""
        return DryEndpoint(claim.topic)

    def server(self, claim: EndpointClaim, handle: int) -> OwnedServer:
        """Nobody asks."""
        return DryServer(claim.topic, claim.message_type, handle)

    def client(self, claim: EndpointClaim) -> OwnedClient:
        """Nobody answers."""
        return DryClient(claim.topic)

    def freeze(self) -> None:
        """Nothing has arrived."""

    def flush(self) -> None:
        """Nothing was published."""

    def save(self) -> None:
        """Nothing has arrived."""

    def restore(self, saved: Any) -> None:
        """Nothing has arrived."""

    def forget_calls(self) -> None:
        """Nothing was asked."""

    def log(self, severity: str, message: str) -> None:
        """Nobody reads."""

    def close(self) -> None:
        """Nothing is held."""


class DryEndpoint:
    """A publisher nobody listens to, and a subscription nobody writes to."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.wanted = False
        self.skipped = 0

    def close(self) -> None:
        """Nothing is held."""

    def publish(self, message: Any) -> None:
        """Drop it."""

    def newest(self) -> Any | None:
        """Nothing."""
        return None

    def take(self) -> Sequence[Any]:
        """Nothing."""
        return ()


class DryServer:
    """A service that nobody calls."""

    def __init__(self, service: str, service_type: str, handle: int) -> None:
        self.service = service
        self.service_type = service_type
        self.handle = handle
        self.current: bytes | None = None

    def close(self) -> None:
        """Nothing is held."""

    def take(self) -> Sequence[tuple[bytes, Any]]:
        """Nothing."""
        return ()

    def answer(self, request_id: bytes, response: Any) -> None:
        """Drop it."""


class DryClient:
    """A service that nobody offers."""

    def __init__(self, service: str) -> None:
        self.service = service
        self._calls = 0

    def close(self) -> None:
        """Nothing is held."""

    def call(self, request: Any) -> int:
        """Drop it."""
        self._calls += 1
        return self._calls

    def take(self) -> Sequence[tuple[int, Any]]:
        """Nothing."""
        return ()
