"""The contract of a transport: bytes of one CDR message in, bytes out, topics and services by full name.

A package brings a transport by a `TransportKind`, which an entry point of the group `graphengine.transports` names.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.network_graph import PATIENCE, Direction, NetworkGraph

if TYPE_CHECKING:
    from graphengine.messages.definitions import Definitions


def _shipped_definitions() -> Definitions:
    from graphengine.messages.definitions import DEFINITIONS

    return DEFINITIONS


@dataclass(frozen=True, slots=True)
class JoinOptions:
    """The domain to join, and the node to be there.

    Args:
        domain: ROS 2 domain, with its discovery range.
        node_name: as `ros2 node list` shows it.
        node_namespace: absolute; `/` for none.
        environ: variables of the environment, such as RMW_IMPLEMENTATION.
        definitions: message types.
        patient: writers wait for reliable readers that do not keep up, up to 100 ms a message, in place of overwriting what
            they did not get; for runs that have the time. Only dds heeds it.
        because: the reason why this transport was chosen, for its description; empty where the user named it.
    """

    domain: Domain
    node_name: str = "graphengine"
    node_namespace: str = "/"
    environ: Mapping[str, str] = field(default_factory=dict)
    definitions: Definitions = field(default_factory=_shipped_definitions)
    patient: bool = False
    because: str = ""


@dataclass(frozen=True, slots=True)
class TransportKind:
    """A transport as its package describes it. Importing the description should be fast: `open` imports the rest.

    Args:
        name: value of `--transport`, and name of the entry point.
        help: what it connects to, in a few words.
        open: joins a domain; raises TransportError where that fails, and TopicError where ROS 2 refuses the node's name.
        reaches_others: false for one whose messages stay in this process.
        auto: rank among the transports that `--transport auto` tries, the lowest first; None if it must be named.
        missing: returns why the transport cannot be used on this machine, and what to do in further lines; None if it can.
    """

    name: str
    help: str
    open: Callable[[JoinOptions], Transport]
    reaches_others: bool = True
    auto: int | None = None
    missing: Callable[[], str | None] = lambda: None


_POLL = 0.01

Deliver = Callable[[bytes], None]
"""Takes a CDR message."""
DeliverRequest = Callable[[bytes, bytes], None]
"""Takes a request's identity, which `answer` takes, and its CDR message."""
DeliverResponse = Callable[[int, bytes], None]
"""Takes the number of a call, and the CDR message that answers it."""


class Writer(Protocol):
    """One topic to write encoded messages to."""

    @property
    def matched(self) -> int:
        """Current number of readers; a transport that does not count them may return a bool."""

    @property
    def dropped(self) -> int:
        """Messages given up because a reader did not keep up."""

    def write(self, data: bytes) -> None:
        """Send one CDR message, encapsulation header included; never blocks for longer than the reliability's 100 ms.

        An installed ROS 2 may: it goes by its RMW.
        """

    def close(self) -> None:
        """Leave the topic; safe to call twice."""


class Reader(Protocol):
    """One topic that is read; it delivers until it or the transport is closed."""

    def close(self) -> None:
        """Leave the topic; safe to call twice."""


class TransportServer(Protocol):
    """One service that is offered; it delivers requests until it or the transport is closed."""

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Send one CDR message to the client that asked, at any time after its request was delivered.

        Nothing happens where that client is gone, or the request is none of this server's.

        Raises:
            TransportError: the server is closed, or it is no message of the service's type.
        """

    def close(self) -> None:
        """Withdraw the service; safe to call twice."""


class TransportClient(Protocol):
    """One service that is called; answers are delivered until it or the transport is closed."""

    @property
    def ready(self) -> bool:
        """Whether a server is there that hears this client, and is heard; a call without one is lost."""

    def call(self, request: bytes) -> int:
        """Send one CDR message and return at once; the number of the call, from 1 up.

        Each call is answered once at most, and its answer may be delivered before this returns.

        Raises:
            TransportError: the client is closed, or it is no message of the service's type.
        """

    def close(self) -> None:
        """Leave the service; safe to call twice."""


class Transport(Protocol):
    """A way to the network, or to a test. Every writer, reader, server and client is owned, and closed, by it."""

    @property
    def description(self) -> str:
        """One line for people: what carries the messages, on which domain and discovery range."""

    @property
    def spin_time(self) -> float:
        """Seconds within which peers that are there have turned up, as a rule."""

    @property
    def source(self) -> bytes:
        """GID of the writer of the message that is being delivered, for who takes it; empty where it cannot be told."""

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """A writer on a topic such as `/dd100_0000/odom`; `message_type` as in `nav_msgs/msg/Odometry`."""

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> Reader:
        """A reader that calls `deliver` with each CDR message, from a thread of the transport or from its caller's."""

    def server(self, service: str, service_type: str, qos: QoS, deliver: DeliverRequest) -> TransportServer:
        """A server of a service such as `/get_map`; `service_type` as in `nav_msgs/srv/GetMap`.

        Args:
            service: absolute.
            service_type: what is asked and answered.
            qos: of requests and answers alike.
            deliver: called with each request, from a thread of the transport or from a client's.
        """

    def client(self, service: str, service_type: str, qos: QoS, deliver: DeliverResponse) -> TransportClient:
        """A client of a service."""

    @property
    def foreign_services(self) -> Mapping[str, str]:
        """Services of this transport with a peer that it cannot talk to, and what to tell people about each."""

    @property
    def rival_services(self) -> Sequence[str]:
        """Services of this transport that somebody else offers too, as far as `graph` has heard; a call reaches both."""

    @property
    def malformed(self) -> Mapping[str, int]:
        """By topic or service, how many messages were dropped, and not delivered, because they are none of its type."""

    @property
    def node(self) -> str:
        """Full name of the node that this process is on the network; empty where there are no nodes."""

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Who writes and reads which topic, this transport's own endpoints among them; listening begins with the first call.

        Args:
            asked: what is looked for, where that is not everything; there may be more in the answer.

        Raises:
            TransportError: the transport is closed.
        """

    def log(self, severity: str, text: str) -> None:
        """Publish a message on /rosout, where there is a node; severities are info, warning and error."""

    def save(self) -> Any:
        """A copy of what the transport keeps of messages that do not leave the process, for `restore`."""

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned; messages that have left the process are not taken back."""

    def close(self) -> None:
        """Leave the network; safe to call twice."""


def discover(
    transport: Transport,
    seconds: float | None = None,
    enough: Callable[[NetworkGraph], object] = lambda graph: False,
    *,
    names: bool = False,
) -> NetworkGraph:
    """The graph when it is enough, or else after some time.

    Args:
        transport: open.
        seconds: time for peers to turn up; None for the transport's own. Those that did have `PATIENCE` more to tell all.
        enough: ends the wait at once.
        names: whether all includes the names of nodes.
    """
    begun = time.monotonic()
    seconds = transport.spin_time if seconds is None else seconds
    while True:
        graph = transport.graph()
        told = graph.complete and (graph.named or not names)
        if enough(graph) or time.monotonic() - begun >= (seconds if told else seconds + PATIENCE):
            return graph
        time.sleep(_POLL)
