"""Endpoints of a session over its transports: encode once, hand the same bytes to every sink, freeze what arrives by tick."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from graphengine.backend import TopicClaim
from graphengine.diagnostics import TransportError
from graphengine.ros import messages
from graphengine.ros.template import Encoder
from graphengine.ros.transport import Transport, Writer

MAX_KEPT = 10_000
"""Messages that a keepAll subscription holds between two ticks."""


class Sink(Protocol):
    """Something that wants every published message, such as a recorder."""

    def write(self, topic: str, message_type: str, data: bytes) -> None:
        """Take one encoded message."""


class LivePublisher:
    """One topic of one transport, and every sink."""

    __slots__ = ("_encode", "_message_type", "_network", "_writer", "topic")

    def __init__(self, network: LiveNetwork, topic: str, message_type: str, writer: Writer) -> None:
        self.topic = topic
        self._message_type = message_type
        self._network = network
        self._writer = writer
        self._encode = Encoder().encode

    def close(self) -> None:
        """Leave the topic."""
        self._writer.close()

    @property
    def wanted(self) -> bool:
        """Whether a reader is there, or a sink."""
        return self._writer.matched or bool(self._network.sinks)

    def publish(self, message: Any) -> None:
        """Encode once; the bytes go to every sink when the tick ends."""
        self._network.outbox.append((self, self._encode(message)))

    def send(self, data: bytes) -> None:
        """Hand bytes to the transport and to every sink."""
        self._writer.write(data)
        for sink in self._network.sinks:
            sink.write(self.topic, self._message_type, data)


class LiveSubscription:
    """One topic of one transport; deliveries wait for the next tick."""

    __slots__ = ("_arrived", "_close", "_complain", "_message_type", "_visible", "malformed", "skipped", "topic")

    def __init__(self, topic: str, message_type: str, depth: int, complain: Callable[[str], None]) -> None:
        self.topic = topic
        self.skipped = 0
        self.malformed = 0
        self._close: Callable[[], None] = lambda: None
        self._message_type = message_type
        self._complain = complain
        self._arrived: deque[bytes] = deque(maxlen=depth)
        self._visible: deque[bytes] = deque(maxlen=depth)

    def on_close(self, close: Callable[[], None]) -> None:
        """What leaves the topic; known only when the reader is there that delivers here."""
        self._close = close

    def close(self) -> None:
        """Leave the topic."""
        self._close()

    def deliver(self, data: bytes) -> None:
        """Take one message from the transport's thread."""
        self._arrived.append(data)

    def freeze(self) -> None:
        """Begin a tick. Only appends run at the same time, and a full queue that drops its oldest."""
        for _ in range(len(self._arrived)):
            try:
                self._visible.append(self._arrived.popleft())
            except IndexError:
                break

    def newest(self) -> Any | None:
        """The newest message that can be decoded; older ones count as skipped."""
        while self._visible:
            message = self._decode(self._visible.pop())
            if message is not None:
                self.skipped += len(self._visible)
                self._visible.clear()
                return message
        return None

    def take(self) -> Sequence[Any]:
        """All messages, oldest first."""
        taken = [message for data in self._visible if (message := self._decode(data)) is not None]
        self._visible.clear()
        return taken

    def _decode(self, data: bytes) -> Any | None:
        try:
            return messages.decode(data, self._message_type)
        except TransportError as error:
            self.malformed += 1
            if self.malformed == 1:
                self._complain(f"{self.topic}: a peer sends what is not {self._message_type}; dropped ({error})")
            return None


class LiveNetwork:
    """The session's endpoints; one transport a ROS 2 domain, opened when first asked for.

    Args:
        open_domain: joins a domain.
        domain_id: the session's own, which handle 0 means.
        complain: told once about a peer that sends rubbish.
    """

    def __init__(
        self, open_domain: Callable[[int], Transport], domain_id: int, complain: Callable[[str], None]
    ) -> None:
        self.sinks: list[Sink] = []
        self.outbox: list[tuple[LivePublisher, bytes]] = []
        """What was published in this tick. Sent in one go: a reader that sleeps is woken once a tick, not once a message."""
        self.sent = 0
        """Messages sent since the start."""
        self._open_domain = open_domain
        self._domain_id = domain_id
        self._complain = complain
        self._transports: dict[int, Transport] = {}
        self._subscriptions: list[LiveSubscription] = []
        self.transport(0)

    def transport(self, handle: int) -> Transport:
        """The transport of a ROS 2 context's handle."""
        domain = handle - 1 if handle else self._domain_id
        if domain not in self._transports:
            self._transports[domain] = self._open_domain(domain)
        return self._transports[domain]

    def publisher(self, claim: TopicClaim) -> LivePublisher:
        """An endpoint to write to."""
        writer = self.transport(claim.ros_context).writer(claim.topic, claim.message_type, claim.qos)
        return LivePublisher(self, claim.topic, claim.message_type, writer)

    def subscription(self, claim: TopicClaim) -> LiveSubscription:
        """An endpoint to read from."""
        depth = max(claim.qos.depth, 1) if claim.qos.history == "keepLast" else MAX_KEPT
        made = LiveSubscription(claim.topic, claim.message_type, depth, self._complain)
        reader = self.transport(claim.ros_context).reader(claim.topic, claim.message_type, claim.qos, made.deliver)
        self._subscriptions.append(made)

        def leave() -> None:
            reader.close()
            if made in self._subscriptions:
                self._subscriptions.remove(made)

        made.on_close(leave)
        return made

    def freeze(self) -> None:
        """Begin a tick."""
        for subscription in self._subscriptions:
            subscription.freeze()

    def flush(self) -> None:
        """End a tick: send what was published, in order."""
        for publisher, data in self.outbox:
            publisher.send(data)
        self.sent += len(self.outbox)
        self.outbox.clear()

    def log(self, severity: str, message: str) -> None:
        """Messages for people go to /rosout where a transport has it."""
        for transport in self._transports.values():
            log = getattr(transport, "log", None)
            if log is not None:
                log(severity, message)

    @property
    def description(self) -> str:
        """What carries the messages."""
        return "; ".join(transport.description for transport in self._transports.values())

    def close(self) -> None:
        """Leave every domain."""
        for transport in self._transports.values():
            transport.close()
        self._transports.clear()
        self._subscriptions.clear()
