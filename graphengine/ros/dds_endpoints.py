"""What a DDS transport writes and reads topics with."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from cyclonedds.core import DDSException

from graphengine.diagnostics import TransportError
from graphengine.ros import cyclone
from graphengine.ros.handing_over import HandingOver


def gid_of(entity: Any) -> bytes:
    """How ROS 2 knows an entity: the 16 bytes of its RTPS GUID."""
    return bytes(entity.guid.bytes)


class DdsWriter:
    """A DDS writer."""

    def __init__(self, topic: str, entity: Any, remove: Callable[[DdsWriter], None]) -> None:
        self.topic = topic
        self.entity = entity
        self.gid = gid_of(entity)
        self.matched = False
        self.dropped = 0
        """Messages given up because a reader did not keep up."""
        self._remove = remove
        self._send = cyclone.sender(entity)
        self._lock = threading.Lock()

    def write(self, data: bytes) -> None:
        """Send one message; one that a reader blocks for longer than 100 ms is dropped and counted.

        Raises:
            TransportError: it is no message of the topic's type, or the writer is closed.
        """
        if len(data) & 3:
            data += bytes(-len(data) & 3)
        code = self._send(data)
        if code == cyclone.TIMEOUT:
            self.dropped += 1
        elif code < 0:
            raise TransportError(f"{self.topic}: {len(data)} bytes were not sent: {cyclone.reason(code)}")

    def refresh(self) -> None:
        """Look whether readers are there."""
        # Two threads that look must not note down what they saw in the wrong order.
        with self._lock:
            try:
                self.matched = self.entity.get_publication_matched_status().current_count > 0
            except DDSException:
                self.matched = False

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self._remove(self)


class DdsReader:
    """A DDS reader."""

    def __init__(
        self, topic: str, entity: Any, deliver: Callable[[bytes], None], remove: Callable[[DdsReader], None]
    ) -> None:
        self.topic = topic
        self.entity = entity
        self.gid = gid_of(entity)
        self._deliver = deliver
        self._remove = remove
        self._hand_over = HandingOver(topic)
        self._writer = 0
        self._gids: dict[int, bytes] = {}

    @property
    def source(self) -> bytes:
        """GID of the writer of the message that is being delivered; empty when it is gone already."""
        if self._writer not in self._gids:
            self._gids[self._writer] = cyclone.writer_gid(self.entity, self._writer)
        return self._gids[self._writer]

    def drain(self) -> bool:
        """Deliver some of what has arrived; false when there was nothing."""
        arrived = cyclone.take(self.entity)
        for data, self._writer in arrived:
            self._hand_over(self._deliver, data)
        return bool(arrived)

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self._remove(self)
