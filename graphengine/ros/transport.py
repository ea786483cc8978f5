"""The interface of a transport: it sends and delivers encoded messages on topics and services, whose names are absolute.

A package adds a transport with an entry point of the group `graphengine.transports` that refers to a `TransportKind`.
"""

from __future__ import annotations

import re
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
        patient: whether writers wait for slow reliable readers, up to 100 ms per message, instead of overwriting unread
            messages; for runs that are not in real time. Only endpoints on embedded DDS support this option.
        because: reason why `--transport auto` chose this transport, for its description; empty if the user chose it.
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
        open: joins a domain and returns the transport; raises TransportError if joining fails, and TopicError if the name of
            the node is not legal.
        reaches_others: whether messages can leave this process.
        auto: rank among the transports that `--transport auto` tries, lowest first; None: a user must choose it by name.
        missing: returns the reason why the transport cannot be used on this machine, followed by remedies on further lines;
            None if it can be used.
        not_for_auto: returns the reason why `auto` leaves out a transport that can be used; None if it does not.
    """

    name: str
    help: str
    open: Callable[[JoinOptions], Transport]
    reaches_others: bool = True
    auto: int | None = None
    missing: Callable[[], str | None] = lambda: None
    not_for_auto: Callable[[], str | None] = lambda: None


_POLL = 0.01

Deliver = Callable[[bytes], None]
"""Callback for a received message; its argument is the CDR message."""
DeliverRequest = Callable[[bytes, bytes], None]
"""Callback for a request; its arguments are the identity to pass to `TransportServer.answer`, and the CDR message."""
DeliverResponse = Callable[[int, bytes], None]
"""Callback for a response; its arguments are the number of the call, and the CDR message."""


class Writer(Protocol):
    """Writes encoded messages to a topic."""

    @property
    def matched(self) -> int:
        """Current number of matched readers; a transport that cannot count readers may return a bool."""

    @property
    def dropped(self) -> int:
        """Number of messages dropped because a reader was too slow."""

    def write(self, data: bytes) -> None:
        """Send a CDR message including its encapsulation header; blocks for at most 100 ms.

        The transport over an installed ROS 2 is an exception: its RMW determines how long the call may block.
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
        """Send a CDR message as the response to a request, at any time after the request was delivered.

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
        """Whether a compatible server exists; without a server, a call is lost."""

    def call(self, request: bytes) -> int:
        """Send a CDR message as a request, without waiting for the response; return the number of the call, starting at 1.

        Each call gets at most one response, which may be delivered before this method returns.

        Raises:
            TransportError: the client is closed, or the bytes are not a message of the service's type.
        """

    def close(self) -> None:
        """Close the client; safe to call twice."""


class Transport(Protocol):
    """A connection to a network. It owns its writers, readers, servers and clients, and `close` closes them too."""

    @property
    def description(self) -> str:
        """One line for users: the implementation, domain and discovery range."""

    @property
    def notices(self) -> Sequence[str]:
        """Lines for users about what this transport cannot do for the endpoints that are open now."""

    @property
    def spin_time(self) -> float:
        """Typical time that the discovery of existing peers takes, s."""

    @property
    def identity(self) -> bytes:
        """Random bytes that distinguish this process on the network; empty if messages stay in the process."""

    @property
    def source(self) -> bytes:
        """GID of the writer whose message is being delivered, empty if unknown; valid only within `deliver`."""

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """Create a writer on a topic such as `/dd100_0000/odom`; a `message_type` is, for example, `nav_msgs/msg/Odometry`."""

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> Reader:
        """Create a reader; it calls `deliver` with each CDR message, in a thread of the transport or in the writer's thread."""

    def server(
        self, service: str, service_type: str, qos: QoS, deliver: DeliverRequest, node: str = ""
    ) -> TransportServer:
        """Create a server of a service such as `/get_map`; a `service_type` is, for example, `nav_msgs/srv/GetMap`.

        Args:
            service: absolute name.
            service_type: type of the service.
            qos: profile of requests and responses.
            deliver: called with each request, in a thread of the transport or of a client.
            node: full name of the node that offers the service, such as `/dd100_0000/dd100`; empty for `Transport.node`.
                Any other node exists on the network while it has servers. Transports without nodes ignore this argument.
        """

    def client(self, service: str, service_type: str, qos: QoS, deliver: DeliverResponse) -> TransportClient:
        """Create a client of a service; `deliver` is called with each response."""

    @property
    def foreign_services(self) -> Mapping[str, str]:
        """Warnings about incompatible peers of services, by name of the service."""

    @property
    def rival_services(self) -> Sequence[str]:
        """Services of this transport that another program also offers, as of the last `graph`; both servers get each call."""

    @property
    def malformed(self) -> Mapping[str, int]:
        """Number of messages dropped because they do not fit the type of their topic or service, by topic or service name."""

    @property
    def node(self) -> str:
        """Full name of this process's node; empty if the transport has no nodes. A server may belong to another node."""

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Return all known endpoints, including this transport's; discovery begins with the first call.

        Args:
            asked: topics and directions to look up; None for all. The result may contain other endpoints too.

        Raises:
            TransportError: the transport is closed.
        """

    def log(self, severity: str, text: str) -> None:
        """Publish a message on /rosout if the transport has a node; `severity` is info, warning or error."""

    def save(self) -> Any:
        """Return a copy of the messages and calls that the transport keeps in this process, for `restore`."""

    def restore(self, saved: Any) -> None:
        """Restore the state that `save` returned; messages that were already sent cannot be recalled."""

    def close(self) -> None:
        """Close all endpoints and leave the network; safe to call twice."""


def discover(
    transport: Transport,
    seconds: float | None = None,
    enough: Callable[[NetworkGraph], object] = lambda graph: False,
    *,
    names: bool = False,
) -> NetworkGraph:
    """Return the ROS graph as soon as `enough` accepts it, at the latest after the discovery time.

    Args:
        transport: open transport.
        seconds: time for the discovery of peers, s; None for `Transport.spin_time`. Discovered peers get `PATIENCE` s more
            to announce their endpoints.
        enough: called with the graph again and again; a true result ends the wait.
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


def brief(description: str) -> str:
    """Return the transport and the domain of a transport's description in two words, such as `embedded DDS, domain 72`."""
    name, *further = description.partition(";")[0].split(", ")
    kind = re.split(r"[ :]", name)[0]
    return ", ".join(["embedded DDS" if kind == "dds" else kind, *further[:1]])
