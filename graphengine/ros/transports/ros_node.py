"""Base of the transports that are a ROS 2 node: its name, log, lock and message counts."""

from __future__ import annotations

import threading
import time
from collections import Counter

from graphengine.format.errors import TransportError
from graphengine.format.stateful import Stateful
from graphengine.messages import messages, names, qos
from graphengine.messages.definitions import Definitions
from graphengine.ros.graph import full_name
from graphengine.ros.transport import Writer

ROSOUT = ("/rosout", "rcl_interfaces/msg/Log", qos.ROSOUT)
"""Topic, type and QoS of the log of ROS 2, which `ros2 topic echo /rosout` and rqt_console show."""

_LEVELS = {"info": messages.Log.INFO, "warning": messages.Log.WARN, "error": messages.Log.ERROR}


class RosNode(Stateful):
    """A ROS 2 node; a subclass joins the network and opens the writer of the log.

    Args:
        name: what `ros2 node list` shows.
        namespace: absolute; `/` for none.
        definitions: message types.

    Raises:
        TopicError: ROS 2 would refuse the name or the namespace.
    """

    _rosout: Writer

    def __init__(self, name: str, namespace: str, definitions: Definitions) -> None:
        names.check_node_name(name)
        names.check_namespace(namespace)
        self.node = full_name(namespace, name)
        self._name = name
        self._namespace = namespace
        self._definitions = definitions
        self._lock = threading.RLock()
        self._closed = False
        self._mistyped = Counter[str]()
        """Number of messages of another definition that closed readers dropped, by topic."""

    def log(self, severity: str, text: str) -> None:
        """Publish a message on /rosout; severities are info, warning and error."""
        stamp = messages.Time(*divmod(time.time_ns(), 1_000_000_000))
        logger = f"{self._namespace}/{self._name}".strip("/").replace("/", ".")
        level = _LEVELS.get(severity, messages.Log.INFO)
        with self._lock:
            if not self._closed:
                self._rosout.write(messages.encode(messages.Log(stamp, level, logger, text, "", "", 0)))

    def _admit(self, name: str = "") -> None:
        """Refuse what a closed transport cannot do, for a topic or a service where one is named."""
        if self._closed:
            raise TransportError(f"{name}: the transport is closed" if name else "the transport is closed")
