"""Endpoints of a session over its transports: encode once, hand the same bytes to every sink, freeze what arrives by tick."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any, Protocol

from graphengine.backend import TopicClaim
from graphengine.diagnostics import TransportError
from graphengine.ros import messages
from graphengine.ros.definitions import DEFINITIONS, Definitions
from graphengine.ros.graph import Graph
from graphengine.ros.template import Encoder
from graphengine.ros.transport import Reader, Transport, Writer

MAX_KEPT = 10_000
"""Messages that a keepAll subscription holds between two ticks."""
LOOK_EVERY = 30
"""Ticks after which subscriptions with alternatives look again what others publish."""


class Sink(Protocol):
    """Something that wants every message, such as a recorder."""

    def write(self, claim: TopicClaim, data: bytes) -> None:
        """Take one encoded message that a node published."""

    def deliver(self, claim: TopicClaim, arrived: Sequence[bytes]) -> None:
        """Take what a subscription sees from this tick on."""


class LivePublisher:
    """One topic of one transport, and every sink."""

    __slots__ = ("_encode", "_network", "_writer", "claim", "topic")

    def __init__(self, network: LiveNetwork, claim: TopicClaim, writer: Writer) -> None:
        self.claim = claim
        self.topic = claim.topic
        self._network = network
        self._writer = writer
        self._encode = Encoder(network.definitions).encode

    def close(self) -> None:
        """Leave the topic, once all that was published is sent."""
        self._network.flush()
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
            sink.write(self.claim, data)


class LiveSubscription:
    """One topic of one transport; deliveries wait for the next tick."""

    __slots__ = ("_arrived", "_network", "_reader", "_visible", "claim", "malformed", "skipped", "topic")

    def __init__(self, network: LiveNetwork, claim: TopicClaim) -> None:
        self.claim = claim
        self.topic = claim.topic
        self.skipped = 0
        self.malformed = 0
        self._network = network
        depth = max(claim.qos.depth, 1) if claim.qos.history == "keepLast" else MAX_KEPT
        self._arrived: deque[bytes] = deque(maxlen=depth)
        self._visible: deque[bytes] = deque(maxlen=depth)
        self._reader = self._open()

    def _open(self) -> Reader:
        claim = self.claim
        transport = self._network.transport(claim.ros_context)
        return transport.reader(claim.topic, claim.message_type, claim.qos, self.deliver)

    def close(self) -> None:
        """Leave the topic."""
        self._reader.close()
        if self in self._network.subscriptions:
            self._network.subscriptions.remove(self)

    def follow(self, published: Collection[str]) -> None:
        """Read one of the claim's alternatives where that is published, and what is read is not."""
        types = (self.claim.message_type, *self.claim.alternatives)
        wanted = next((kind for kind in types if kind in published), types[0])
        if wanted != types[0]:
            self._reader.close()
            self._arrived.clear()
            self._visible.clear()
            others = tuple(kind for kind in types if kind != wanted)
            self.claim = replace(self.claim, message_type=wanted, alternatives=others)
            self._reader = self._open()

    def deliver(self, data: bytes) -> None:
        """Take one message from the transport's thread."""
        self._arrived.append(data)

    def freeze(self) -> Sequence[bytes]:
        """Begin a tick; what has arrived since the last one. Only appends run at the same time, and a full queue's drops."""
        arrived: list[bytes] = []
        for _ in range(len(self._arrived)):
            try:
                arrived.append(self._arrived.popleft())
            except IndexError:
                break
        self._visible.extend(arrived)
        return arrived

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
            return messages.decode(data, self.claim.message_type, self._network.definitions)
        except TransportError as error:
            self.malformed += 1
            if self.malformed == 1:
                self._network.complain(
                    f"{self.topic}: a peer sends what is not {self.claim.message_type}; dropped ({error})"
                )
            return None


class LiveNetwork:
    """The session's endpoints; one transport a ROS 2 domain, opened when first asked for.

    Args:
        open_domain: joins a domain.
        domain_id: the session's own, which handle 0 means.
        complain: told once about a peer that sends rubbish.
        definitions: message types.
    """

    def __init__(
        self,
        open_domain: Callable[[int], Transport],
        domain_id: int,
        complain: Callable[[str], None],
        definitions: Definitions = DEFINITIONS,
    ) -> None:
        self.definitions = definitions
        self.sinks: list[Sink] = []
        self.outbox: list[tuple[LivePublisher, bytes]] = []
        """What was published in this tick. Sent in one go: a reader that sleeps is woken once a tick, not once a message."""
        self.sent = 0
        """Messages sent since the start."""
        self._open_domain = open_domain
        self._domain_id = domain_id
        self.complain = complain
        self._ticks = 0
        self._transports: dict[int, Transport] = {}
        self.subscriptions: list[LiveSubscription] = []
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
        return LivePublisher(self, claim, writer)

    def subscription(self, claim: TopicClaim) -> LiveSubscription:
        """An endpoint to read from."""
        made = LiveSubscription(self, claim)
        self.subscriptions.append(made)
        return made

    def freeze(self) -> None:
        """Begin a tick."""
        if self._ticks % LOOK_EVERY == 0:
            self._follow()
        self._ticks += 1
        for subscription in self.subscriptions:
            arrived = subscription.freeze()
            if arrived:
                for sink in self.sinks:
                    sink.deliver(subscription.claim, arrived)

    def _follow(self) -> None:
        """Look which types are published where a subscription has alternatives."""
        graphs: dict[int, Graph] = {}
        for subscription in self.subscriptions:
            claim = subscription.claim
            if claim.alternatives:
                if claim.ros_context not in graphs:
                    graphs[claim.ros_context] = self.transport(claim.ros_context).graph()
                publishers = graphs[claim.ros_context].publishers(claim.topic)
                subscription.follow({publisher.message_type for publisher in publishers})

    def flush(self) -> None:
        """End a tick: send what was published, in order."""
        leaving, self.outbox = self.outbox, []
        for publisher, data in leaving:
            publisher.send(data)
        self.sent += len(leaving)

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
        self.subscriptions.clear()
