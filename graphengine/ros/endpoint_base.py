"""The base class of a session's endpoints, and the interface of the network that they use."""

from __future__ import annotations

from abc import abstractmethod
from collections import Counter
from collections.abc import Callable
from typing import Any

from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import EndpointClaim, Network, Sink
from graphengine.ros.transport import Complain, Transport


class HeldEndpoint:
    """An endpoint that stays open until every node that holds it has closed it."""

    opened_as: EndpointClaim
    """Claim for which the endpoint was created; it does not change when a subscription switches its type, but `claim` does."""
    holders = 1
    arrival = 0
    """Number of the tick that delivered the newest messages; 0 before the first message."""
    _network: EndpointHost
    _end: Any
    """The transport's writer, reader, server or client that carries the messages."""

    def close(self) -> None:
        """Release the endpoint; the last release closes it on the transport."""
        self.holders -= 1
        if self.holders <= 0:
            self._end.close()
            self._network.leave(self)


class EndpointHost(Network):
    """The part of a session's network that its endpoints use: message types, sinks, the outbox and counts of lost messages.

    Args:
        complain: called once with each warning about malformed messages or incompatible peers.
        definitions: message types.
    """

    def __init__(self, complain: Complain, definitions: Definitions) -> None:
        self.complain = complain
        self.definitions = definitions
        self.sinks: list[Sink] = []
        """Sinks that receive every message, such as a recorder; with a sink, every publisher is `wanted`."""
        self.taps: list[Sink] = []
        self.outbox: list[tuple[Callable[[bytes], None], bytes]] = []
        """Messages of this tick, each with the function that sends it; `flush` sends all of them at the end of the tick."""
        self.quotas: dict[str, int] = {}
        """For each topic in lockstep, the number of messages that a subscription takes in the next tick; others have no limit."""
        self.undecoded: Counter[str] = Counter()
        """Number of messages that endpoints could not decode, by topic or service name."""

    @abstractmethod
    def transport(self, handle: int) -> Transport:
        """Return the transport for the handle of a ROS 2 context; join its domain at the first call."""

    @abstractmethod
    def leave(self, end: HeldEndpoint) -> None:
        """Remove a closed endpoint; the messages that the endpoint lost stay counted."""
