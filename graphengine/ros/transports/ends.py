"""Base class of the writers, readers, servers and clients of a ROS 2 node."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Any

from graphengine.format.errors import TransportError

_log = logging.getLogger(__name__)

Remove = Callable[[Any], None]
"""Callback that removes a closed endpoint from its node."""


class RosEnd:
    """A writer, reader, server or client of a node.

    Args:
        name: name of the topic or service.
        remove: called when the endpoint is closed.
    """

    peer = ""
    """Role of the peers of a service endpoint: `client` or `server`; empty for a writer or reader."""

    def __init__(self, name: str, remove: Remove) -> None:
        self.name = name
        self.node = ""
        """Full name of the node that has the endpoint; empty for the transport's own node."""
        self.malformed = 0
        """Number of received messages that were dropped because they do not fit the message type."""
        self.dropped = 0
        """Number of sent messages that were dropped because a peer was too slow."""
        self._remove = remove
        self._failed = False
        self._delivering = threading.RLock()
        self._delivers = True

    def close(self) -> None:
        """Close the endpoint; safe to call twice.

        The call waits until another thread has finished its delivery; afterwards no message is delivered.
        """
        with self._delivering:
            self._delivers = False
        self._remove(self)

    def end(self) -> None:
        """Forget all peers; called when the endpoint or its node has left the network."""

    def warning(self) -> str:
        """Return a warning about incompatible peers; empty if there are none."""
        return ""

    def hand_over(self, take: Callable[..., None], *message: Any) -> None:
        """Call `take` with a message unless the endpoint is closed; catch all exceptions, and log only the first one."""
        with self._delivering:
            if not self._delivers:
                return
            try:
                take(*message)
            except Exception as error:
                if not self._failed:
                    what = "a message could not be delivered; further errors are not reported"
                    full = isinstance(error, MemoryError)
                    _log.error("%s: %s", self.name, f"out of memory: {what}" if full else what, exc_info=not full)
                self._failed = True

    def closed(self) -> TransportError:
        """Return the error for a call after `close`."""
        return TransportError(f"{self.name} is closed")

    def not_sent(self, data: bytes, why: object) -> TransportError:
        """Return the error for a message that could not be sent."""
        return TransportError(f"{self.name}: {len(data)} bytes were not sent: {why}")
