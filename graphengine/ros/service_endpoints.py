"""Servers and clients of a session over its transports: what arrives is frozen by tick, what is said leaves when a tick ends.

Sinks see both as ROS 2's service introspection tells of a service: messages of the type `…_Event` on the topic
`<service>/_service_event`, which recordings of rosbag2 hold too. Their stamps are zero. The identity of a call, `client_gid` and
`sequence_number`, is the transport's at a server; at a client it is made of the node's prim path and the number of the call, so
that the same run says the same bytes.
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from graphengine.format.errors import TransportError
from graphengine.format.stateful import Stateful
from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim, ServiceClient, ServiceEndpoint, ServiceServer
from graphengine.ros.endpoint_handover import HeldEndpoint

if TYPE_CHECKING:
    from graphengine.ros.network import LiveNetwork

EVENTS = "/_service_event"
"""What follows a service's name in the topic of its events."""
MAX_OPEN = 1000
"""Requests that wait for a server's graph, or calls that wait for an answer; more where the queue is longer."""
PATIENCE = 300
"""Ticks for which calls wait for a server before that is told."""
GID, IDENTITY = 16, 24
"""Bytes of `client_gid`, and of the whole identity of a call."""

# Of service_msgs/msg/ServiceEventInfo.
_REQUEST_SENT, _REQUEST_RECEIVED, _RESPONSE_SENT, _RESPONSE_RECEIVED = range(4)


class _Endpoint(HeldEndpoint, Stateful, ServiceEndpoint):
    """What a server and a client have in common; its claim is of the topic of its events."""

    _end: Any
    """The server or client of the transport."""

    def _begin(self, network: LiveNetwork, claim: EndpointClaim, hears: str, says: str) -> None:
        self.claim = replace(claim, topic=f"{claim.topic}{EVENTS}", message_type=f"{claim.message_type}_Event")
        self._network = network
        self._hears, self._says = (f"{claim.message_type}_{part}" for part in (hears, says))
        self._told: set[str] = set()
        self._most = max(MAX_OPEN, claim.qos.depth)

    def close(self) -> None:
        """Leave the service, once what was said is sent."""
        self._network.flush()
        if not self.release():
            return
        self._end.close()
        self._network.leave(self)

    def follow(self, published: Collection[str]) -> None:
        """A service has one type."""

    def _tell(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            self._network.complain(f"{self.service}: {text}")

    def _encode(self, message: Any) -> bytes:
        """The bytes of what is to be said.

        Raises:
            MessageError: it is no message of the service.
        """
        if messages.message_type(message) != self._says:
            raise messages.MessageError(f"{self.service} takes {self._says}, not {messages.message_type(message)}")
        return messages.encode(message, self._network.definitions)

    def _decode(self, data: bytes) -> Any | None:
        """What was heard; None for what is no such message."""
        try:
            return messages.decode(data, self._hears, self._network.definitions)
        except TransportError:
            self._network.undecoded[self.service] += 1
            self._tell(f"a peer sends what is not {self._hears}; dropped")
            return None

    def _event(self, kind: int, identity: bytes, part: Literal["request", "response"], message: Any) -> bytes:
        event = self._network.definitions.initial(self.claim.message_type)
        event.info.event_type = kind
        event.info.client_gid = np.frombuffer(identity[:GID], np.uint8)
        event.info.sequence_number = int.from_bytes(identity[GID:], "big", signed=True)
        getattr(event, part).append(message)
        return messages.encode(event, self._network.definitions)

    def _show(self, kind: int, identity: bytes, part: Literal["request", "response"], data: bytes) -> None:
        """Let sinks see what was said."""
        if self._network.sinks:
            message = messages.decode(data, self._says, self._network.definitions)
            event = self._event(kind, identity, part, message)
            for sink in self._network.sinks:
                sink.write(self.claim, event)

    def _recorded(self, event: bytes, part: Literal["request", "response"]) -> tuple[bytes, bytes] | None:
        """The identity and the bytes of what an event tells of; None where it tells of something else."""
        try:
            found = messages.decode(event, self.claim.message_type, self._network.definitions)
            heard = messages.encode(getattr(found, part)[0], self._network.definitions)
        except (TransportError, IndexError):
            return None
        number = int(found.info.sequence_number).to_bytes(IDENTITY - GID, "big", signed=True)
        return bytes(found.info.client_gid) + number, heard


class LiveServer(_Endpoint, ServiceServer):
    """One service of one transport that is offered."""

    kept = ("_arrived", "_open", "_refused", "_visible", "current")

    def __init__(self, network: LiveNetwork, claim: EndpointClaim, handle: int) -> None:
        super().__init__(claim, handle)
        self._begin(network, claim, "Request", "Response")
        self._refused = 0
        self._arrived: deque[tuple[bytes, bytes]] = deque()
        self._visible: deque[tuple[bytes, Any]] = deque()
        self._open: dict[bytes, None] = {}
        """Requests that were taken and not answered."""
        transport = network.transport(claim.ros_context)
        self._end = transport.server(claim.topic, claim.message_type, claim.qos, self._receive)

    def _receive(self, request_id: bytes, data: bytes) -> None:
        """Take one request from the transport's thread."""
        if len(self._arrived) < self._most:
            self._arrived.append((request_id, data))
        else:
            self._refused += 1

    def deliver(self, event: bytes) -> None:
        """Take one request from a recording."""
        if recorded := self._recorded(event, "request"):
            self._receive(*recorded)

    def freeze(self) -> Sequence[bytes]:
        """Begin a tick; requests since the last one, as events."""
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
            self._tell(f"more than {self._most} requests wait for the graph; those beyond are not answered")
        return events

    def take(self) -> Sequence[tuple[bytes, Any]]:
        """Requests that were not taken before, oldest first."""
        taken = tuple(self._visible)
        self._visible.clear()
        self._open |= dict.fromkeys(request_id for request_id, _ in taken)
        while len(self._open) > self._most:
            del self._open[next(iter(self._open))]
        return taken

    def answer(self, request_id: bytes, response: Any) -> None:
        """Answer when the tick ends; a second answer, or one to a request that was forgotten, is none.

        Raises:
            MessageError: it is no response of the service.
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
        """Requests that graphs have seen are not answered."""
        self.current = None
        self._open.clear()
        self._visible.clear()


class LiveClient(_Endpoint, ServiceClient):
    """One service of one transport that is called. As many calls as the QoS keeps wait for a server to come."""

    kept = ("_arrived", "_calls", "_from_recording", "_numbers", "_open", "_patience", "_visible", "_waiting")

    def __init__(self, network: LiveNetwork, claim: EndpointClaim) -> None:
        super().__init__(claim)
        self._begin(network, claim, "Response", "Request")
        self._gid = hashlib.blake2b(claim.node.encode(), digest_size=GID).digest()
        self._patience = 0
        self._open: dict[int, None] = {}
        """Calls that were made and not answered."""
        self._numbers: dict[int, int] = {}
        """Calls that were sent, by the transport's numbers."""
        self._arrived: deque[tuple[int, bytes]] = deque()
        self._from_recording: deque[tuple[int, bytes]] = deque()
        self._visible: deque[tuple[int, Any]] = deque()
        self._waiting: deque[tuple[int, bytes]] = deque()
        self._keeps = max(claim.qos.depth, 1) if claim.qos.history == "keepLast" else MAX_OPEN
        transport = network.transport(claim.ros_context)
        self._end = transport.client(claim.topic, claim.message_type, claim.qos, self._receive)

    def _receive(self, number: int, data: bytes) -> None:
        """Take one answer from the transport's thread."""
        self._arrived.append((number, data))

    def deliver(self, event: bytes) -> None:
        """Take one answer from a recording."""
        if recorded := self._recorded(event, "response"):
            identity, data = recorded
            self._from_recording.append((int.from_bytes(identity[GID:], "big"), data))

    def freeze(self) -> Sequence[bytes]:
        """Begin a tick; answers since the last one, as events."""
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
        """Answers that were not taken before, in the order in which they came."""
        taken = tuple(self._visible)
        self._visible.clear()
        return taken

    def call(self, request: Any) -> int:
        """Ask when the tick ends, or as soon as a server is there.

        Raises:
            MessageError: it is no request of the service.
        """
        data = self._encode(request)
        self._calls += 1
        self._open[self._calls] = None
        if len(self._open) > self._most:
            del self._open[next(iter(self._open))]
            self._tell(f"more than {self._most} calls were not answered; the oldest are given up")
        self._network.outbox.append((partial(self._send, self._calls), data))
        return self._calls

    def _send(self, number: int, data: bytes) -> None:
        self._waiting.append((number, data))
        self._send_waiting()
        if len(self._waiting) > self._keeps:
            self._open.pop(self._waiting.popleft()[0], None)
        self._show(_REQUEST_SENT, self._identity(number), "request", data)

    def _send_waiting(self) -> None:
        """Send what waits, if a server is there."""
        while self._waiting and self._end.ready:
            number, data = self._waiting.popleft()
            self._numbers[self._end.call(data)] = number
            if len(self._numbers) > self._most:
                del self._numbers[next(iter(self._numbers))]

    def end_tick(self) -> None:
        """Look once more for a server; tell when none has come for long."""
        self._send_waiting()
        self._patience = self._patience + 1 if self._waiting else 0
        if self._patience == PATIENCE:
            self._tell(f"nobody offers it as {self.service_type}; the last {self._keeps} calls wait for a server")

    def forget_calls(self) -> None:
        """Nothing that was asked is waited for; calls are counted from 1."""
        self._calls = 0
        for kept in (self._open, self._numbers, self._visible, self._waiting):
            kept.clear()

    def _identity(self, number: int) -> bytes:
        return self._gid + number.to_bytes(IDENTITY - GID, "big")


def _identity(request_id: bytes) -> bytes:
    """A transport's identity of a request in the size that events have."""
    return request_id if len(request_id) == IDENTITY else hashlib.blake2b(request_id, digest_size=IDENTITY).digest()
