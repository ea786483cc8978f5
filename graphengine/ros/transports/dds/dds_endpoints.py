"""Writers and readers of the DDS transport."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from cyclonedds.core import DDSException

from graphengine.format.errors import TransportError
from graphengine.ros.transports.dds import cyclone
from graphengine.ros.transports.handing_over import HandingOver


def gid_of(entity: Any) -> bytes:
    """How ROS 2 knows an entity: the 16 bytes of its RTPS GUID."""
    return bytes(entity.guid.bytes)


class DdsWriter:
    """A DDS writer.

    Args:
        topic: absolute.
        entity: of Cyclone DDS.
        remove: called when it is closed.
    """

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


@dataclass(eq=False, slots=True)
class DdsReader:
    """A DDS reader.

    Args:
        topic: absolute.
        entity: of Cyclone DDS.
        agrees: whether the type hash of a writer is that of the type here.
        deliver: called with each message.
        remove: called when the reader is closed.
        malformed: messages dropped because their writers have another definition of the topic's type.
        source: GID of the writer of the message that is being delivered; empty when it is gone already.
    """

    topic: str
    entity: Any
    agrees: Callable[[str], bool]
    deliver: Callable[[bytes], None]
    remove: Callable[[DdsReader], None]
    malformed: int = 0
    source: bytes = b""
    gid: bytes = field(init=False)
    _hand_over: HandingOver = field(init=False)
    _writers: dict[int, tuple[bytes, bool]] = field(default_factory=dict)
    """GID of each writer by its handle, and whether its messages can be read."""

    def __post_init__(self) -> None:
        self.gid = gid_of(self.entity)
        self._hand_over = HandingOver(self.topic)

    def drain(self) -> bool:
        """Deliver some of what has arrived; false when there was nothing."""
        arrived = cyclone.take(self.entity)
        for data, handle in arrived:
            if handle not in self._writers:
                writer = cyclone.writer_of(self.entity, handle)
                self._writers[handle] = writer.gid, self.agrees(writer.type_hash)
            self.source, readable = self._writers[handle]
            if readable:
                self._hand_over(self.deliver, data)
            else:
                self.malformed += 1
        return bool(arrived)

    def close(self) -> None:
        """Leave the topic; a second time does nothing."""
        self.remove(self)
