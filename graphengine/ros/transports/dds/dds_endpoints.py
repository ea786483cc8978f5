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
    """Return the 16 bytes of an entity's RTPS GUID, by which ROS 2 identifies the entity."""
    return bytes(entity.guid.bytes)


class DdsEnd(RosEnd):
    """An endpoint that owns Cyclone DDS entities.

    Args:
        name: name of the topic or service.
        remove: called when the endpoint is closed.
        entities: one writer, one reader, or the reader and writer of a service.
    """

    statuses: ClassVar[tuple[int, ...]]
    """DDS statuses that wake the transport's thread, one mask for each entity."""

    def __init__(self, name: str, remove: Remove, *entities: Any) -> None:
        super().__init__(name, remove)
        self.entities = entities
        self.gids = tuple(map(gid_of, entities))

    def refresh(self) -> None:
        """Read the matched peers from Cyclone DDS; called when the peers may have changed."""

    def drain(self) -> bool:
        """Deliver some messages from the queue; return False if the queue was empty."""
        return False

    def _send(self, writer: Any, data: bytes) -> None:
        """Send a message; if a reader blocks for longer than 100 ms, the message is dropped and counted.

        Raises:
            TransportError: the bytes are not a message of the type, or the endpoint is closed.
        """
        code = cyclone.write(writer, data)
        if code == cyclone.TIMEOUT:
            self.dropped += 1
        elif code < 0:
            raise self.not_sent(data, cyclone.reason(code))


class DdsWriter(DdsEnd):
    """A writer with a DDS writer; counts the matched readers, and the messages dropped because of slow readers."""

    statuses = (DDSStatus.PublicationMatched,)

    def __init__(self, name: str, remove: Remove, entity: Any) -> None:
        super().__init__(name, remove, entity)
        self.matched = 0
        self.entity = entity
        self._lock = threading.Lock()

    def write(self, data: bytes) -> None:
        """Send a message; if a reader blocks for longer than 100 ms, the message is dropped and counted.

        Raises:
            TransportError: the bytes are not a message of the topic's type, or the writer is closed.
        """
        self._send(self.entity, data + bytes(-len(data) & 3) if len(data) & 3 else data)

    def refresh(self) -> None:
        """Read the number of matched readers from Cyclone DDS."""
        # The lock keeps two threads from storing their counts in the wrong order.
        with self._lock:
            try:
                self.matched = self.entity.get_publication_matched_status().current_count
            except DDSException:
                self.matched = 0

    def end(self) -> None:
        """Set the number of readers to 0."""
        with self._lock:
            self.matched = 0


class DdsReader(DdsEnd):
    """A reader with a DDS reader.

    Args:
        name: name of the topic.
        remove: called when the reader is closed.
        entity: Cyclone DDS reader.
        agrees: returns whether a writer with this type hash has the reader's definition of the type.
        deliver: called with each message.
    """

    statuses = (DDSStatus.DataAvailable,)

    def __init__(self, name: str, remove: Remove, entity: Any, agrees: Callable[[str], bool], deliver: Deliver) -> None:
        super().__init__(name, remove, entity)
        self.source = b""
        """GID of the writer whose message is being delivered; empty if the writer is gone."""
        self.entity = entity
        self._agrees = agrees
        self._deliver = deliver
        self._writers: dict[int, tuple[bytes, bool]] = {}
        """For each writer, by handle: the GID, and whether the writer's messages can be read."""

    def drain(self) -> bool:
        """Deliver some messages from the queue; return False if the queue was empty."""
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
