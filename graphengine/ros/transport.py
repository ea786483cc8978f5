"""The interface of a transport: it sends and delivers encoded messages on topics and services with full names.

A package adds a transport with an entry point of the group `graphengine.transports` that refers to a `TransportKind`.
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
    """The domain to join, and the node that represents the session.

    Args:
        domain: ROS 2 domain with its discovery range.
        node_name: name of the node, as in `ros2 node list`.
        node_namespace: absolute namespace; `/` for none.
        environ: environment variables, such as RMW_IMPLEMENTATION.
        definitions: message types.
        patient: writers wait for slow reliable readers, up to 100 ms per message, instead of overwriting unread messages; for
            runs that are not in real time. Only the transport `dds` supports it.
        because: why this transport was chosen, for its description; empty if the user chose it.
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
    """Describes a transport. Importing the description should be fast: `open` imports the implementation.

    Args:
        name: value of `--transport`, and name of the entry point.
        help: what the transport connects to, in a few words.
        open: joins a domain; raises TransportError if this fails, and TopicError if the node's name is not legal.
        reaches_others: false if messages stay in this process.
        auto: rank among the transports that `--transport auto` tries, lowest first; None if it must be chosen by name.
        missing: returns why the transport cannot be used on this machine, with remedies in further lines; None if it can.
    """

    name: str
    help: str
    open: Callable[[JoinOptions], Transport]
    reaches_others: bool = True
    auto: int | None = None
    missing: Callable[[], str | None] = lambda: None


_POLL = 0.01

Deliver = Callable[[bytes], None]
"""Callback for a received CDR message."""
DeliverRequest = Callable[[bytes, bytes], None]
"""Callback for a request: its identity, to be passed to `TransportServer.answer`, and its CDR message."""
DeliverResponse = Callable[[int, bytes], None]
"""Callback for a response: the number of the call, and the CDR message."""


class Writer(Protocol):
    """Writes encoded messages to a topic."""

    @property
    def matched(self) -> int:
        """Current number of readers; a transport that does not count them may return a bool."""

    @property
    def dropped(self) -> int:
        """Number of messages dropped because a reader was too slow."""

    def write(self, data: bytes) -> None:
        """Send a CDR message including its encapsulation header; blocks for at most 100 ms.

        With an installed ROS 2, its RMW determines how long this may block.
        """

    def close(self) -> None:
        """Close the writer; safe to call twice."""


class Reader(Protocol):
    """Delivers the messages of a topic until the reader or the transport is closed."""

    def close(self) -> None:
        """Close the reader; safe to call twice."""


class TransportServer(Protocol):
    """Delivers the requests of a service until the server or the transport is closed."""

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Send a CDR message as response; possible at any time after the request was delivered.

        Does nothing if the client is gone, or if the request was not delivered by this server.

        Raises:
            TransportError: the server is closed, or the bytes are not a message of the service's type.
        """

    def close(self) -> None:
        """Close the server; safe to call twice."""


class TransportClient(Protocol):
    """Calls a service; delivers responses until the client or the transport is closed."""

    @property
    def ready(self) -> bool:
        """Whether a compatible server exists; a call without one is lost."""

    def call(self, request: bytes) -> int:
        """Send a CDR message as request and return at once; return the number of the call, from 1.

        Each call gets at most one response, which may be delivered before this method returns.

        Raises:
            TransportError: the client is closed, or the bytes are not a message of the service's type.
        """

    def close(self) -> None:
        """Close the client; safe to call twice."""


class Transport(Protocol):
    """A connection to a network. It owns its writers, readers, servers and clients, and closes them."""

    @property
    def description(self) -> str:
        """The implementation, domain and discovery range, in one line for users."""

    @property
    def spin_time(self) -> float:
        """Typical time for the discovery of existing peers, s."""

    @property
    def identity(self) -> bytes:
        """Random bytes that distinguish this process on the network; empty if messages stay in the process."""

    @property
    def source(self) -> bytes:
        """GID of the writer of the message that is being delivered, for use in `deliver`; empty if unknown."""

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """Open a writer on a topic such as `/dd100_0000/odom`; `message_type` as in `nav_msgs/msg/Odometry`."""

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> Reader:
        """Open a reader that calls `deliver` with each CDR message, in a thread of the transport or in the caller's."""

    def server(
        self, service: str, service_type: str, qos: QoS, deliver: DeliverRequest, node: str = ""
    ) -> TransportServer:
        """Open a server of a service such as `/get_map`; `service_type` as in `nav_msgs/srv/GetMap`.

        Args:
            service: absolute name.
            service_type: type of the service.
            qos: profile of requests and responses.
            deliver: called with each request, in a thread of the transport or of a client.
            node: full name of the node that offers the service, such as `/dd100_0000/dd100`; empty: `Transport.node`. Any
                other node exists on the network while it has servers. Transports without nodes ignore this argument.
        """

    def client(self, service: str, service_type: str, qos: QoS, deliver: DeliverResponse) -> TransportClient:
        """Open a client of a service; `deliver` is called with each response."""

    @property
    def foreign_services(self) -> Mapping[str, str]:
        """Warnings about incompatible peers, by the name of the service."""

    @property
    def rival_services(self) -> Sequence[str]:
        """Services of this transport that another program offers too, as known from `graph`; both receive each call."""

    @property
    def malformed(self) -> Mapping[str, int]:
        """Number of messages by topic or service that were dropped because they do not fit its type."""

    @property
    def node(self) -> str:
        """Full name of this process's node on the network; empty if the transport has no nodes. Servers can be on other nodes."""

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Return all known endpoints, including this transport's; discovery begins with the first call.

        Args:
            asked: topics and directions to look up, None for all; the result may contain others.

        Raises:
            TransportError: the transport is closed.
        """

    def log(self, severity: str, text: str) -> None:
        """Publish a message on /rosout, if there is a node; severities are info, warning and error."""

    def save(self) -> Any:
        """Return a copy of the messages and calls that the transport keeps within this process."""

    def restore(self, saved: Any) -> None:
        """Restore the state that `save` returned; messages that were already sent cannot be recalled."""

    def close(self) -> None:
        """Leave the network; safe to call twice."""


def discover(
    transport: Transport,
    seconds: float | None = None,
    enough: Callable[[NetworkGraph], object] = lambda graph: False,
    *,
    names: bool = False,
) -> NetworkGraph:
    """Return the graph as soon as `enough` accepts it, at the latest after the discovery time.

    Args:
        transport: open transport.
        seconds: time for the discovery of peers, s; None: `Transport.spin_time`. Discovered peers get `PATIENCE` s more to
            announce their endpoints.
        enough: called with the graph; the wait ends when it returns true.
        names: whether to wait for the names of nodes too.
    """
    begun = time.monotonic()
    seconds = transport.spin_time if seconds is None else seconds
    while True:
        graph = transport.graph()
        told = graph.complete and (graph.named or not names)
        if enough(graph) or time.monotonic() - begun >= (seconds if told else seconds + PATIENCE):
            return graph
        time.sleep(_POLL)
