"""Service servers and clients over DDS, as in rmw_cyclonedds_cpp: each service has a request topic and a response topic.

All clients of a service read all responses; so requests and responses have a header that identifies the call. The DDS writer
and reader of a client announce the same identity in their user data. If a request arrives before the server has discovered
the client's reader, the server holds the response until it discovers a reader with the identity of the request's writer.
"""

from __future__ import annotations

import re
import struct
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

from cyclonedds.core import DDSException, DDSStatus

from graphengine.ros.network_graph import another_definition
from graphengine.ros.transport import DeliverRequest, DeliverResponse
from graphengine.ros.transports import vendors
from graphengine.ros.transports.calls import Calls
from graphengine.ros.transports.dds import cyclone
from graphengine.ros.transports.dds.dds_endpoints import DdsEnd
from graphengine.ros.transports.ends import Remove

_ENCAPSULATION = 4
"""Size of the CDR encapsulation header, bytes; the second byte of the header gives the byte order."""
_HEADER = {0: struct.Struct(">Qq"), 1: struct.Struct("<Qq")}
"""Format of a call's header for each byte order: the client's handle of its writer, then the number of the call."""
_REQUEST_ID = struct.Struct("<QqQ")
"""Format of a request's identity: the call's header, then the server's handle of the client's writer."""
_MAX_HELD = 1000
"""Maximum number of responses that a server holds until the client's reader is matched."""
_IDENTITY = re.compile(rb"(?:clientid|serviceid)=([^;]*)")


def identity(participant: bytes, number: int) -> str:
    """Return the identity of a participant's client or server with this number, in the format of rmw_cyclonedds_cpp."""
    first, *rest = participant[:12] + number.to_bytes(4, "big")
    return ".".join([f"{first:2x}", *(f"{byte:x}" for byte in rest)])


def with_header(data: bytes, client: int, number: int) -> bytes:
    """Return a CDR message with a call's header, padded to a multiple of 4 bytes; malformed data are returned unchanged."""
    order = _HEADER.get(data[1]) if len(data) > _ENCAPSULATION else None
    if order is None:
        return data
    header = order.pack(client, number)
    return b"".join((data[:_ENCAPSULATION], header, data[_ENCAPSULATION:], bytes(-len(data) & 3)))


def without_header(data: bytes) -> tuple[int, int, bytes] | None:
    """Return the client's handle, the number of the call, and the CDR message; None if `data` is malformed."""
    order = _HEADER.get(data[1]) if len(data) > _ENCAPSULATION + 16 else None
    if order is None:
        return None
    client, number = order.unpack_from(data, _ENCAPSULATION)
    return client, number, data[:_ENCAPSULATION] + data[_ENCAPSULATION + order.size :]


class Pair(NamedTuple):
    """The DDS reader and writer of a service server or client.

    Args:
        reader: reader of requests (server) or responses (client).
        writer: writer of responses (server) or requests (client).
        service_type: as in `std_srvs/srv/Trigger`.
        reads: returns whether the type hash of a peer's writer fits the reader.
        writes: returns whether the type hash of a peer's reader fits the writer.
    """

    reader: Any
    writer: Any
    service_type: str
    reads: Callable[[str], bool]
    writes: Callable[[str], bool]


class _DdsService(DdsEnd):
    """A service server or client, and its matched peers."""

    statuses = (DDSStatus.DataAvailable | DDSStatus.SubscriptionMatched, DDSStatus.PublicationMatched)

    def __init__(self, name: str, remove: Remove, pair: Pair) -> None:
        super().__init__(name, remove, pair.reader, pair.writer)
        self._pair = pair
        self._ended = False
        self._lock = threading.RLock()
        self._writers: dict[int, cyclone.Peer] = {}
        self._readers: dict[int, cyclone.Peer] = {}
        self._vendors: set[bytes] = set()
        """RTPS vendor ids of peers on other DDS implementations: the first two bytes of the peers' GIDs."""
        self._mistyped = False
        """Whether any peer had a different definition of the service type until now."""

    def close(self) -> None:
        """Close the endpoint; safe to call twice."""
        self.end()
        super().close()

    def end(self) -> None:
        """Refuse all later calls, and forget the peers."""
        with self._lock:
            self._ended = True
            self._writers, self._readers = {}, {}
            self._follow()

    def drain(self) -> bool:
        """Deliver some messages from the queue; return False if the queue was empty."""
        arrived = cyclone.take(self._pair.reader)
        for data, handle in arrived:
            call = without_header(data)
            if call is None or self._is_foreign(handle):
                self.malformed += 1
                continue
            self.hand_over(self._receive, handle, *call)
        return bool(arrived)

    def refresh(self) -> None:
        """Read the matched peers from Cyclone DDS if the peers have changed."""
        # The lock keeps two threads from storing the peers in the wrong order.
        with self._lock:
            if self._ended:
                return
            try:
                # First the statuses, because reading resets them: a peer that comes later wakes the thread again.
                reader, writer = self._pair.reader, self._pair.writer
                statuses = reader.get_subscription_matched_status(), writer.get_publication_matched_status()
                if any(status.total_count_change or status.current_count_change for status in statuses):
                    self._writers, self._readers = cyclone.writers_of(reader), cyclone.readers_of(writer)
            except DDSException:
                self._writers, self._readers = {}, {}
            except IndexError:
                return  # a peer came while the package counted the peers; this peer wakes the thread again
            peers = (*self._writers.values(), *self._readers.values())
            self._vendors |= {peer.gid[:2] for peer in peers} - {vendors.CYCLONE}
            agree = [self._pair.reads(peer.type_hash) for peer in self._writers.values()]
            agree += [self._pair.writes(peer.type_hash) for peer in self._readers.values()]
            self._mistyped |= not all(agree)
            self._follow()

    def warning(self) -> str:
        """Return a warning about incompatible peers; empty if there are none."""
        with self._lock:
            foreign = vendors.warning(self.name, self.peer, self._vendors, vendors.CYCLONE_RMW)
            another = another_definition(self.name, f"a {self.peer}", self._pair.service_type, "this run")
            return foreign or ("\n  ".join(another) if self._mistyped else "")

    def _is_foreign(self, handle: int) -> bool:
        """Return whether a matched writer has another DDS implementation or another definition of the type."""
        if handle not in self._writers:
            self.refresh()
        peer = self._writers.get(handle)
        return peer is not None and not _talks(peer, self._pair.reads)

    def _admit(self) -> None:
        if self._ended:
            raise self.closed()

    def _receive(self, handle: int, client: int, number: int, data: bytes) -> None:
        """Deliver a request or a response.

        Args:
            handle: handle of the message's writer in this process.
            client: handle of the client's writer in the client's process.
            number: number of the call.
            data: CDR message without the header.
        """
        raise NotImplementedError

    def _follow(self) -> None:
        """Send held responses (server), or update `ready` (client); called when the matched peers may have changed."""
        raise NotImplementedError


class DdsServer(_DdsService):
    """A service server over DDS; clients on rmw_cyclonedds_cpp can call it."""

    peer = "client"

    def __init__(self, name: str, remove: Remove, pair: Pair, deliver: DeliverRequest) -> None:
        super().__init__(name, remove, pair)
        self._deliver = deliver
        self._held: deque[tuple[int, bytes]] = deque(maxlen=_MAX_HELD)
        """Responses held until the client's reader is matched, each with the server's handle of the client's writer."""

    def answer(self, request_id: bytes, response: bytes) -> None:
        """Send a response, at once or as soon as the client's reader is matched.

        Raises:
            TransportError: the server is closed, or the bytes are not a message of the service's type.
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
        """Return whether a client's reader is matched; `handle` is the server's handle of the client's writer."""
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
    """A service client over DDS; it can call servers on rmw_cyclonedds_cpp."""

    peer = "server"

    def __init__(self, name: str, remove: Remove, pair: Pair, deliver: DeliverResponse) -> None:
        super().__init__(name, remove, pair)
        self.ready = False
        self._handle = cyclone.unsigned(pair.writer.get_instance_handle())
        self._deliver = deliver
        self._calls = Calls()

    def call(self, request: bytes) -> int:
        """Send a request; return the number of the call.

        Raises:
            TransportError: the client is closed, or the bytes are not a message of the service's type.
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
    """Return whether a peer has the same DDS implementation and the same definition of the type."""
    return peer.gid.startswith(vendors.CYCLONE) and agrees(peer.type_hash)


def _identity(peer: cyclone.Peer) -> bytes:
    """Return the identity that a peer's reader and writer share; empty if the peer's old ROS 2 version announces none."""
    found = _IDENTITY.search(peer.user_data)
    return found[1] if found else b""
