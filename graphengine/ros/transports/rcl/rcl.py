"""The transport over an installed ROS 2: rclpy carries the encoded messages, over the RMW of the user's environment."""

from __future__ import annotations

import contextlib
import logging
import os
import threading
import warnings
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, TypeVar, get_args

from graphengine.format.errors import TransportError
from graphengine.messages.endpoints import QoS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.ros.domain import Domain
from graphengine.ros.network_graph import Direction, NetworkGraph, NetworkNode, full_name, split_name
from graphengine.ros.transport import Deliver, DeliverRequest, DeliverResponse
from graphengine.ros.transports.rcl.installation import is_from_wheels
from graphengine.ros.transports.rcl.rcl_endpoints import RclEnd, RclReader, RclWriter
from graphengine.ros.transports.rcl.rcl_profiles import UNKNOWN_NODE, ros_class, to_endpoint, to_profile
from graphengine.ros.transports.rcl.rcl_services import RclClient, RclServer
from graphengine.ros.transports.ros_node import ROSOUT, RosNode

_End = TypeVar("_End", bound=RclEnd)
_log = logging.getLogger(__name__)
_environment_lock = threading.Lock()
_PATIENCE = 0.1
"""Maximum wait for the executor when a reader, server or client is closed, s."""


class RclTransport(RosNode):
    """A transport that joins a domain as an rclpy node in a separate rclpy context."""

    source = b""
    """GID of the writer whose message is being delivered; always empty, because rclpy does not report the writer."""
    spin_time = 2.0
    """Typical duration of discovery, s; between Fast DDS and Cyclone DDS, discovery takes one second."""

    def _join(self) -> str:
        import rclpy
        from rclpy.executors import SingleThreadedExecutor

        domain = self._domain
        self._context = rclpy.Context()
        try:
            with discovery(domain):
                self._context.init(args=[], domain_id=domain.id)
            self._node = self._make_node(self._namespace, self._name)
            self._others: dict[str, Any] = {}
            """Additional rclpy nodes that offer services, by full name; each exists while it has servers."""
            self._executor = SingleThreadedExecutor(context=self._context)
            self._executor.add_node(self._node)
            self._rosout = self.writer(*ROSOUT)
        except Exception as error:
            self._context.try_shutdown()
            raise TransportError(f"rclpy cannot join {domain}: {error}") from error
        self._thread = threading.Thread(target=self._spin, name=f"rclpy domain {domain.id}", daemon=True)
        self._thread.start()
        return f"rclpy ({rclpy.get_rmw_implementation_identifier()})"

    def writer(self, topic: str, message_type: str, qos: QoS) -> RclWriter:
        """Create a writer on a topic.

        Raises:
            MessageTypeError: the type is not installed.
            TransportError: rclpy refuses the topic, or the transport is closed.
        """
        from rclpy.event_handler import PublisherEventCallbacks

        writer = RclWriter(topic, self._remove)
        events = PublisherEventCallbacks(matched=writer.count, use_default_callbacks=False)
        return self._open(writer, message_type, qos, event_callbacks=events)

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Deliver) -> RclReader:
        """Create a reader on a topic; `deliver` runs in the transport's thread.

        Raises:
            TransportError: as for `writer`.
        """
        from rclpy.event_handler import SubscriptionEventCallbacks

        reader = RclReader(topic, self._remove, partial(self._fits, message_type), deliver)
        events = SubscriptionEventCallbacks(use_default_callbacks=False)
        return self._open(reader, message_type, qos, callback=reader.receive, event_callbacks=events, raw=True)

    def server(self, service: str, service_type: str, qos: QoS, deliver: DeliverRequest, node: str = "") -> RclServer:
        """Create a server of a service; `deliver` runs in the transport's thread.

        Raises:
            TopicError: the name of the node is not legal.
            TransportError: as for `writer`.
        """
        self._check_node(node)
        with self._lock:
            server = RclServer(service, self._remove, deliver, self._node, self._executor.create_task)
            server.node = node
            self._open(server, service_type, qos, callback=server.returned)
            server.begin()
        return server

    def client(self, service: str, service_type: str, qos: QoS, deliver: DeliverResponse) -> RclClient:
        """Create a client of a service; `deliver` runs in the transport's thread.

        Raises:
            TransportError: as for `writer`.
        """
        return self._open(RclClient(service, self._remove, deliver, self._node), service_type, qos)

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> NetworkGraph:
        """Return all known endpoints, or faster only those of the topics and directions in `asked`.

        Raises:
            TransportError: the transport is closed.
        """
        services: list[tuple[str, str]] = []
        nodes: list[NetworkNode] = []
        if asked is None:
            with self._lock:
                self._admit()
                services = _pairs(self._node.get_service_names_and_types())
                nodes = list(self._nodes())
                topics = [topic for topic, _ in self._node.get_topic_names_and_types()]
            asked = [(topic, direction) for topic in topics for direction in get_args(Direction)]
        ask = {
            "publish": self._node.get_publishers_info_by_topic,
            "subscribe": self._node.get_subscriptions_info_by_topic,
        }
        found: list[Any] = []
        for topic, direction in asked:
            with self._lock:  # not around the loop, because other threads wait for the lock
                self._admit()
                found += [(topic, info) for info in ask[direction](topic)]
        named = all(info.node_name != UNKNOWN_NODE for _, info in found)
        return NetworkGraph((to_endpoint(*end) for end in found), named=named, services=services, nodes=nodes)

    def _nodes(self) -> Iterator[NetworkNode]:
        """Yield all known nodes with their services; of several nodes with one name, rclpy reports the services of one node."""
        from rclpy.node import NodeNameNonExistentError

        for name, namespace in self._node.get_node_names_and_namespaces():
            with contextlib.suppress(NodeNameNonExistentError):  # the node has just left
                offered = self._node.get_service_names_and_types_by_node(name, namespace)
                called = self._node.get_client_names_and_types_by_node(name, namespace)
                yield NetworkNode(full_name(namespace, name), _pairs(offered), _pairs(called))

    def _leave(self) -> None:
        # The executor's wait ends when it gets work.
        self._executor.create_task(lambda: None)
        self._thread.join()
        self._executor.shutdown()
        for node in (*self._others.values(), self._node):
            node.destroy_node()
        self._context.try_shutdown()

    def _count_servers(self, services: Iterable[str]) -> Mapping[str, int]:
        return {service: self._node.count_services(service) for service in services}

    def _fits(self, message_type: str, reader: RclReader) -> bool:
        """Return whether all type hashes that publishers on the reader's topic announce agree with the session's definition."""
        number = self._node.count_publishers(reader.name)
        if number != reader.publishers:
            found = self._node.get_publishers_info_by_topic(reader.name)
            hashes = {str(info.topic_type_hash) for info in found if info.topic_type == message_type}
            reader.agrees = all(self._definitions.agrees(message_type, type_hash) for type_hash in hashes)
            reader.publishers = number
        return reader.agrees

    def _open(self, end: _End, kind: str, qos: QoS, **more: Any) -> _End:
        """Create the rclpy object of an endpoint, and return the endpoint; `kind` is the message or service type."""
        what = f"{end.name} cannot be created with the type {kind}"
        with self._lock, warnings.catch_warnings():
            # Jazzy's rclpy warns about its own use of a deprecated class for the event of a publisher.
            warnings.simplefilter("ignore", DeprecationWarning)
            self._admit(end.name)
            try:
                found = ros_class(kind, service=bool(end.peer))
            except (AttributeError, ImportError, ValueError) as error:
                source = "" if is_from_wheels() else ", or build its package and source the workspace"
                remedy = f"use --transport dds{source}"
                raise MessageTypeError(f"{what}: {error}", kind.rpartition("/")[2], remedy) from error
            try:
                create = getattr(self._node_of(end), f"create_{end.kind}")
                end.entity = create(found, end.name, qos_profile=to_profile(qos), **more)
            except Exception as error:
                self._drop_unused(end.node)
                raise TransportError(f"{what}: {error}") from error
            (self._writers if isinstance(end, RclWriter) else self._readers).append(end)
        return end

    def _delete(self, end: RclEnd) -> None:
        entity, end.entity = end.entity, None
        getattr(self._node_of(end), f"destroy_{end.kind}")(entity)
        if not isinstance(end, RclWriter):
            self._wait_for_executor()
        self._drop_unused(end.node)

    def _drop_unused(self, name: str) -> None:
        """Destroy an additional node if it no longer has servers."""
        if name in self._others and all(other.node != name for other in self._readers):
            node = self._others.pop(name)
            self._executor.remove_node(node)
            self._wait_for_executor()
            node.destroy_node()

    def _node_of(self, end: RclEnd) -> Any:
        """Return the rclpy node of an endpoint; create an additional node for its first endpoint."""
        if not end.node or end.node == self.node:
            return self._node
        if end.node not in self._others:
            node = self._make_node(*split_name(end.node), enable_rosout=False)
            self._others[end.node] = node
            self._executor.add_node(node)
        return self._others[end.node]

    def _make_node(self, namespace: str, name: str, **options: Any) -> Any:
        from rclpy.node import Node

        return Node(name, namespace=namespace, context=self._context, start_parameter_services=False, **options)

    def _wait_for_executor(self) -> None:
        """Wait until the executor has released destroyed endpoints; until then, their topic cannot get another type."""
        gone = threading.Event()
        self._executor.create_task(gone.set)
        gone.wait(_PATIENCE)

    def _spin(self) -> None:
        from rclpy.exceptions import InvalidHandle

        failed = False
        while not self._closed:
            try:
                self._executor.spin_once()
            except InvalidHandle:
                continue  # a writer or reader was closed at this moment
            except Exception:
                if not failed:
                    _log.exception("rclpy could not take a message; further errors are not reported")
                failed = True


def _pairs(services: Iterable[tuple[str, list[str]]]) -> list[tuple[str, str]]:
    """Return one (name, type) pair for each type of each service."""
    return [(name, kind) for name, kinds in services for kind in kinds]


@contextlib.contextmanager
def discovery(domain: Domain) -> Iterator[None]:
    """Return a context in which the environment variables that rclpy.Context reads give the discovery range of `domain`."""
    wanted = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": domain.discovery_range,
        "ROS_STATIC_PEERS": ";".join(domain.static_peers),
        "ROS_LOCALHOST_ONLY": "",
    }
    with _environment_lock:
        before = {name: os.environ[name] for name in wanted if name in os.environ}
        os.environ.update(wanted)
        try:
            yield
        finally:
            for name in wanted.keys() - before.keys():
                del os.environ[name]
            os.environ.update(before)
