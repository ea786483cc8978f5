"""Endpoints of a session over its transports: encode once, hand the same bytes to every sink, freeze what arrives by tick."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Protocol

from graphengine.backend import TopicClaim
from graphengine.diagnostics import TransportError
from graphengine.ros import messages
from graphengine.ros.definitions import DEFINITIONS, Definitions
from graphengine.ros.graph import Direction
from graphengine.ros.service_endpoints import LiveClient, LiveServer
from graphengine.ros.template import Encoder
from graphengine.ros.transport import Reader, Transport, Writer
from graphengine.ros.watch import Watch

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

    __slots__ = ("_encode", "_network", "_writer", "claim", "largest", "topic")

    def __init__(self, network: LiveNetwork, claim: TopicClaim, writer: Writer) -> None:
        self.claim = claim
        self.topic = claim.topic
        self.largest = 0
        self._network = network
        self._writer = writer
        self._encode = Encoder(network.definitions).encode

    def close(self) -> None:
        """Leave the topic, once all that was published is sent."""
        self._network.flush()
        self._network.past_drops[self.topic] += self._writer.dropped
        self._writer.close()
        if self in self._network.publishers:
            self._network.publishers.remove(self)

    @property
    def wanted(self) -> bool:
        """Whether a reader is there, or a sink."""
        return self._writer.matched or bool(self._network.sinks)

    @property
    def dropped(self) -> int:
        """Messages given up because a reader did not keep up."""
        return self._writer.dropped

    def publish(self, message: Any) -> None:
        """Encode once; the bytes go to every sink when the tick ends."""
        self._network.outbox.append((self.send, self._encode(message)))

    def send(self, data: bytes) -> None:
        """Hand bytes to the transport and to every sink."""
        self._writer.write(data)
        if len(data) > self.largest:
            self.largest = len(data)
        for sink in self._network.sinks:
            sink.write(self.claim, data)


class LiveSubscription:
    """One topic of one transport; deliveries wait for the next tick."""

    __slots__ = (
        "_arrived", "_frozen", "_network", "_reader", "_visible",
        "claim", "heard", "largest", "malformed", "skipped", "topic",
    )  # fmt: skip

    def __init__(self, network: LiveNetwork, claim: TopicClaim) -> None:
        self.claim = claim
        self.topic = claim.topic
        self.largest = 0
        self.heard = 0
        """Messages that arrived; only the thread that delivers them counts."""
        self.skipped = 0
        self.malformed = 0
        self._frozen = 0
        """Messages of these that a tick has kept."""
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
            self._network.past_overwritten[self.topic] += self.overwritten
            self._network.subscriptions.remove(self)

    @property
    def overwritten(self) -> int:
        """Messages that newer ones pushed out of a full queue before a node could take them."""
        return self.heard - self._frozen - len(self._arrived)

    def follow(self, published: Collection[str]) -> None:
        """Read one of the claim's alternatives where that is published, and what is read is not."""
        types = (self.claim.message_type, *self.claim.alternatives)
        wanted = next((kind for kind in types if kind in published), types[0])
        if wanted != types[0]:
            self._reader.close()
            self._frozen += len(self._arrived)
            self._arrived.clear()
            self._visible.clear()
            others = tuple(kind for kind in types if kind != wanted)
            self.claim = replace(self.claim, message_type=wanted, alternatives=others)
            self._reader = self._open()

    def deliver(self, data: bytes) -> None:
        """Take one message from the transport's thread."""
        self._arrived.append(data)
        self.heard += 1

    def freeze(self) -> Sequence[bytes]:
        """Begin a tick; what has arrived since the last one. Only appends run at the same time, and a full queue's drops."""
        arrived: list[bytes] = []
        for _ in range(len(self._arrived)):
            try:
                arrived.append(self._arrived.popleft())
            except IndexError:
                break
        before = len(self._visible)
        self._visible.extend(arrived)
        self._frozen += len(self._visible) - before
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
            self._network.undecoded[self.topic] += 1
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
        complain: told once about a peer that sends rubbish, or that does not fit.
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
        self.outbox: list[tuple[Callable[[bytes], None], bytes]] = []
        """What was said in this tick, behind what sends it. All leaves at once: a reader that sleeps is woken once a tick."""
        self.sent = 0
        """Messages sent since the start."""
        self.undecoded: Counter[str] = Counter()
        self.past_drops: Counter[str] = Counter()
        """Messages given up by publishers that are closed."""
        self.past_overwritten: Counter[str] = Counter()
        """Messages overwritten in subscriptions that are closed."""
        self._open_domain = open_domain
        self._domain_id = domain_id
        self.complain = complain
        self._ticks = 0
        self._transports: dict[int, Transport] = {}
        self._watches: dict[int, Watch] = {}
        self.publishers: list[LivePublisher] = []
        self.subscriptions: list[LiveSubscription] = []
        self._servers: list[LiveServer] = []
        self._clients: list[LiveClient] = []
        self.transport(0)

    def transport(self, handle: int) -> Transport:
        """The transport of a ROS 2 context's handle."""
        domain = self._domain(handle)
        if domain not in self._transports:
            self._transports[domain] = self._open_domain(domain)
            self._watches[domain] = Watch(self._transports[domain], self.complain)
        return self._transports[domain]

    def _domain(self, handle: int) -> int:
        return handle - 1 if handle else self._domain_id

    def publisher(self, claim: TopicClaim) -> LivePublisher:
        """An endpoint to write to."""
        writer = self.transport(claim.ros_context).writer(claim.topic, claim.message_type, claim.qos)
        made = LivePublisher(self, claim, writer)
        self.publishers.append(made)
        self._watches[self._domain(claim.ros_context)].hurry()
        return made

    def subscription(self, claim: TopicClaim) -> LiveSubscription:
        """An endpoint to read from."""
        made = LiveSubscription(self, claim)
        self.subscriptions.append(made)
        self._watches[self._domain(claim.ros_context)].hurry()
        return made

    def server(self, claim: TopicClaim, handle: int) -> LiveServer:
        """An endpoint that answers."""
        made = LiveServer(self, claim, handle)
        self._servers.append(made)
        return made

    def client(self, claim: TopicClaim) -> LiveClient:
        """An endpoint that asks."""
        made = LiveClient(self, claim)
        self._clients.append(made)
        return made

    @property
    def hearing(self) -> list[LiveSubscription | LiveServer | LiveClient]:
        """Whoever something can be delivered to, in a fixed order."""
        return [*self.subscriptions, *self._servers, *self._clients]

    def leave(self, end: LiveServer | LiveClient) -> None:
        """Let go of a server or client that was closed."""
        self._servers = [server for server in self._servers if server is not end]
        self._clients = [client for client in self._clients if client is not end]

    def freeze(self) -> None:
        """Begin a tick."""
        if self._ticks % LOOK_EVERY == 0:
            self._follow()
        self._ticks += 1
        for end in self.hearing:
            arrived = end.freeze()
            if arrived:
                for sink in self.sinks:
                    sink.deliver(end.claim, arrived)
        for domain, watch in self._watches.items():
            watch.look(partial(self._ends, domain))

    def _ends(self, domain: int) -> list[LivePublisher | LiveSubscription]:
        ends: list[LivePublisher | LiveSubscription] = [*self.publishers, *self.subscriptions]
        return [end for end in ends if self._domain(end.claim.ros_context) == domain]

    def _follow(self) -> None:
        """Look which types are published where a subscription has alternatives."""
        choosing = [subscription for subscription in self.subscriptions if subscription.claim.alternatives]
        topics: dict[int, set[tuple[str, Direction]]] = {}
        for subscription in choosing:
            topics.setdefault(subscription.claim.ros_context, set()).add((subscription.topic, "publish"))
        graphs = {handle: self.transport(handle).graph(asked) for handle, asked in topics.items()}
        for subscription in choosing:
            publishers = graphs[subscription.claim.ros_context].publishers(subscription.topic)
            subscription.follow({publisher.message_type for publisher in publishers})

    def flush(self) -> None:
        """End a tick: send what was published, in order."""
        leaving, self.outbox = self.outbox, []
        for send, data in leaving:
            send(data)
        self.sent += len(leaving)
        for client in self._clients:
            client.end_tick()

    def forget_calls(self) -> None:
        """Graphs begin anew."""
        for server in self._servers:
            server.forget_calls()
        for client in self._clients:
            client.forget_calls()

    @property
    def malformed(self) -> Counter[str]:
        """By topic, how many messages were dropped that are none of its type."""
        return +sum((Counter(transport.malformed) for transport in self._transports.values()), self.undecoded)

    @property
    def given_up(self) -> Counter[str]:
        """By topic, how many messages were not sent because a reader did not keep up."""
        return +sum((Counter({end.topic: end.dropped}) for end in self.publishers), self.past_drops)

    @property
    def overwritten(self) -> Counter[str]:
        """By topic, how many messages came faster than ticks took them and so found no place."""
        return +sum((Counter({end.topic: end.overwritten}) for end in self.subscriptions), self.past_overwritten)

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
        self._watches.clear()
        self.publishers.clear()
        self.subscriptions.clear()
        self._servers.clear()
        self._clients.clear()
