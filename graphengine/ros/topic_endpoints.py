"""Publishers and subscriptions of a session; they deliver messages at the beginning of a tick and send messages at its end."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any

from graphengine.format.errors import TransportError
from graphengine.format.stateful import Shared, Stateful
from graphengine.messages import messages
from graphengine.messages.endpoints import EndpointClaim, Publisher, Subscription
from graphengine.messages.message_template import Encoder
from graphengine.ros.endpoint_base import EndpointHost, HeldEndpoint
from graphengine.ros.transport import Reader, Writer

MAX_KEPT = 10_000
"""Maximum number of messages that a subscription with the history keepAll holds between two ticks."""


class LivePublisher(HeldEndpoint, Publisher, Shared):
    """A publisher on a transport; it also copies its messages to the session's sinks and taps."""

    def __init__(self, network: EndpointHost, claim: EndpointClaim) -> None:
        super().__init__(claim)
        self.largest = 0
        self._newest = b""
        self._network = network
        self._end: Writer = network.transport(claim.ros_context).writer(claim.topic, claim.message_type, claim.qos)
        self._encode = Encoder(network.definitions).encode

    def close(self) -> None:
        """Send the pending messages of the session, then release the publisher."""
        self._network.flush()
        super().close()

    @property
    def wanted(self) -> bool:
        """Whether messages have a receiver: a matched reader, a sink, or, on a latched topic, a reader that may join later."""
        latched = self.claim.qos.durability == "transientLocal"
        return latched or self._end.matched > 0 or bool(self._network.sinks)

    @property
    def subscribers(self) -> int:
        """Number of matched readers; recorders do not count."""
        return self._end.matched

    @property
    def dropped(self) -> int:
        """Number of messages dropped because a reader was too slow."""
        return self._end.dropped

    def publish(self, message: Any) -> None:
        """Encode a message and queue it; the tick's end sends it to the transport, sinks and taps."""
        data = self._encode(message)
        if self.topic in self._network.faults.acting:
            self._post_faultily(data)
        else:
            self._network.outbox.append((self.send, data))
        if self.claim.transforms:
            self.latest = message

    def publish_late(self) -> None:
        """Queue the messages that a fault has delayed until this tick."""
        if self.topic in self._network.faults.acting:
            self._post_faultily()

    def _post_faultily(self, *encoded: bytes) -> None:
        """Queue new and delayed messages for the end of the tick, without those that a fault of the topic loses or delays."""
        passed = self._network.faults.passing(self.topic, f"publish {self.claim.node}", encoded)
        self._network.outbox += [(self.send, data) for data in passed]

    def send(self, data: bytes) -> None:
        """Send an encoded message to the transport, sinks and taps."""
        self._end.write(data)
        self._newest = data
        if len(data) > self.largest:
            self.largest = len(data)
        for sink in self._network.sinks:
            sink.write(self.claim, data)
        for tap in self._network.taps:
            tap.write(self.claim, data)

    def repeat(self) -> None:
        """Send the newest message to the transport again, but not to sinks and taps."""
        if self._newest:
            self._end.write(self._newest)


class LiveSubscription(HeldEndpoint, Subscription, Stateful):
    """A subscription on a transport; received messages wait for the next tick."""

    kept = ("_arrived", "_frozen", "_visible", "heard", "malformed", "skipped")

    def __init__(self, network: EndpointHost, claim: EndpointClaim) -> None:
        super().__init__(claim)
        self.largest = 0
        self.heard = 0
        """Number of received messages; only the thread that delivers messages changes it."""
        self.malformed = 0
        self._frozen = 0
        """Number of received messages that nodes could read, plus those discarded when the subscription changed its type."""
        self._network = network
        depth = max(claim.qos.depth, 1) if claim.qos.history == "keepLast" else MAX_KEPT
        self._arrived: deque[bytes] = deque(maxlen=MAX_KEPT if claim.topic in network.quotas else depth)
        self._visible: deque[bytes] = deque(maxlen=depth)
        self._end: Reader = self._open()

    def _open(self) -> Reader:
        claim = self.claim
        transport = self._network.transport(claim.ros_context)
        return transport.reader(claim.topic, claim.message_type, claim.qos, self.deliver)

    @property
    def overwritten(self) -> int:
        """Number of received messages that newer messages replaced in the full queue before nodes could read them."""
        return self.heard - self._frozen - len(self._arrived)

    @property
    def waiting(self) -> int:
        """Number of received messages that wait for a tick."""
        return len(self._arrived)

    def follow(self, published: Collection[str]) -> None:
        """Switch to an alternative type if `published` contains it but not the current type."""
        types = (self.claim.message_type, *self.claim.alternatives)
        wanted = next((kind for kind in types if kind in published), types[0])
        if wanted != types[0]:
            self._end.close()
            self._frozen += len(self._arrived)
            self._arrived.clear()
            self._visible.clear()
            others = tuple(kind for kind in types if kind != wanted)
            self.claim = replace(self.claim, message_type=wanted, alternatives=others)
            self._end = self._open()

    def deliver(self, data: bytes) -> None:
        """Queue a message; called in the transport's thread."""
        self._arrived.append(data)
        self.heard += 1

    def freeze(self) -> Sequence[bytes]:
        """Begin a tick: make new messages available to nodes, and return them; another thread may call `deliver` meanwhile.

        The result also has the messages that a fault of the topic loses or delays for nodes: a recording contains all messages.
        """
        faults, topic = self._network.faults, self.topic
        faulty = topic in faults.acting and all(publisher.topic != topic for publisher in self._network.publishers)
        if not self._arrived and not faulty:
            return ()
        count = min(self.waiting, self._network.quotas.get(topic, MAX_KEPT))
        arrived = [self._arrived.popleft() for _ in range(count)]
        passed = faults.passing(topic, f"subscribe {self.claim.node}", arrived) if faulty else arrived
        overflow = len(self._visible) + len(passed)
        self._visible.extend(passed)
        self._frozen += len(arrived) - (overflow - len(self._visible))
        return arrived

    def newest(self) -> Any | None:
        """Return the newest decodable message, or None. Older messages are discarded and count as skipped."""
        while self._visible:
            message = self._decode(self._visible.pop())
            if message is not None:
                self.skipped += len(self._visible)
                self._visible.clear()
                return message
        return None

    def take(self) -> Sequence[Any]:
        """Return all waiting messages, oldest first, and remove them."""
        taken = [message for data in self._visible if (message := self._decode(data)) is not None]
        self._visible.clear()
        return taken

    def _decode(self, data: bytes) -> Any | None:
        try:
            return messages.decode(data, self.claim.message_type, self._network.definitions)
        except TransportError as error:
            self.malformed += 1
            self._network.undecoded[self.topic] += 1
            if self.malformed == 1:
                what = f"a peer sends malformed {self.claim.message_type} messages"
                self._network.complain(f"{self.topic}: {what}; they are dropped ({error})")
            return None
