"""A transport over an installed ROS 2: rclpy carries the encoded messages, on whatever RMW the user runs."""

from __future__ import annotations

import atexit
import contextlib
import logging
import os
import threading
import warnings
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, get_args

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import QoS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.ros.domain import Domain
from graphengine.ros.graph import Direction, Graph
from graphengine.ros.transports.rcl.rcl_endpoints import RclReader, RclWriter
from graphengine.ros.transports.rcl.rcl_profiles import part_of_action, to_endpoint, to_profile
from graphengine.ros.transports.rcl.rcl_services import RclClient, RclServer
from graphengine.ros.transports.ros_node import ROSOUT, RosNode

_log = logging.getLogger(__name__)
_environment_lock = threading.Lock()
_PATIENCE = 0.1
"""Seconds that closing a reader may take."""


class RclTransport(RosNode):
    """A node of rclpy in a context of its own.

    Args:
        domain: where to be.
        node_name: what `ros2 node list` shows.
        node_namespace: absolute; `/` for none.
        because: why this transport was chosen, for the description.
        definitions: message types.

    Raises:
        TopicError: ROS 2 would refuse the node's name or namespace.
        TransportError: rclpy cannot start.
    """

    source = b""
    """GID of a message's writer, which rclpy does not tell."""

    def __init__(
        self,
        domain: Domain,
        node_name: str,
        node_namespace: str = "/",
        because: str = "",
        definitions: Definitions = DEFINITIONS,
    ) -> None:
        super().__init__(node_name, node_namespace, definitions)
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node

        self._endpoints: list[RclWriter | RclReader] = []
        self._services: list[RclServer | RclClient] = []
        self._context = rclpy.Context()
        try:
            with discovery(domain):
                self._context.init(args=[], domain_id=domain.id)
            self._node = Node(
                node_name, namespace=node_namespace, context=self._context, start_parameter_services=False
            )
            self._executor = SingleThreadedExecutor(context=self._context)
            self._executor.add_node(self._node)
            self._rosout = self.writer(*ROSOUT)
        except Exception as error:
            self._context.try_shutdown()
            raise TransportError(f"rclpy cannot join {domain}: {error}") from error
        self.spin_time = 2.0  # Fast DDS and Cyclone DDS find each other's endpoints after a second
        used = rclpy.get_rmw_implementation_identifier()
        self.description = f"rclpy ({used}), {domain}" + (f"; {because}" if because else "")
        self._thread = threading.Thread(target=self._spin, name=f"rclpy domain {domain.id}", daemon=True)
        self._thread.start()
        atexit.register(self.close)

    def writer(self, topic: str, message_type: str, qos: QoS) -> RclWriter:
        """A writer on a topic.

        Raises:
            MessageTypeError: that type is not installed.
            TransportError: rclpy refuses the topic, or the transport is closed.
        """
        from rclpy.event_handler import PublisherEventCallbacks

        writer = RclWriter(topic, self._remove)
        with self._opening(topic, message_type, "get_message") as message, warnings.catch_warnings():
            # Jazzy's rclpy warns of a class of its own that it uses for this event.
            warnings.simplefilter("ignore", DeprecationWarning)
            writer.publisher = self._node.create_publisher(
                message,
                topic,
                to_profile(qos),
                event_callbacks=PublisherEventCallbacks(matched=writer.count, use_default_callbacks=False),
            )
            self._endpoints.append(writer)
        return writer

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Callable[[bytes], None]) -> RclReader:
        """A reader on a topic; `deliver` runs in the transport's thread.

        Raises:
            TransportError: as for `writer`.
        """
        from rclpy.event_handler import SubscriptionEventCallbacks

        reader = RclReader(topic, partial(self._fits, message_type), deliver, self._remove)
        with self._opening(topic, message_type, "get_message") as message:
            reader.subscription = self._node.create_subscription(
                message,
                topic,
                reader.receive,
                to_profile(qos),
                event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
                raw=True,
            )
            self._endpoints.append(reader)
        return reader

    def server(self, service: str, service_type: str, qos: QoS, deliver: Callable[[bytes, bytes], None]) -> RclServer:
        """A server of a service; `deliver` runs in the transport's thread.

        Raises:
            TransportError: as for `writer`.
        """
        server = RclServer(service, deliver, self._remove_service)
        with self._opening(service, service_type, "get_service") as kind:
            server.open(
                lambda callback: self._node.create_service(kind, service, callback, qos_profile=to_profile(qos))
            )
            self._services.append(server)
        return server

    def client(self, service: str, service_type: str, qos: QoS, deliver: Callable[[int, bytes], None]) -> RclClient:
        """A client of a service; `deliver` runs in the transport's thread.

        Raises:
            TransportError: as for `writer`.
        """
        client = RclClient(service, deliver, self._remove_service)
        with self._opening(service, service_type, "get_service") as kind:
            client.entity = self._node.create_client(kind, service, qos_profile=to_profile(qos))
            self._services.append(client)
        return client

    @property
    def foreign_services(self) -> Mapping[str, str]:
        """Services with a peer on another RMW, and what to tell people about each."""
        found = {}
        for end in tuple(self._services):
            with self._lock:
                found[end.service] = "" if self._closed else end.warning(self._node)
        return {service: warning for service, warning in found.items() if warning}

    @property
    def rival_services(self) -> Sequence[str]:
        """Services of this transport that somebody else offers too, as far as it is known; a call reaches both."""
        with self._lock:
            own = Counter(end.service for end in self._services if isinstance(end, RclServer))
            told = {} if self._closed else {service: self._node.count_services(service) for service in own}
            return [service for service, number in told.items() if number > own[service]]

    @property
    def malformed(self) -> Mapping[str, int]:
        """By topic, how many messages were dropped while a publisher had another definition of the topic's type."""
        counts = Counter(self._mistyped)
        for end in tuple(self._endpoints):
            counts[end.topic] += end.malformed if isinstance(end, RclReader) else 0
        return +counts

    def graph(self, asked: Collection[tuple[str, Direction]] | None = None) -> Graph:
        """Who writes and reads which topic, as far as it is known; it is the faster the less is asked for.

        Raises:
            TransportError: the transport is closed.
        """
        services: list[tuple[str, list[str]]] = []
        if asked is None:
            with self._lock:
                self._admit()
                services = self._node.get_service_names_and_types()
                topics = [topic for topic, _ in self._node.get_topic_names_and_types()]
            asked = [(topic, direction) for topic in topics for direction in get_args(Direction)]
        ask = {
            "publish": self._node.get_publishers_info_by_topic,
            "subscribe": self._node.get_subscriptions_info_by_topic,
        }
        found = []
        for topic, direction in asked:
            with self._lock:  # not for all of them, as other threads wait for it
                self._admit()
                found += [to_endpoint(topic, info) for info in ask[direction](topic)]
        known = [(name, kind) for name, kinds in services for kind in kinds]
        return Graph(found, named=all(end.node for end in found), services=known)

    def close(self) -> None:
        """Remove the node, end the thread, and shut the context down; safe to call twice."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        # Work is what ends a wait for work.
        self._executor.create_task(lambda: None)
        self._thread.join()
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()
        for service in self._services:
            service.entity = None
        atexit.unregister(self.close)
        for endpoint in self._endpoints:
            if isinstance(endpoint, RclWriter):
                endpoint.matched = False

    def _fits(self, message_type: str, reader: RclReader) -> bool:
        """Whether all publishers of a reader's topic have the definition here, as far as they announce theirs."""
        number = self._node.count_publishers(reader.topic)
        if number != reader.publishers:
            found = self._node.get_publishers_info_by_topic(reader.topic)
            hashes = {str(info.topic_type_hash) for info in found if info.topic_type == message_type}
            reader.agrees = all(self._definitions.agrees(message_type, type_hash) for type_hash in hashes)
            reader.publishers = number
        return reader.agrees

    @contextlib.contextmanager
    def _opening(self, topic: str, message_type: str, find: str) -> Iterator[Any]:
        """The class of a type, which a function of rosidl_runtime_py finds."""
        from rosidl_runtime_py import utilities

        with self._lock:
            self._admit(topic)
            try:
                message = part_of_action(message_type) or getattr(utilities, find)(message_type)
            except (AttributeError, ImportError, RuntimeError, ValueError) as error:
                remedy = "build its package and source the workspace, or use --transport dds"
                what = f"{topic} cannot be opened with {message_type}: {error}"
                raise MessageTypeError(what, message_type.rpartition("/")[2], remedy) from error
            try:
                yield message
            except Exception as error:
                raise TransportError(f"{topic} cannot be opened with {message_type}: {error}") from error

    def _remove(self, endpoint: RclWriter | RclReader) -> None:
        with self._lock:
            if self._closed or endpoint not in self._endpoints:
                return
            self._endpoints.remove(endpoint)
            if isinstance(endpoint, RclWriter):
                endpoint.matched = False
                self._node.destroy_publisher(endpoint.publisher)
            else:
                self._mistyped[endpoint.topic] += endpoint.malformed
                self._node.destroy_subscription(endpoint.subscription)
                self._wait_for_executor()

    def _remove_service(self, service: RclServer | RclClient) -> None:
        with self._lock:
            if self._closed or service not in self._services:
                return
            self._services.remove(service)
            entity, service.entity = service.entity, None
            destroy = self._node.destroy_service if isinstance(service, RclServer) else self._node.destroy_client
            destroy(entity)
            self._wait_for_executor()

    def _wait_for_executor(self) -> None:
        """What was destroyed is gone when the executor has come round; until then its name can have no other type."""
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
                continue  # of a writer or reader that was closed just then
            except Exception:
                if not failed:
                    _log.exception("rclpy could not take a message; told once")
                failed = True


@contextlib.contextmanager
def discovery(domain: Domain) -> Iterator[None]:
    """The environment that a context reads its discovery range from when it is made; there is no other way to tell it."""
    wanted = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": domain.discovery_range,
        "ROS_STATIC_PEERS": ";".join(domain.static_peers),
        "ROS_LOCALHOST_ONLY": "",
    }
    with _environment_lock:
        before = {name: os.environ.get(name) for name in wanted}
        os.environ.update(wanted)
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value
