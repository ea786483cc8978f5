"""Services over DDS, done as rmw_cyclonedds_cpp does them: a topic for requests, one for answers, and a header in both.

The header tells whose call it is, as every client of a service reads every answer. What belongs together, such as a client's
writer of requests and its reader of answers, has the same identity in its user data: a request may be here before the reader is
that its answer is for.
"""

from __future__ import annotations

import re
import struct
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

from cyclonedds.core import DDSException, DDSStatus

from graphengine.messages.definitions import another_definition
from graphengine.ros.transport import DeliverRequest, DeliverResponse
from graphengine.ros.transports import vendors
from graphengine.ros.transports.calls import Calls
from graphengine.ros.transports.dds import cyclone
from graphengine.ros.transports.dds.dds_endpoints import DdsEnd
from graphengine.ros.transports.ends import Remove

_ENCAPSULATION = 4
"""Bytes before every CDR message, of which the second tells the byte order."""
_HEADER = {0: struct.Struct(">Qq"), 1: struct.Struct("<Qq")}
"""By byte order: handle of the client's writer, as the client's process has it, and number of the call."""
_REQUEST_ID = struct.Struct("<QqQ")
"""A request's header, and the handle of the client's writer as this process has it."""
_MAX_HELD = 1000
"""Answers that wait for their readers."""
_IDENTITY = re.compile(rb"(?:clientid|serviceid)=([^;]*)")


def identity(participant: bytes, number: int) -> str:
    """What rmw_cyclonedds_cpp calls the n-th client or server of a participant."""
    first, *rest = participant[:12] + number.to_bytes(4, "big")
    return ".".join([f"{first:2x}", *(f"{byte:x}" for byte in rest)])


def with_header(data: bytes, client: int, number: int) -> bytes:
    """A CDR message as it goes over the wire, padded to a multiple of 4 bytes; what is none stays as it is, and is refused."""
    order = _HEADER.get(data[1]) if len(data) > _ENCAPSULATION else None
    if order is None:
        return data
    header = order.pack(client, number)
    return b"".join((data[:_ENCAPSULATION], header, data[_ENCAPSULATION:], bytes(-len(data) & 3)))


def without_header(data: bytes) -> tuple[int, int, bytes] | None:
    """Client and number of a call, and the CDR message; None where there is no message behind a header."""
    order = _HEADER.get(data[1]) if len(data) > _ENCAPSULATION + 16 else None
    if order is None:
        return None
    client, number = order.unpack_from(data, _ENCAPSULATION)
    return client, number, data[:_ENCAPSULATION] + data[_ENCAPSULATION + order.size :]


class Pair(NamedTuple):
    """The endpoints of a server or client.

    Args:
        reader: of requests or answers.
        writer: of the others.
        service_type: as in `std_srvs/srv/Trigger`.
        reads: whether the type hash of a peer's writer is that of the reader's type.
        writes: whether the type hash of a peer's reader is that of the writer's type.
    """

    reader: Any
    writer: Any
    service_type: str
    reads: Callable[[str], bool]
    writes: Callable[[str], bool]


class _DdsService(DdsEnd):
    """A server or client: a reader, a writer, and peers that come and go."""

    statuses = (DDSStatus.DataAvailable | DDSStatus.SubscriptionMatched, DDSStatus.PublicationMatched)

    def __init__(self, name: str, remove: Remove, pair: Pair) -> None:
        super().__init__(name, remove, pair.reader, pair.writer)
        self._pair = pair
        self._ended = False
        self._lock = threading.RLock()
        self._writers: dict[int, cyclone.Peer] = {}
        self._readers: dict[int, cyclone.Peer] = {}
        self._vendors: set[bytes] = set()
        """How GIDs of peers on other implementations of DDS began."""
        self._mistyped = False
        """Whether a peer had another definition of the service's type."""

    def close(self) -> None:
        """Leave the service; a second time does nothing."""
        self.end()
        super().close()

    def end(self) -> None:
        """Send nothing from here on."""
        with self._lock:
            self._ended = True
            self._writers, self._readers = {}, {}
            self._follow()

    def drain(self) -> bool:
        """Deliver some of what has arrived; false when there was nothing."""
        arrived = cyclone.take(self._pair.reader)
        for data, handle in arrived:
            call = without_header(data)
            if call is None or self._is_foreign(handle):
                self.malformed += 1
                continue
            self.hand_over(self._receive, handle, *call)
        return bool(arrived)

    def refresh(self) -> None:
        """Look which peers are there."""
        # Two threads that look must not note down what they saw in the wrong order.
        with self._lock:
            if self._ended:
                return
            try:
                # First the statuses, which are reset thereby: who comes after that wakes the thread again.
                reader, writer = self._pair.reader, self._pair.writer
                statuses = reader.get_subscription_matched_status(), writer.get_publication_matched_status()
                if any(status.total_count_change or status.current_count_change for status in statuses):
                    self._writers, self._readers = cyclone.writers_of(reader), cyclone.readers_of(writer)
            except DDSException:
                self._writers, self._readers = {}, {}
            except IndexError:
                return  # one came between two looks of the package at how many there are; the thread is woken for it
            peers = (*self._writers.values(), *self._readers.values())
            self._vendors |= {peer.gid[:2] for peer in peers} - {vendors.CYCLONE}
            agree = [self._pair.reads(peer.type_hash) for peer in self._writers.values()]
            agree += [self._pair.writes(peer.type_hash) for peer in self._readers.values()]
            self._mistyped |= not all(agree)
            self._follow()

    def warning(self) -> str:
        """What to tell people about peers that cannot be talked to; empty where there were none."""
        with self._lock:
            foreign = vendors.warning(self.name, self.peer, self._vendors, vendors.CYCLONE_RMW)
            another = another_definition(self.name, f"a {self.peer}", self._pair.service_type, "this run")
            return foreign or ("\n  ".join(another) if self._mistyped else "")

    def _is_foreign(self, handle: int) -> bool:
        """Whether a writer sends what cannot be read: another header, or none, or another definition."""
        if handle not in self._writers:
            self.refresh()
        peer = self._writers.get(handle)
        return peer is not None and not _talks(peer, self._pair.reads)

    def _admit(self) -> None:
        if self._ended:
            raise self.closed()

    def _receive(self, handle: int, client: int, number: int, data: bytes) -> None:
        """Take a message from one of the writers."""
        raise NotImplementedError

    def _follow(self) -> None:
        """Draw conclusions from the peers that are there."""
        raise NotImplementedError


class DdsServer(_DdsService):
    """A service that is offered over DDS."""

    peer = "client"

    def __init__(self, name: str, remove: Remove, pair: Pair, deliver: DeliverRequest) -> None:
        super().__init__(name, remove, pair)
        self._deliver = deliver
        self._held: deque[tuple[int, bytes]] = deque(maxlen=_MAX_HELD)
        """Answers that wait for the reader that they are for, each with the handle of the client's writer."""

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Send an answer; where the client's reader is not there yet, as soon as it comes.

        Raises:
            TransportError: the server is closed, or it is no message of the service's type.
        """
        self._admit()
        if len(request_id) != _REQUEST_ID.size:
            return
        client, number, handle = _REQUEST_ID.unpack(request_id)
        data = with_header(response, client, number)
        with self._lock:
            if not self._hears(handle):
                self.refresh()
            if self._hears(handle):
                self._send(self._pair.writer, data)
            elif handle in self._writers:
                self._held.append((handle, data))

    def _hears(self, handle: int) -> bool:
        """Whether the reader is there that belongs to a client's writer."""
        if handle not in self._writers:
            return False
        client = _identity(self._writers[handle])
        return not client or any(_identity(peer) == client for peer in self._readers.values())

    def _receive(self, handle: int, client: int, number: int, data: bytes) -> None:
        self._deliver(_REQUEST_ID.pack(client, number, handle), data)

    def _follow(self) -> None:
        for _ in range(len(self._held)):
            handle, data = self._held.popleft()
            if self._hears(handle):
                self.dropped += cyclone.write(self._pair.writer, data) < 0
            elif handle in self._writers:
                self._held.append((handle, data))


class DdsClient(_DdsService):
    """A service that is called over DDS."""

    peer = "server"

    def __init__(self, name: str, remove: Remove, pair: Pair, deliver: DeliverResponse) -> None:
        super().__init__(name, remove, pair)
        self.ready = False
        self._handle = cyclone.unsigned(pair.writer.get_instance_handle())
        self._deliver = deliver
        self._calls = Calls()

    def call(self, request: bytes) -> int:
        """Send a request, and return its number.

        Raises:
            TransportError: the client is closed, or it is no message of the service's type.
        """
        self._admit()
        number = self._calls.begin()
        self._send(self._pair.writer, with_header(request, self._handle, number))
        return number

    def _receive(self, handle: int, client: int, number: int, data: bytes) -> None:
        if client == self._handle and self._calls.end(number):
            self._deliver(number, data)

    def _follow(self) -> None:
        hearing, answering = (
            {_identity(peer) for peer in peers.values() if _talks(peer, agrees)}
            for peers, agrees in ((self._readers, self._pair.writes), (self._writers, self._pair.reads))
        )
        self.ready = not hearing.isdisjoint(answering)


def _talks(peer: cyclone.Peer, agrees: Callable[[str], bool]) -> bool:
    """Whether messages cross to or from a peer: it is on the same DDS, and has the same definition of them."""
    return peer.gid.startswith(vendors.CYCLONE) and agrees(peer.type_hash)


def _identity(peer: cyclone.Peer) -> bytes:
    """What a peer's reader and writer have in common; empty for those of early versions, which do not tell."""
    found = _IDENTITY.search(peer.user_data)
    return found[1] if found else b""
