"""Writers and readers of the DDS transport."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, ClassVar

from cyclonedds.core import DDSException, DDSStatus

from graphengine.ros.transport import Deliver
from graphengine.ros.transports.dds import cyclone
from graphengine.ros.transports.ends import Remove, RosEnd


def gid_of(entity: Any) -> bytes:
    """How ROS 2 knows an entity: the 16 bytes of its RTPS GUID."""
    return bytes(entity.guid.bytes)


class DdsEnd(RosEnd):
    """An endpoint with the entities of Cyclone DDS that it consists of.

    Args:
        name: of its topic or service.
        remove: called when it is closed.
        entities: a writer, a reader, or the reader and writer of a service.
    """

    statuses: ClassVar[tuple[int, ...]]
    """What wakes the transport's thread, for each entity."""

    def __init__(self, name: str, remove: Remove, *entities: Any) -> None:
        super().__init__(name, remove)
        self.entities = entities
        self.gids = tuple(map(gid_of, entities))

    def refresh(self) -> None:
        """Look which peers are there."""

    def drain(self) -> bool:
        """Deliver some of what has arrived; false when there was nothing."""
        return False

    def _send(self, writer: Any, data: bytes) -> None:
        """Send one message; one that a reader blocks for longer than 100 ms is dropped and counted.

        Raises:
            TransportError: it is no message of the type, or the endpoint is closed.
        """
        code = cyclone.write(writer, data)
        if code == cyclone.TIMEOUT:
            self.dropped += 1
        elif code < 0:
            raise self.not_sent(data, cyclone.reason(code))


class DdsWriter(DdsEnd):
    """A DDS writer."""

    statuses = (DDSStatus.PublicationMatched,)

    def __init__(self, name: str, remove: Remove, entity: Any) -> None:
        super().__init__(name, remove, entity)
        self.matched = 0
        self.entity = entity
        self._lock = threading.Lock()

    def write(self, data: bytes) -> None:
        """Send one message; one that a reader blocks for longer than 100 ms is dropped and counted.

        Raises:
            TransportError: it is no message of the topic's type, or the writer is closed.
        """
        self._send(self.entity, data + bytes(-len(data) & 3) if len(data) & 3 else data)

    def refresh(self) -> None:
        """Update the number of readers."""
        # Two threads that look must not note down what they saw in the wrong order.
        with self._lock:
            try:
                self.matched = self.entity.get_publication_matched_status().current_count
            except DDSException:
                self.matched = 0

    def end(self) -> None:
        """Have no readers."""
        with self._lock:
            self.matched = 0


class DdsReader(DdsEnd):
    """A DDS reader.

    Args:
        name: of its topic.
        remove: called when it is closed.
        entity: of Cyclone DDS.
        agrees: whether the type hash of a writer is that of the type here.
        deliver: called with each message.
    """

    statuses = (DDSStatus.DataAvailable,)

    def __init__(self, name: str, remove: Remove, entity: Any, agrees: Callable[[str], bool], deliver: Deliver) -> None:
        super().__init__(name, remove, entity)
        self.source = b""
        """GID of the writer of the message that is being delivered; empty when it is gone already."""
        self.entity = entity
        self._agrees = agrees
        self._deliver = deliver
        self._writers: dict[int, tuple[bytes, bool]] = {}
        """GID of each writer by its handle, and whether its messages can be read."""

    def drain(self) -> bool:
        """Deliver some of what has arrived; false when there was nothing."""
        arrived = cyclone.take(self.entity)
        for data, handle in arrived:
            if handle not in self._writers:
                writer = cyclone.writer_of(self.entity, handle)
                self._writers[handle] = writer.gid, self._agrees(writer.type_hash)
            self.source, readable = self._writers[handle]
            if readable:
                self.hand_over(self._deliver, data)
            else:
                self.malformed += 1
        return bool(arrived)
