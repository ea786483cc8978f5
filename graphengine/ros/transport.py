"""The interface of a transport, which sends and delivers encoded messages on topics and services with absolute names.

A package adds a transport with an entry point of the group `graphengine.transports`; the entry point names a `TransportKind`.
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
        because: reason why `--transport auto` chose this transport, for the description; empty if the user chose the transport.
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
    """Describes a transport. The import of a description should be fast: `open` imports the implementation.

    Args:
        name: value of `--transport`, and name of the entry point.
        help: programs to which the transport connects, in a few words.
        open: joins a domain and returns the transport; raises TransportError if joining fails, and TopicError if the name of
            the node is not legal.
        reaches_others: whether messages can leave this process.
        auto: rank of the transport for `--transport auto`, which tries the lowest rank first; None: a user must name the
            transport.
        missing: returns the reason why the transport cannot be used on this machine, followed by remedies on further lines;
            None if it can be used.
        not_for_auto: returns the reason why `auto` leaves out a usable transport; None if `auto` does not leave it out.
    """

    name: str
    help: str
    open: Callable[[JoinOptions], Transport]
    reaches_others: bool = True
    auto: int | None = None
    missing: Callable[[], str | None] = lambda: None
    not_for_auto: Callable[[], str | None] = lambda: None


_POLL = 0.01

Complain = Callable[[str], None]
"""Callback for a warning to users, for example about a peer that sends malformed messages; its argument is the text."""
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
        """Current number of matched readers; a transport that cannot count readers may return whether there is one."""

    @property
    def dropped(self) -> int:
        """Number of messages dropped because a reader was too slow."""

    def write(self, data: bytes) -> None:
        """Send a CDR message that includes the encapsulation header; blocks for at most 100 ms.

        On an installed ROS 2, the RMW determines how long the call may block.
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
        """Send a CDR message as the response to a request that this server has delivered, at any later time.

        Does nothing if the client is gone, or if this server has not delivered the request.

        Raises:
            TransportError: the server is closed, or the bytes are not a message of the service's type.
        """

    def close(self) -> None:
        """Close the server; safe to call twice."""


class TransportClient(Protocol):
    """Calls a service, and delivers responses until the client or the transport is closed."""

    @property
    def ready(self) -> bool:
        """Whether a compatible server exists; without one, a call is lost."""

    def call(self, request: bytes) -> int:
        """Send a CDR message as a request, without waiting for the response; return the number of the call, starting at 1.

        Each call gets at most one response, which may be delivered before this method returns.

        Raises:
            TransportError: the client is closed, or the bytes are not a message of the service's type.
        """

    def close(self) -> None:
        """Close the client; safe to call twice."""


class Transport(Protocol):
    """A connection to a network. The transport owns its writers, readers, servers and clients; `close` closes them too."""

    @property
    def description(self) -> str:
        """One line for users with implementation, domain and discovery range."""

    @property
    def notices(self) -> Sequence[str]:
        """Lines for users about limitations of this transport that affect the open endpoints."""

    @property
    def spin_time(self) -> float:
        """Typical time that the discovery of existing peers takes, s."""

    @property
    def identity(self) -> bytes:
        """Random bytes that distinguish this process on the network; empty if messages stay in the process."""

    @property
    def source(self) -> bytes:
        """GID of the writer whose message is being delivered; empty if unknown. Valid only within `deliver`."""

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """Create a writer on a topic such as `/dd100_0000/odom`; a `message_type` is, for example, `nav_msgs/msg/Odometry`."""

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> Reader:
        """Create a reader that calls `deliver` with each CDR message, in a thread of the transport or of the writer."""

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
                Any other node exists on the network while it has servers. A transport without nodes ignores this argument.
        """

    def client(self, service: str, service_type: str, qos: QoS, deliver: DeliverResponse) -> TransportClient:
        """Create a client of a service; `deliver` is called with each response."""

    @property
    def foreign_services(self) -> Mapping[str, str]:
        """A warning for each service with incompatible peers, by the service's name."""

    @property
    def rival_services(self) -> Sequence[str]:
        """Services of this transport that another program also offers, as of the last `graph`; both servers get each call."""

    @property
    def malformed(self) -> Mapping[str, int]:
        """Number of malformed messages dropped on each topic or service, by name: they do not fit the message type."""

    @property
    def node(self) -> str:
        """Full name of this process's node; empty if the transport has no nodes. Servers may belong to other nodes."""

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Return all known endpoints, including this transport's; discovery begins with the first call.

        Args:
            asked: topics and directions to look up; None for all. The result may also contain endpoints that were not asked for.

        Raises:
            TransportError: the transport is closed.
        """

    def log(self, severity: str, text: str) -> None:
        """Publish a message on /rosout if the transport has a node; `severity` is info, warning or error."""

    def save(self) -> Any:
        """Return a copy of the messages and calls that the transport keeps in this process; `restore` takes the copy."""

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
    """Return the ROS graph as soon as `enough` accepts the graph, at the latest after the discovery time.

    Args:
        transport: open transport.
        seconds: time for the discovery of peers, s; None for `Transport.spin_time`. Discovered peers get another `PATIENCE` s
            to announce their endpoints.
        enough: called repeatedly with the current graph; a true result ends the wait.
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
    """Return a short form of a transport's description: transport and domain, such as `embedded DDS, domain 72`."""
    name, *further = description.partition(";")[0].split(", ")
    kind = re.split(r"[ :]", name)[0]
    return ", ".join(["embedded DDS" if kind == "dds" else kind, *further[:1]])
