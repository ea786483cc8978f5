"""What nodes see of the network: topics and services, and their quality of service.

The classes here work without peers, as a check needs them; those of a live network derive from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Any, Literal, Protocol


@dataclass(frozen=True, slots=True)
class QoS:
    """Quality of service of an endpoint, in the words of OmniGraph's QoS profiles; times in seconds, 0 for unlimited."""

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
    """An endpoint that a node asked for: what the checks and `graphrun topics` know of the ROS 2 side."""

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
    """Messages a second; None when an event decides."""
    latched: bool = False
    frame_id: str = ""
    transforms: tuple[tuple[str, str], ...] = ()
    alternatives: tuple[str, ...] = ()
    """Other message types that a subscription takes, should these be what others publish."""

    @property
    def is_service(self) -> bool:
        """Whether it is a service; a topic may have the same name."""
        return self.direction in ("serve", "call")


class TopicEndpoint:
    """One end of a topic."""

    def __init__(self, claim: EndpointClaim) -> None:
        self.claim = claim
        self.topic = claim.topic
        """Full topic name."""

    def close(self) -> None:
        """Leave the topic; the context of the node does so. Safe to call twice."""


class Sink(Protocol):
    """Takes encoded messages, such as a recorder."""

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Take one encoded message that a node published."""

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Take what a subscription sees from this tick on."""


class Publisher(TopicEndpoint):
    """One topic to write to."""

    @property
    def subscribers(self) -> int:
        """Number of readers, recorders excluded."""
        return 0

    @property
    def wanted(self) -> bool:
        """Whether somebody listens or records; a message that nobody wants need not be built."""
        return False

    def publish(self, message: Any) -> None:
        """Send a message of `graphengine.messages.messages` to every sink; encoded once."""


class Subscription(TopicEndpoint):
    """One topic to read from; deliveries are frozen at the start of each tick."""

    skipped = 0
    """How many messages were passed over by `newest` since play."""

    def newest(self) -> Any | None:
        """The newest message delivered in this tick, once; None when there is none. Older ones count as skipped."""
        return None

    def take(self) -> Sequence[Any]:
        """All messages delivered in this tick, oldest first, once."""
        return ()


class ServiceEndpoint:
    """One end of a service."""

    def __init__(self, claim: EndpointClaim) -> None:
        self.claim = claim
        self.service = claim.topic
        """Full name of the service."""
        self.service_type = claim.message_type
        """ROS 2 name, as in `std_srvs/srv/SetBool`."""

    def close(self) -> None:
        """Leave the service; the context of the node does so. Safe to call twice."""


class ServiceServer(ServiceEndpoint):
    """One service that is offered; requests are frozen at the start of each tick."""

    def __init__(self, claim: EndpointClaim, handle: int) -> None:
        super().__init__(claim)
        self.handle = handle
        """Number by which `Context.server` finds it; never 0."""
        self.current: bytes | None = None
        """Identity of the request that the graph is about to answer; None where there is none."""

    def take(self) -> Sequence[tuple[bytes, Any]]:
        """Requests that came before this tick and were not taken, oldest first: their identities and messages."""
        return ()

    def answer(self, request_id: bytes, response: Any) -> None:
        """Answer a request when the tick ends; one that was answered, or came before a stop, is not."""


class ServiceClient(ServiceEndpoint):
    """A client of a service; a tick sees the responses that arrived before it."""

    _calls = 0

    def call(self, request: Any) -> int:
        """Ask when the tick ends, or as soon as a server is there; the number of the call, from 1 up."""
        self._calls += 1
        return self._calls

    def take(self) -> Sequence[tuple[int, Any]]:
        """Answers that came before this tick and were not taken, in order: numbers of their calls, and messages."""
        return ()


class Network:
    """Endpoints for the topics and services that nodes claim."""

    sent = 0
    """Messages sent since the start."""

    @property
    def subscribers(self) -> int:
        """Number of readers of all topics that nodes publish."""
        return 0

    publishers: Sequence[Publisher] = ()
    """Open publishers."""

    def tap(self, sink: Sink) -> None:
        """Let a sink take what is sent and delivered anyway: no message is built for it."""

    def untap(self, sink: Sink) -> None:
        """End `tap`."""

    def publisher(self, claim: EndpointClaim) -> Publisher:
        """An endpoint to write to."""
        return Publisher(claim)

    def subscription(self, claim: EndpointClaim) -> Subscription:
        """An endpoint to read from."""
        return Subscription(claim)

    def server(self, claim: EndpointClaim, handle: int) -> ServiceServer:
        """An endpoint that answers, known to nodes by a number."""
        return ServiceServer(claim, handle)

    def client(self, claim: EndpointClaim) -> ServiceClient:
        """An endpoint that asks."""
        return ServiceClient(claim)

    def handing_over(self) -> AbstractContextManager[object]:
        """Until its end, a node that asks for an endpoint gets the open one of an equal claim, if there is one."""
        return nullcontext()

    def freeze(self) -> None:
        """Begin a tick: subscriptions deliver what arrived before it; what arrives later is delivered in the next tick."""

    def flush(self) -> None:
        """End a tick: what was published in it leaves now."""

    def save(self) -> Any:
        """A copy of what has arrived and was not taken, and of open calls."""

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned, as far as messages have not left this process."""

    def forget_calls(self) -> None:
        """Graphs begin anew: requests that nobody answered will not be, answers that have not come are not waited for."""

    def log(self, severity: str, message: str) -> None:
        """Pass a message for people on to the network."""

    def close(self) -> None:
        """Leave the network; safe to call twice."""
