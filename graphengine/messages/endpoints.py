"""Interface between nodes and the network: topics and services with their quality of service.

The classes here work without a network, as checks need them; the classes for a live network are subclasses.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions


@dataclass(frozen=True, slots=True)
class QoS:
    """Quality of service of an endpoint, with the names of OmniGraph's QoS profiles; times in seconds, 0 for unlimited."""

    history: Literal["keepLast", "keepAll", "systemDefault"] = "keepLast"
    depth: int = 10
    reliability: Literal["reliable", "bestEffort", "systemDefault"] = "reliable"
    durability: Literal["volatile", "transientLocal", "systemDefault"] = "volatile"
    deadline: float = 0.0
    lifespan: float = 0.0
    liveliness: Literal["automatic", "manualByTopic", "systemDefault"] = "systemDefault"
    lease_duration: float = 0.0


@dataclass(frozen=True, slots=True)
class EndpointClaim:
    """An endpoint that a node requested in setup; checks and `graphrun topics` read it."""

    node: str
    """Prim path of the node."""
    graph: str
    topic: str
    """Full name of the topic, or of the service."""
    message_type: str
    """ROS 2 name of the message, or of the service."""
    direction: str
    """`publish` or `subscribe`; `serve` or `call` for a service."""
    qos: QoS
    ros_context: int = 0
    rate: float | None = None
    """Publishing rate, Hz; None if events trigger the messages."""
    latched: bool = False
    frame_id: str = ""
    """Published name of the frame in the message headers."""
    child_frame_id: str = ""
    """Published name of the child frame in the messages, such as that of odometry."""
    transforms: tuple[tuple[str, str], ...] = ()
    """Published names of parent and child of each transform."""
    alternatives: tuple[str, ...] = ()
    """Other message types that a subscription accepts if peers publish one of them instead."""

    @property
    def is_service(self) -> bool:
        """Whether the endpoint belongs to a service; a topic may have the same name."""
        return self.direction in ("serve", "call")


class TopicEndpoint:
    """A publisher or subscription of a node."""

    def __init__(self, claim: EndpointClaim) -> None:
        self.claim = claim
        self.topic = claim.topic
        """Full topic name."""

    def close(self) -> None:
        """Close the endpoint; the node's context does this. Safe to call twice."""


class Sink(Protocol):
    """Receives encoded messages, for example to record them."""

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Called with each encoded message that a node publishes."""

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Called with the encoded messages that a subscription receives in the tick that begins."""


class Publisher(TopicEndpoint):
    """A publisher of a node; without a network, it discards messages."""

    latest: Any = None
    """The newest message, if the claim lists transforms; None before the first message and for all other publishers."""

    @property
    def subscribers(self) -> int:
        """Number of matched readers, without recorders."""
        return 0

    @property
    def wanted(self) -> bool:
        """Whether a reader or recorder needs the messages; if not, nodes need not create them."""
        return False

    def publish(self, message: Any) -> None:
        """Send a message to the network and all sinks; it is encoded once."""


class Subscription(TopicEndpoint):
    """A subscription of a node; the messages of a tick are fixed when the tick begins."""

    skipped = 0
    """Number of messages that `newest` skipped since play."""

    def newest(self) -> Any | None:
        """Return the newest message of this tick; None if there is none or it was read before. Older ones count as skipped."""
        return None

    def take(self) -> Sequence[Any]:
        """Return the unread messages of this tick, oldest first."""
        return ()


class ServiceEndpoint:
    """A service server or client of a node."""

    def __init__(self, claim: EndpointClaim) -> None:
        self.claim = claim
        self.service = claim.topic
        """Full name of the service."""
        self.service_type = claim.message_type
        """ROS 2 name, as in `std_srvs/srv/SetBool`."""

    def close(self) -> None:
        """Close the endpoint; the node's context does this. Safe to call twice."""


class ServiceServer(ServiceEndpoint):
    """A service server of a node; the requests of a tick are fixed when the tick begins."""

    def __init__(self, claim: EndpointClaim, handle: int) -> None:
        super().__init__(claim)
        self.handle = handle
        """Handle of the server for `Context.server`; never 0."""
        self.current: bytes | None = None
        """Identity of the request that the graph is handling; None if there is none."""

    def take(self) -> Sequence[tuple[bytes, Any]]:
        """Return id and message of the waiting requests, oldest first, and remove them."""
        return ()

    def answer(self, request_id: bytes, response: Any) -> None:
        """Send a response at the end of the tick; ignored if the request was answered already, or came before a stop."""


class ServiceClient(ServiceEndpoint):
    """A service client of a node; the responses of a tick are fixed when the tick begins."""

    _calls = 0

    def call(self, request: Any) -> int:
        """Send a request at the end of the tick, or as soon as a server exists; return the number of the call, from 1."""
        self._calls += 1
        return self._calls

    def take(self) -> Sequence[tuple[int, Any]]:
        """Return call number and message of the waiting responses, in order of arrival, and remove them."""
        return ()


class Network:
    """Creates the endpoints that nodes claim."""

    @cached_property
    def definitions(self) -> Definitions:
        """Message types."""
        from graphengine.messages.definitions import DEFINITIONS  # heavy, and not needed for `--help`

        return DEFINITIONS

    identity = b""
    """Distinguishes the session on its network; empty if all peers are in the session."""

    sent = 0
    """Number of messages sent since the start."""

    @property
    def subscribers(self) -> int:
        """Number of readers of all topics that nodes publish."""
        return 0

    publishers: Sequence[Publisher] = ()
    """Open publishers."""

    def tap(self, sink: Sink) -> None:
        """Copy all messages that nodes send or receive to a sink; publishers do not count it as a reader."""

    def untap(self, sink: Sink) -> None:
        """Remove a sink that `tap` added."""

    def publisher(self, claim: EndpointClaim) -> Publisher:
        """Create the publisher that a node claims."""
        return Publisher(claim)

    def subscription(self, claim: EndpointClaim) -> Subscription:
        """Create the subscription that a node claims."""
        return Subscription(claim)

    def server(self, claim: EndpointClaim, handle: int) -> ServiceServer:
        """Create the service server that a node claims; `handle` is the number with which nodes refer to it."""
        return ServiceServer(claim, handle)

    def client(self, claim: EndpointClaim) -> ServiceClient:
        """Create the service client that a node claims."""
        return ServiceClient(claim)

    def handing_over(self) -> AbstractContextManager[object]:
        """Return a context in which a claim gets an endpoint that is already open for an equal claim, else a new one."""
        return nullcontext()

    def freeze(self) -> None:
        """Begin a tick: nodes get messages that arrived before it; later messages wait for the next tick."""

    def flush(self) -> None:
        """End a tick: send the messages that were published in it."""

    def save(self) -> Any:
        """Return a copy of the waiting messages and open calls."""

    def restore(self, saved: Any) -> None:
        """Restore the state that `save` returned; messages that were already sent cannot be recalled."""

    def forget_calls(self) -> None:
        """Discard unanswered requests and calls, because graphs restart."""

    def log(self, severity: str, message: str) -> None:
        """Publish a log message, for example on `/rosout`."""

    def close(self) -> None:
        """Leave the network; safe to call twice."""
