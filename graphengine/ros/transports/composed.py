"""Composes two transports: an endpoint whose type the first transport lacks is opened on embedded DDS."""

from __future__ import annotations

import contextlib
import threading
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.format.wording import listing
from graphengine.messages.endpoints import QoS
from graphengine.messages.names import action_of
from graphengine.ros.network_graph import Direction, NetworkGraph, NetworkNode
from graphengine.ros.transport import (
    Deliver,
    DeliverRequest,
    DeliverResponse,
    Reader,
    Transport,
    TransportClient,
    TransportServer,
    Writer,
)
from graphengine.ros.transports.vendors import CYCLONE, CYCLONE_RMW


class ComposedTransport:
    """One node on the network whose endpoints are on two transports; the type of an endpoint determines its transport.

    The second transport is opened for the first endpoint that needs it. Messages on one topic arrive in order; between topics on
    different transports, the order is undefined. ROS 2 programs on any DDS implementation can use all topics, but a service or
    action works only with programs on the DDS implementation of its transport.

    Args:
        first: transport that announces the node and publishes the node's log.
        has: returns whether the first transport has a message or service type.
        open_second: joins the same domain with embedded DDS, without announcing the node.
    """

    def __init__(self, first: Transport, has: Callable[[str], bool], open_second: Callable[[], Transport]) -> None:
        self._first = first
        self.identity, self.node, self.log = first.identity, first.node, first.log
        self._second: Transport | None = None
        self._has = has
        self._open_second = open_second
        self._lock = threading.Lock()
        self._closed = False
        self._actions: dict[str, Transport] = {}
        """Transport of each action; the parts of the action with types that all actions share are on this transport too."""
        self._lacking: dict[str, None] = {}
        """Packages of the types that the first transport lacks, in order of use."""
        self._apart: dict[str, None] = {}
        """Services and actions that were opened on the second transport, in order of use."""
        self._delivering = threading.local()
        """Its attribute `transport` is the transport that delivers a message in the current thread."""

    # Endpoints

    def writer(self, topic: str, message_type: str, qos: QoS) -> Writer:
        """Create a writer on a topic, on the transport of its type."""
        return self._transport(topic, message_type).writer(topic, message_type, qos)

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> Reader:
        """Create a reader on a topic, on the transport of its type."""
        transport = self._transport(topic, message_type)

        def take(data: bytes) -> None:
            self._delivering.transport = transport
            deliver(data)

        return transport.reader(topic, message_type, qos, take)

    def server(
        self, service: str, service_type: str, qos: QoS, deliver: DeliverRequest, node: str = ""
    ) -> TransportServer:
        """Create a server of a service, on the transport of its type."""
        return self._services(service, service_type).server(service, service_type, qos, deliver, node)

    def client(self, service: str, service_type: str, qos: QoS, deliver: DeliverResponse) -> TransportClient:
        """Create a client of a service, on the transport of its type."""
        return self._services(service, service_type).client(service, service_type, qos, deliver)

    def _services(self, service: str, service_type: str) -> Transport:
        transport = self._transport(service, service_type)
        if transport is not self._first:
            self._apart[action_of(service) or service] = None
        return transport

    def _transport(self, name: str, kind: str) -> Transport:
        """Return the transport of a topic or service with this name and type; open the second transport if necessary."""
        action = action_of(name)
        if action in self._actions and kind.startswith("action_msgs/"):
            return self._actions[action]
        if self._has(kind):
            transport = self._first
        else:
            transport = self._opened_second()
            self._lacking[kind.partition("/")[0]] = None
        if action:
            self._actions[action] = transport
        return transport

    def _opened_second(self) -> Transport:
        with self._lock:
            if self._second is None and not self._closed:
                self._second = self._open_second()
            # After `close`, either transport raises the error of a closed transport.
            return self._second or self._first

    @property
    def _opened(self) -> list[Transport]:
        return [self._first] if self._second is None else [self._first, self._second]

    # The network

    @property
    def description(self) -> str:
        """Description of the first transport, and of the second transport if an endpoint uses it."""
        if self._second is None or not self._lacking:
            return self._first.description
        second = self._second.description.partition(",")[0]
        return f"{self._first.description}; types of {', '.join(self._lacking)} on {second}"

    @property
    def notices(self) -> Sequence[str]:
        """Notices of the first transport, and a line with the services and actions on the second transport."""
        if not (apart := list(self._apart)):
            return self._first.notices
        return [*self._first.notices, listing(apart, f"only nodes on {CYCLONE_RMW} can use the services and actions")]

    @property
    def spin_time(self) -> float:
        """Typical time that the discovery of existing peers takes on the slower transport, s."""
        return max(transport.spin_time for transport in self._opened)

    @property
    def source(self) -> bytes:
        """GID of the writer whose message is being delivered in this thread; empty if unknown."""
        return getattr(self._delivering, "transport", self._first).source

    @property
    def foreign_services(self) -> Mapping[str, str]:
        """A warning for each service with incompatible peers, by the service's name, of both transports."""
        return {name: text for transport in self._opened for name, text in transport.foreign_services.items()}

    @property
    def rival_services(self) -> Sequence[str]:
        """Services that another program also offers, as of the last `graph`."""
        return [service for transport in self._opened for service in transport.rival_services]

    @property
    def malformed(self) -> Mapping[str, int]:
        """Number of malformed messages dropped on each topic or service of both transports."""
        return sum((Counter(transport.malformed) for transport in self._opened), Counter[str]())

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Return the graph of the first transport; an open second transport replaces all endpoints on Cyclone DDS.

        Fast DDS does not notice when a running process closes an endpoint on Cyclone DDS. Only embedded DDS knows the nodes of
        endpoints that other composed transports have on Cyclone DDS; so such an endpoint opens the second transport too.

        Raises:
            TransportError: the transport is closed.
        """
        graph = self._first.graph(asked)
        if graph.named and any(end.gid.startswith(CYCLONE) and not end.node for end in graph.endpoints):
            with contextlib.suppress(TransportError):  # they stay without a node
                self._opened_second()
        if self._second is None:
            return graph
        other = self._second.graph(asked)
        ends = [end for end in graph.endpoints if not end.gid.startswith(CYCLONE)]
        ends += [
            end
            for end in other.endpoints
            if end.gid.startswith(CYCLONE) and (asked is None or (end.topic, end.direction) in asked)
        ]
        # For a node that both transports know, each may know services that the other one does not know.
        named = {node.name: node for node in graph.nodes}
        nodes = [
            NetworkNode(node.name, [*node.servers, *same.servers], [*node.clients, *same.clients])
            for node, same in ((node, named.pop(node.name, node)) for node in other.nodes)
        ]
        nodes += named.values()
        services = [*other.services, *(pair for node in nodes for pair in (*node.servers, *node.clients))]
        return NetworkGraph(ends, graph.complete and other.complete, graph.named and other.named, services, nodes)

    def save(self) -> Any:
        """Return the states of the open transports."""
        return [transport.save() for transport in self._opened]

    def restore(self, saved: Any) -> None:
        """Restore the states that `save` returned; if the second transport was opened later, it does not change."""
        for transport, state in zip(self._opened, saved, strict=False):
            transport.restore(state)

    def close(self) -> None:
        """Close both transports with their endpoints; safe to call twice."""
        with self._lock:
            self._closed = True
        try:
            if self._second is not None:
                self._second.close()
        finally:
            self._first.close()
