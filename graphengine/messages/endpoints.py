"""Interface between nodes and the network: publishers, subscriptions, service servers and clients, and their QoS.

The classes of this module work without a network, which is enough for checks; the classes for a live network are subclasses.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol

from graphengine.format.faults import Faults

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions


@dataclass(frozen=True, slots=True)
class QoS:
    """QoS of an endpoint. Values have the names that OmniGraph's QoS profiles use; times are in seconds, 0 for unlimited."""

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
    """Description of an endpoint that a node requests in `setup`; used by the network, by checks and by `graphrun topics`."""

    node: str
    """Prim path of the node."""
    graph: str
    topic: str
    """Full name of the topic, or of the service."""
    message_type: str
    """ROS 2 name of the message type, or of the service type."""
    direction: str
    """`publish` or `subscribe`; `serve` or `call` for a service."""
    qos: QoS
    ros_context: int = 0
    rate: float | None = None
    """Publishing rate, Hz; None if messages are published on events."""
    latched: bool = False
    frame_id: str = ""
    """Published name of the frame in the message headers."""
    child_frame_id: str = ""
    """Published name of the child frame in the messages, for example in odometry."""
    transforms: tuple[tuple[str, str], ...] = ()
    """Names of the parent and the child frame of each transform, as published."""
    alternatives: tuple[str, ...] = ()
    """Message types that a subscription uses instead of `message_type` if peers publish one of them."""

    @property
    def is_service(self) -> bool:
        """Whether the endpoint belongs to a service, not to a topic; a topic may have the same name as a service."""
        return self.direction in ("serve", "call")


class TopicEndpoint:
    """A publisher or subscription of a node."""

    def __init__(self, claim: EndpointClaim) -> None:
        self.claim = claim
        self.topic = claim.topic
        """Full topic name."""

    def close(self) -> None:
        """Destroy the endpoint, as the node's context does; a second call has no effect."""


class Sink(Protocol):
    """The Protocol of a receiver of copies of all encoded messages, such as a recorder."""

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Process an encoded message that a node has published."""

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Process the encoded messages that a subscription gets in the tick that now begins."""


class Publisher(TopicEndpoint):
    """A publisher of a node; this base class has no network and discards messages."""

    latest: Any = None
    """The newest message, if the claim lists transforms; None before the first message, and always None without transforms."""

    @property
    def subscribers(self) -> int:
        """Number of matched subscriptions; sinks such as recorders do not count."""
        return 0

    @property
    def wanted(self) -> bool:
        """Whether there is a subscription or a sink; if not, the node need not build messages."""
        return False

    def publish(self, message: Any) -> None:
        """Encode a message, and send it to the network and all sinks."""


class Subscription(TopicEndpoint):
    """A subscription of a node; in a tick, the node gets the messages that arrived before the tick began."""

    skipped = 0
    """Number of messages since play that `newest` skipped, because a newer message had arrived in the same tick."""

    def newest(self) -> Any | None:
        """Return the newest message of this tick and skip the others; None if no message arrived or it was read before."""
        return None

    def take(self) -> Sequence[Any]:
        """Return the messages of this tick that were not read before, oldest first."""
        return ()


@dataclass(frozen=True, slots=True)
class Supply:
    """What reaches a subscription.

    Attributes:
        publishers: names of the nodes that publish the topic.
        misfits: reasons why messages of publishers do not arrive, each with a remedy in a second line.
        strays: topics with the same last name that other nodes publish and no node reads.
        messages: number of received messages since the session started.
        silence: number of ticks since the last message arrived; None before the first one.
    """

    publishers: Sequence[str] = ()
    misfits: Sequence[str] = ()
    strays: Sequence[str] = ()
    messages: int = 0
    silence: int | None = None


class ServiceEndpoint:
    """A service server or client of a node."""

    def __init__(self, claim: EndpointClaim) -> None:
        self.claim = claim
        self.service = claim.topic
        """Full name of the service."""
        self.service_type = claim.message_type
        """ROS 2 name of the service type, such as `std_srvs/srv/SetBool`."""

    def close(self) -> None:
        """Destroy the endpoint, as the node's context does; a second call has no effect."""


class ServiceServer(ServiceEndpoint):
    """A service server of a node; in a tick, the node gets the requests that arrived before the tick began."""

    def __init__(self, claim: EndpointClaim, handle: int) -> None:
        super().__init__(claim)
        self.handle = handle
        """Handle of the server for `Context.server`; never 0."""
        self.current: bytes | None = None
        """ID of the request to which the graph still has to respond, or None."""

    def take(self) -> Sequence[tuple[bytes, Any]]:
        """Remove the waiting requests, and return the ID and the message of each, oldest first."""
        return ()

    def answer(self, request_id: bytes, response: Any) -> None:
        """Send the response to a request at the end of the tick.

        The response is ignored if the request was answered already, or arrived before a stop.
        """


class ServiceClient(ServiceEndpoint):
    """A service client of a node; in a tick, the node gets the responses that arrived before the tick began."""

    _calls = 0

    def call(self, request: Any) -> int:
        """Send a request at the end of the tick, or later when a server appears; return the number of the call, from 1."""
        self._calls += 1
        return self._calls

    def take(self) -> Sequence[tuple[int, Any]]:
        """Remove the waiting responses, and return the call number and the message of each, in order of arrival."""
        return ()


class Network:
    """Creates the endpoints that nodes request; this base class has no connection to other programs."""

    @cached_property
    def definitions(self) -> Definitions:
        """Definitions of all message types that the session knows."""
        from graphengine.messages.definitions import DEFINITIONS  # heavy, and not needed for `--help`

        return DEFINITIONS

    @cached_property
    def faults(self) -> Faults:
        """Faults of topics. They act on messages that graphs publish; if no graph publishes the topic, on received messages."""
        return Faults()

    identity = b""
    """Bytes that identify this session on the network; empty if all peers are in this session."""

    sent = 0
    """Number of messages sent since the network was created."""

    @property
    def subscribers(self) -> int:
        """Total number of matched subscriptions of all publishers."""
        return 0

    publishers: Sequence[Publisher] = ()
    """All publishers that were created and not destroyed."""

    def tap(self, sink: Sink) -> None:
        """Copy all messages that nodes send or receive to a sink from now on. A sink does not count as a subscription."""

    def untap(self, sink: Sink) -> None:
        """Remove a sink that `tap` added."""

    def publisher(self, claim: EndpointClaim) -> Publisher:
        """Create the publisher that a claim describes."""
        return Publisher(claim)

    def subscription(self, claim: EndpointClaim) -> Subscription:
        """Create the subscription that a claim describes."""
        return Subscription(claim)

    def server(self, claim: EndpointClaim, handle: int) -> ServiceServer:
        """Create the service server that a claim describes; nodes refer to the server by the number `handle`."""
        return ServiceServer(claim, handle)

    def client(self, claim: EndpointClaim) -> ServiceClient:
        """Create the service client that a claim describes."""
        return ServiceClient(claim)

    def supply(self, claim: EndpointClaim) -> Supply:
        """Return what reaches the subscription that a claim describes."""
        return Supply()

    def handing_over(self) -> AbstractContextManager[object]:
        """Return a context manager for replacing a graph.

        Within its block, a claim gets the existing endpoint of an equal claim; without an equal claim, it gets a new endpoint.
        """
        return nullcontext()

    def freeze(self) -> None:
        """Begin a tick: nodes get the messages that arrived before this call; later messages wait for the next tick."""

    def flush(self) -> None:
        """End a tick: send the messages that nodes published in this tick."""

    def save(self) -> Any:
        """Return a copy of the waiting messages and unanswered calls, for `restore`."""

    def restore(self, saved: Any) -> None:
        """Restore the state that `save` returned; messages that were already sent cannot be recalled."""

    def forget_calls(self) -> None:
        """Discard unanswered requests and calls, and end faults; called when graphs restart."""

    def log(self, severity: str, message: str) -> None:
        """Publish a log message, for example on `/rosout`."""

    def close(self) -> None:
        """Disconnect from the network; a second call has no effect."""
