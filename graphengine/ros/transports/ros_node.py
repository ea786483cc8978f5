"""Base class of transports that are a ROS 2 node, with the node's name, log, lock, endpoints and message counts."""

from __future__ import annotations

import atexit
import os
import threading
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.format.stateful import Stateful
from graphengine.messages import messages, names, qos
from graphengine.ros.network_graph import full_name, split_name
from graphengine.ros.transport import JoinOptions, Writer

ROSOUT = ("/rosout", "rcl_interfaces/msg/Log", qos.ROSOUT)
"""Topic, message type and QoS of the ROS 2 log."""

_LEVELS = {"info": messages.Log.INFO, "warning": messages.Log.WARN, "error": messages.Log.ERROR}


class RosNode(Stateful):
    """A ROS 2 node. A subclass joins the network in `_join`, and adds each new `RosEnd` to `_writers` or `_readers`.

    Args:
        options: domain and name of the node.

    Raises:
        TopicError: the node's name or namespace is not legal in ROS 2.
        TransportError: the domain cannot be joined.
    """

    _rosout: Writer | None = None
    """Writer for /rosout; None if the process does not announce the node."""
    notices: Sequence[str] = ()

    def __init__(self, options: JoinOptions) -> None:
        self._domain, self._name, self._namespace = options.domain, options.node_name, options.node_namespace
        names.check_node_name(self._name)
        names.check_namespace(self._namespace)
        self.node = full_name(self._namespace, self._name)
        self._definitions = options.definitions
        self._patient = options.patient
        self.identity = os.urandom(8)
        self._lock = threading.RLock()
        self._closed = False
        self._writers: list[Any] = []
        self._readers: list[Any] = []
        """Readers, service servers and service clients."""
        self._mistyped = Counter[str]()
        """Number of messages on each topic that closed readers have dropped because of a different type definition."""
        self.description = f"{self._join()}, {self._domain}" + (f"; {options.because}" if options.because else "")
        atexit.register(self.close)

    def _join(self) -> str:
        """Join the network and create the writer for /rosout; return the implementation's name, for `description`."""
        raise NotImplementedError

    def _leave(self) -> None:
        """Leave the network and end the transport's thread."""

    def _delete(self, end: Any) -> None:
        """Remove an endpoint from the network."""

    def _count_servers(self, services: Iterable[str]) -> Mapping[str, int]:
        """Return the number of known servers of each service, including those of this node."""
        raise NotImplementedError

    @property
    def foreign_services(self) -> Mapping[str, str]:
        """A warning for each service with incompatible peers, by the service's name."""
        told = {}
        for end in tuple(self._readers):
            with self._lock:  # not around the loop, because other threads wait for the lock
                if not self._closed and (warning := end.warning()):
                    told[end.name] = warning
        return told

    @property
    def rival_services(self) -> Sequence[str]:
        """Services of this transport that another known program also offers; both servers receive each call."""
        with self._lock:
            own = Counter(end.name for end in self._readers if end.peer == "client")
            known = {} if self._closed else self._count_servers(own)
            return [service for service, number in own.items() if known.get(service, 0) > number]

    @property
    def malformed(self) -> Mapping[str, int]:
        """Number of malformed messages dropped on each topic or service, by name: they do not fit the message type."""
        counts = Counter(self._mistyped)
        for end in tuple(self._readers):
            counts[end.name] += end.malformed
        return +counts

    def log(self, severity: str, text: str) -> None:
        """Publish a message on /rosout; `severity` is info, warning or error."""
        stamp = messages.Time(*divmod(time.time_ns(), 1_000_000_000))
        logger = f"{self._namespace}/{self._name}".strip("/").replace("/", ".")
        level = _LEVELS.get(severity, messages.Log.INFO)
        with self._lock:
            if self._rosout is not None and not self._closed:
                self._rosout.write(messages.encode(messages.Log(stamp, level, logger, text, "", "", 0)))

    def close(self) -> None:
        """Remove the node from the network, and end the transport's thread; safe to call twice."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self._leave()
        for end in (*self._writers, *self._readers):
            end.end()
        atexit.unregister(self.close)

    @staticmethod
    def _check_node(node: str) -> None:
        """Raise TopicError if the full name of a node is not legal in ROS 2; accept an empty name."""
        if node:
            namespace, name = split_name(node)
            names.check_namespace(namespace)
            names.check_node_name(name)

    def _admit(self, name: str = "") -> None:
        """Raise TransportError if the transport is closed; the message mentions `name`, a topic or service."""
        if self._closed:
            raise TransportError(f"{name}: the transport is closed" if name else "the transport is closed")

    def _remove(self, end: Any) -> None:
        """Remove a closed endpoint from the node and from the network."""
        with self._lock:
            ends = self._writers if end in self._writers else self._readers
            if self._closed or end not in ends:
                return
            ends.remove(end)
            self._mistyped[end.name] += 0 if end.peer else end.malformed
            self._delete(end)
            end.end()
