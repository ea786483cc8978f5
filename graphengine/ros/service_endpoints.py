"""Service servers and clients of a session; they deliver messages at the beginning of a tick and send messages at its end.

Sinks receive calls as ROS 2 service introspection events: messages of type `…_Event` on `<service>/_service_event`, as rosbag2
records them. The stamps of the events are zero. A server takes `client_gid` and `sequence_number` from the transport. A client
computes both from the node's prim path and the number of the call, so that equal runs give equal bytes.
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np

from graphengine.format.errors import TransportError
from graphengine.format.stateful import Stateful
from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim, ServiceClient, ServiceEndpoint, ServiceServer
from graphengine.ros.endpoint_base import EndpointHost, HeldEndpoint

EVENTS = "/_service_event"
"""Suffix that turns a service's name into the topic of its introspection events."""
MAX_OPEN = 1000
"""Maximum number of unanswered requests of a server, or calls of a client; a larger QoS depth raises this limit."""
PATIENCE = 300
"""Number of ticks that calls wait for a server before the user is warned."""
GID, IDENTITY = 16, 24
"""Size of a `client_gid`, and size of a call's identity (`client_gid`, then `sequence_number`), bytes."""

# Of service_msgs/msg/ServiceEventInfo.
_REQUEST_SENT, _REQUEST_RECEIVED, _RESPONSE_SENT, _RESPONSE_RECEIVED = range(4)


class _Endpoint(HeldEndpoint, Stateful, ServiceEndpoint):
    """Base class of server and client. `claim` describes the topic of the introspection events, not the service itself."""

    def _begin(self, network: EndpointHost, claim: EndpointClaim, hears: str, says: str) -> None:
        self.claim = replace(claim, topic=f"{claim.topic}{EVENTS}", message_type=f"{claim.message_type}_Event")
        self._network = network
        self._hears, self._says = (f"{claim.message_type}_{part}" for part in (hears, says))
        self._told: set[str] = set()
        self._most = max(MAX_OPEN, claim.qos.depth)

    def close(self) -> None:
        """Send the pending messages of the session, then release the endpoint."""
        self._network.flush()
        super().close()

    def follow(self, published: Collection[str]) -> None:
        """Do nothing, because a service has only one type."""

    def _tell(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            self._network.complain(f"{self.service}: {text}")

    def _encode(self, message: Any) -> bytes:
        """Encode an outgoing message.

        Raises:
            MessageError: the message is not of the type that this endpoint sends.
        """
        if messages.message_type(message) != self._says:
            raise messages.MessageError(f"{self.service} takes {self._says}, not {messages.message_type(message)}")
        return messages.encode(message, self._network.definitions)

    def _decode(self, data: bytes) -> Any | None:
        """Return the decoded incoming message; count a malformed message and return None."""
        try:
            return messages.decode(data, self._hears, self._network.definitions)
        except TransportError:
            self._network.undecoded[self.service] += 1
            self._tell(f"a peer sends malformed {self._hears} messages; they are dropped")
            return None

    def _event(self, kind: int, identity: bytes, part: Literal["request", "response"], message: Any) -> bytes:
        event = self._network.definitions.initial(self.claim.message_type)
        event.info.event_type = kind
        event.info.client_gid = np.frombuffer(identity[:GID], np.uint8)
        event.info.sequence_number = int.from_bytes(identity[GID:], "big", signed=True)
        getattr(event, part).append(message)
        return messages.encode(event, self._network.definitions)

    def _show(self, kind: int, identity: bytes, part: Literal["request", "response"], data: bytes) -> None:
        """Send the introspection event of an outgoing message to the sinks."""
        if self._network.sinks:
            message = messages.decode(data, self._says, self._network.definitions)
            event = self._event(kind, identity, part, message)
            for sink in self._network.sinks:
                sink.write(self.claim, event)

    def _recorded(self, event: bytes, part: Literal["request", "response"]) -> tuple[bytes, bytes] | None:
        """Return the identity of a recorded event's call, and its encoded request or response; None if the event lacks `part`."""
        try:
            found = messages.decode(event, self.claim.message_type, self._network.definitions)
            heard = messages.encode(getattr(found, part)[0], self._network.definitions)
        except (TransportError, IndexError):
            return None
        number = int(found.info.sequence_number).to_bytes(IDENTITY - GID, "big", signed=True)
        return bytes(found.info.client_gid) + number, heard


class LiveServer(_Endpoint, ServiceServer):
    """A service server on a transport."""

    kept = ("_arrived", "_open", "_refused", "_visible", "current")

    def __init__(self, network: EndpointHost, claim: EndpointClaim, handle: int) -> None:
        super().__init__(claim, handle)
        self._begin(network, claim, "Request", "Response")
        self._refused = 0
        self._arrived: deque[tuple[bytes, bytes]] = deque()
        self._visible: deque[tuple[bytes, Any]] = deque()
        self._open: dict[bytes, None] = {}
        """Identities of requests that nodes have read and not answered yet."""
        transport = network.transport(claim.ros_context)
        self._end = transport.server(claim.topic, claim.message_type, claim.qos, self._receive)

    def _receive(self, request_id: bytes, data: bytes) -> None:
        """Queue a request, or refuse it if the queue is full; called in the transport's thread."""
        if len(self._arrived) < self._most:
            self._arrived.append((request_id, data))
        else:
            self._refused += 1

    def deliver(self, event: bytes) -> None:
        """Queue the request of a recorded event."""
        if recorded := self._recorded(event, "request"):
            self._receive(*recorded)

    def freeze(self) -> Sequence[bytes]:
        """Begin a tick: make new requests available to nodes. With sinks, return the requests as events."""
        events: list[bytes] = []
        for _ in range(len(self._arrived)):
            request_id, data = self._arrived.popleft()
            if len(self._visible) >= self._most:
                self._refused += 1
            elif (request := self._decode(data)) is not None:
                self._visible.append((request_id, request))
                if self._network.sinks:
                    events.append(self._event(_REQUEST_RECEIVED, _identity(request_id), "request", request))
        if self._refused:
            self._tell(f"more than {self._most} requests are waiting for the graph; further requests are not answered")
        return events

    def take(self) -> Sequence[tuple[bytes, Any]]:
        """Return the waiting requests, oldest first, and remove them."""
        taken = tuple(self._visible)
        self._visible.clear()
        self._open |= dict.fromkeys(request_id for request_id, _ in taken)
        while len(self._open) > self._most:
            del self._open[next(iter(self._open))]
        return taken

    def answer(self, request_id: bytes, response: Any) -> None:
        """Send a response at the end of the tick; do nothing if the request is already answered or discarded.

        Raises:
            MessageError: the message is not a response of the service.
        """
        data = self._encode(response)
        if request_id in self._open:
            del self._open[request_id]
            self._network.outbox.append((partial(self._send, request_id), data))
        if self.current == request_id:
            self.current = None

    def _send(self, request_id: bytes, data: bytes) -> None:
        self._end.answer(request_id, data)
        self._show(_RESPONSE_SENT, _identity(request_id), "response", data)

    def forget_calls(self) -> None:
        """Discard the requests that nodes can see or have read; these requests get no response."""
        self.current = None
        self._open.clear()
        self._visible.clear()


class LiveClient(_Endpoint, ServiceClient):
    """A service client on a transport. While no server exists, the client keeps the latest calls, up to the QoS depth."""

    kept = ("_arrived", "_calls", "_from_recording", "_numbers", "_open", "_patience", "_visible", "_waiting")

    def __init__(self, network: EndpointHost, claim: EndpointClaim) -> None:
        super().__init__(claim)
        self._begin(network, claim, "Response", "Request")
        self._gid = hashlib.blake2b(claim.node.encode(), digest_size=GID).digest()
        self._patience = 0
        self._open: dict[int, None] = {}
        """Numbers of calls that have no response yet."""
        self._numbers: dict[int, int] = {}
        """This client's number of each sent call, by the transport's number of the call."""
        self._arrived: deque[tuple[int, bytes]] = deque()
        self._from_recording: deque[tuple[int, bytes]] = deque()
        self._visible: deque[tuple[int, Any]] = deque()
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._keeps = max(claim.qos.depth, 1) if claim.qos.history == "keepLast" else MAX_OPEN
        transport = network.transport(claim.ros_context)
        self._end = transport.client(claim.topic, claim.message_type, claim.qos, self._receive)

    def _receive(self, number: int, data: bytes) -> None:
        """Queue a response; called in the transport's thread."""
        self._arrived.append((number, data))

    def deliver(self, event: bytes) -> None:
        """Queue the response of a recorded event."""
        if recorded := self._recorded(event, "response"):
            identity, data = recorded
            self._from_recording.append((int.from_bytes(identity[GID:], "big"), data))

    def freeze(self) -> Sequence[bytes]:
        """Begin a tick: make new responses available to nodes. With sinks, return the responses as events."""
        events: list[bytes] = []
        arrived, self._from_recording = self._from_recording, deque()
        for _ in range(len(self._arrived)):
            sent, data = self._arrived.popleft()
            arrived.append((self._numbers.pop(sent, 0), data))
        for number, data in arrived:
            if number not in self._open:
                continue
            del self._open[number]
            if (response := self._decode(data)) is not None:
                self._visible.append((number, response))
                if self._network.sinks:
                    events.append(self._event(_RESPONSE_RECEIVED, self._identity(number), "response", response))
        return events

    def take(self) -> Sequence[tuple[int, Any]]:
        """Return the waiting responses in order of arrival, and remove them."""
        taken = tuple(self._visible)
        self._visible.clear()
        return taken

    def call(self, request: Any) -> int:
        """Queue a request and return the number of the call; the tick's end sends it, or a later tick once a server exists.

        Raises:
            MessageError: the message is not a request of the service.
        """
        data = self._encode(request)
        self._calls += 1
        self._open[self._calls] = None
        if len(self._open) > self._most:
            del self._open[next(iter(self._open))]
            self._tell(f"more than {self._most} calls have no response; the oldest are discarded")
        self._network.outbox.append((partial(self._send, self._calls), data))
        return self._calls

    def _send(self, number: int, data: bytes) -> None:
        self._waiting.append((number, data))
        self._send_waiting()
        if len(self._waiting) > self._keeps:
            self._open.pop(self._waiting.popleft()[0], None)
        self._show(_REQUEST_SENT, self._identity(number), "request", data)

    def _send_waiting(self) -> None:
        """Send the waiting calls if a server exists."""
        while self._waiting and self._end.ready:
            number, data = self._waiting.popleft()
            self._numbers[self._end.call(data)] = number
            if len(self._numbers) > self._most:
                del self._numbers[next(iter(self._numbers))]

    def end_tick(self) -> None:
        """Send the waiting calls if a server exists; warn when calls have waited for `PATIENCE` ticks."""
        self._send_waiting()
        self._patience = self._patience + 1 if self._waiting else 0
        if self._patience == PATIENCE:
            what = f"no server offers this service with the type {self.service_type}"
            self._tell(f"{what}; the last {self._keeps} calls wait for a server")

    def forget_calls(self) -> None:
        """Discard all open calls; the numbers of calls restart at 1."""
        self._calls = 0
        for kept in (self._open, self._numbers, self._visible, self._waiting):
            kept.clear()

    def _identity(self, number: int) -> bytes:
        return self._gid + number.to_bytes(IDENTITY - GID, "big")


def _identity(request_id: bytes) -> bytes:
    """Return a call's identity of `IDENTITY` bytes for an event: the transport's identity if it has this size, else a hash."""
    return request_id if len(request_id) == IDENTITY else hashlib.blake2b(request_id, digest_size=IDENTITY).digest()
