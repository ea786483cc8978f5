"""What writers, readers, servers and clients of a ROS 2 node have in common."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from graphengine.format.errors import TransportError

_log = logging.getLogger(__name__)

Remove = Callable[[Any], None]
"""Takes an end out of its node."""


class RosEnd:
    """A writer, reader, server or client, until it is closed.

    Args:
        name: of its topic or service.
        remove: called when it is closed.
    """

    peer = ""
    """What the peers of a service's end are: `client` or `server`; empty for a writer or reader."""

    def __init__(self, name: str, remove: Remove) -> None:
        self.name = name
        self.malformed = 0
        """Messages that were dropped because they are none of its type."""
        self.dropped = 0
        """Messages given up because a peer did not keep up."""
        self._remove = remove
        self._failed = False

    def close(self) -> None:
        """Leave the topic or service; a second time does nothing."""
        self._remove(self)

    def end(self) -> None:
        """Have no peers from here on: it has left the network, or its node has."""

    def warning(self) -> str:
        """What to tell people about peers that cannot be talked to; empty where there are none."""
        return ""

    def hand_over(self, take: Callable[..., None], *message: Any) -> None:
        """Call `take` in the transport's thread, which outlives an error of it: the first is logged."""
        try:
            take(*message)
        except Exception:
            if not self._failed:
                _log.exception("%s: a message could not be delivered; told once", self.name)
            self._failed = True

    def closed(self) -> TransportError:
        """The error of a call on it after it was closed."""
        return TransportError(f"{self.name} is closed")

    def not_sent(self, data: bytes, why: object) -> TransportError:
        """The error that bytes were not sent."""
        return TransportError(f"{self.name}: {len(data)} bytes were not sent: {why}")
