"""A transport over an installed ROS 2: rclpy carries the encoded messages, on whatever RMW the user runs."""

from __future__ import annotations

import atexit
import contextlib
import importlib
import logging
import os
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from graphengine.context import QoS
from graphengine.diagnostics import TransportError
from graphengine.ros import names, rosout
from graphengine.ros.domain import Domain
from graphengine.ros.graph import Endpoint, Graph
from graphengine.ros.interfaces import MessageTypeError
from graphengine.ros.qos import settled

_log = logging.getLogger(__name__)
_environment_lock = threading.Lock()
_PATIENCE = 0.1
"""Seconds that closing a reader may take."""
_UNKNOWN_NODE = "_NODE_NAME_UNKNOWN_"
"""What rclpy calls the node of an endpoint before the node's process told of it."""


def import_error() -> str | None:
    """Why rclpy cannot be used, or None; an installation for another Python counts as none."""
    try:
        for module in ("rclpy.executors", "rclpy.node", "rosidl_runtime_py.utilities"):
            importlib.import_module(module)
    except Exception as error:
        return f"{type(error).__name__}: {error}".splitlines()[0]
    return None


class RclWriter:
    """A publisher of rclpy."""

    def __init__(self, topic: str, remove: Callable[[RclWriter], None]) -> None:
        self.topic = topic
        self.matched = False
        self.publisher: Any = None
        self._remove = remove

    def count(self, event: Any) -> None:
        """Note what rclpy tells of readers that come or go."""
        self.matched = event.current_count > 0

    def write(self, data: bytes) -> None:
        """Send one message.

        Raises:
            TransportError: rclpy refuses it, or the writer is closed.
        """
        try:
            self.publisher.publish(data)
        except Exception as error:
            raise TransportError(f"{self.topic}: {len(data)} bytes were not sent: {error}") from error

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self._remove(self)


class RclReader:
    """A subscription of rclpy."""

    def __init__(self, topic: str, deliver: Callable[[bytes], None], remove: Callable[[RclReader], None]) -> None:
        self.topic = topic
        self.subscription: Any = None
        self._deliver = deliver
        self._remove = remove
        self._failed = False

    def receive(self, data: bytes) -> None:
        """Deliver one message."""
        try:
            self._deliver(data)
        except Exception:
            if not self._failed:
                _log.exception("%s: a message could not be delivered; told once", self.topic)
            self._failed = True

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self._remove(self)


class RclTransport:
    """A node of rclpy in a context of its own.

    Args:
        domain: where to be.
        node_name: what `ros2 node list` shows.
        node_namespace: absolute; `/` for none.
        because: why this transport was chosen, for the description.

    Raises:
        TopicError: ROS 2 would refuse the node's name or namespace.
        TransportError: rclpy is not there, or cannot start.
    """

    source = b""
    """GID of a message's writer, which rclpy does not tell."""

    def __init__(self, domain: Domain, node_name: str, node_namespace: str = "/", because: str = "") -> None:
        names.check_node_name(node_name)
        names.check_namespace(node_namespace)
        missing = import_error()
        if missing:
            raise TransportError(f"rclpy cannot be used: {missing}")
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node

        self._name = node_name
        self._namespace = node_namespace
        self._lock = threading.RLock()
        self._closed = False
        self._endpoints: list[RclWriter | RclReader] = []
        self._context = rclpy.Context()
        try:
            with discovery(domain):
                self._context.init(args=[], domain_id=domain.id)
            self._node = Node(node_name, namespace=node_namespace, context=self._context)
            self._executor = SingleThreadedExecutor(context=self._context)
            self._executor.add_node(self._node)
            self._rosout = self.writer(rosout.TOPIC, rosout.TYPE, rosout.QOS)
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
        with self._opening(topic, message_type) as message, warnings.catch_warnings():
            # Jazzy's rclpy warns of a class of its own that it uses for this event.
            warnings.simplefilter("ignore", DeprecationWarning)
            writer.publisher = self._node.create_publisher(
                message, topic, _profile(qos), event_callbacks=PublisherEventCallbacks(matched=writer.count)
            )
            self._endpoints.append(writer)
        return writer

    def reader(self, topic: str, message_type: str, qos: QoS, deliver: Callable[[bytes], None]) -> RclReader:
        """A reader on a topic; `deliver` runs in the transport's thread.

        Raises:
            TransportError: as for `writer`.
        """
        reader = RclReader(topic, deliver, self._remove)
        with self._opening(topic, message_type) as message:
            reader.subscription = self._node.create_subscription(
                message, topic, reader.receive, _profile(qos), raw=True
            )
            self._endpoints.append(reader)
        return reader

    def graph(self) -> Graph:
        """Who writes and reads which topic, as far as it is known.

        Raises:
            TransportError: the transport is closed.
        """
        with self._lock:
            if self._closed:
                raise TransportError("the transport is closed")
            topics = [topic for topic, _ in self._node.get_topic_names_and_types()]
            asked = (self._node.get_publishers_info_by_topic, self._node.get_subscriptions_info_by_topic)
            found = [_endpoint(topic, info) for topic in topics for ask in asked for info in ask(topic)]
        return Graph(found, named=all(end.node for end in found))

    def log(self, severity: str, text: str) -> None:
        """Tell people who watch /rosout; severities are info, warning and error."""
        with self._lock:
            if not self._closed:
                self._rosout.write(rosout.record(self._namespace, self._name, severity, text))

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
        atexit.unregister(self.close)
        for endpoint in self._endpoints:
            if isinstance(endpoint, RclWriter):
                endpoint.matched = False

    @contextlib.contextmanager
    def _opening(self, topic: str, message_type: str) -> Iterator[Any]:
        from rosidl_runtime_py.utilities import get_message

        with self._lock:
            if self._closed:
                raise TransportError(f"{topic}: the transport is closed")
            try:
                message = get_message(message_type)
            except (AttributeError, ImportError, ValueError) as error:
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
                self._node.destroy_subscription(endpoint.subscription)
                # It is gone when the executor has come round; until then the topic can have no other type.
                gone = threading.Event()
                self._executor.create_task(gone.set)
                gone.wait(_PATIENCE)

    def _spin(self) -> None:
        failed = False
        while not self._closed:
            try:
                self._executor.spin_once()
            except Exception:
                if not failed:
                    _log.exception("rclpy could not take a message; told once")
                failed = True


def _profile(qos: QoS) -> Any:
    from rclpy.duration import Duration
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

    qos = settled(qos)
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL if qos.history == "keepAll" else HistoryPolicy.KEEP_LAST,
        depth=qos.depth,
        reliability=ReliabilityPolicy.RELIABLE if qos.reliability == "reliable" else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL
        if qos.durability == "transientLocal"
        else DurabilityPolicy.VOLATILE,
        deadline=Duration(seconds=qos.deadline),
        lifespan=Duration(seconds=qos.lifespan),
        liveliness=LivelinessPolicy.MANUAL_BY_TOPIC
        if qos.liveliness == "manualByTopic"
        else LivelinessPolicy.AUTOMATIC,
        liveliness_lease_duration=Duration(seconds=qos.lease_duration),
    )


def _endpoint(topic: str, info: Any) -> Endpoint:
    owned = info.node_name != _UNKNOWN_NODE
    return Endpoint(
        gid=bytes(info.endpoint_gid),
        direction="publish" if info.endpoint_type.name == "PUBLISHER" else "subscribe",
        topic=topic,
        message_type=info.topic_type,
        qos=_qos(info.qos_profile),
        type_hash=str(info.topic_type_hash),
        node=info.node_name if owned else "",
        namespace=info.node_namespace if owned else "",
    )


def _qos(profile: Any) -> QoS:
    kinds = (profile.history, profile.reliability, profile.durability, profile.liveliness)
    history, reliability, durability, liveliness = (_WORDS.get(kind.name, "systemDefault") for kind in kinds)
    return QoS(
        history=history,
        depth=profile.depth,
        reliability=reliability,
        durability=durability,
        deadline=_seconds(profile.deadline),
        lifespan=_seconds(profile.lifespan),
        liveliness=liveliness,
        lease_duration=_seconds(profile.liveliness_lease_duration),
    )


_WORDS: Mapping[str, Any] = {
    "KEEP_LAST": "keepLast",
    "KEEP_ALL": "keepAll",
    "RELIABLE": "reliable",
    "BEST_EFFORT": "bestEffort",
    "VOLATILE": "volatile",
    "TRANSIENT_LOCAL": "transientLocal",
    "AUTOMATIC": "automatic",
    "MANUAL_BY_TOPIC": "manualByTopic",
}
"""Kinds that rclpy names, and how a profile is written; others, such as UNKNOWN, are `systemDefault`."""


def _seconds(time: Any) -> float:
    """A duration of rclpy; 0 for an infinite one."""
    from rclpy.duration import Infinite

    return 0.0 if time == Infinite else time.nanoseconds / 1e9


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
