"""The base class of a session's endpoints, and the interface of the network that they use."""

from __future__ import annotations

from abc import abstractmethod
from collections import Counter
from collections.abc import Callable

from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import EndpointClaim, Network, Sink
from graphengine.ros.transport import Transport


class HeldEndpoint:
    """An endpoint that stays open until every node that holds it has closed it."""

    opened_as: EndpointClaim
    """Claim for which the endpoint was created; unlike `claim`, it keeps its type when a subscription switches to another."""
    holders = 1
    arrival = 0
    """Number of the tick that delivered the newest messages; 0 before the first message."""

    def release(self) -> bool:
        """Remove one holder of the endpoint; return whether it was the last one."""
        self.holders -= 1
        return self.holders <= 0


class EndpointHost(Network):
    """What all endpoints of a session share.

    Args:
        complain: called with each warning about malformed messages or incompatible peers, once per warning.
        definitions: message types.
    """

    def __init__(self, complain: Callable[[str], None], definitions: Definitions) -> None:
        self.complain = complain
        self.definitions = definitions
        self.sinks: list[Sink] = []
        """Sinks that receive every message, such as a recorder; with a sink, every publisher is `wanted`."""
        self.taps: list[Sink] = []
        self.outbox: list[tuple[Callable[[bytes], None], bytes]] = []
        """Messages of this tick, each with the function that sends it; `flush` sends them together at the end of the tick."""
        self.quotas: dict[str, int] = {}
        """Number of messages that each subscription takes in the next tick, by topic; topics that are missing have no limit."""
        self.undecoded: Counter[str] = Counter()
        """Number of messages that endpoints could not decode, by topic or service name."""

    @abstractmethod
    def transport(self, handle: int) -> Transport:
        """Return the transport for the handle of a ROS 2 context; join its domain at the first call."""

    @abstractmethod
    def leave(self, end: HeldEndpoint) -> None:
        """Remove a closed endpoint; the number of messages that it lost stays counted."""
