"""Endpoints of a session: a tick begins with what has arrived at them, and ends with sending what was said."""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar

from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import EndpointClaim, Network, Sink
from graphengine.ros.endpoint_handover import Handover, HeldEndpoint
from graphengine.ros.qos_diagnostics import Watch
from graphengine.ros.service_endpoints import LiveClient, LiveServer
from graphengine.ros.topic_endpoints import LivePublisher, LiveSubscription
from graphengine.ros.transport import Transport

E = TypeVar("E", bound=HeldEndpoint)

LOOK_EVERY = 30
"""Ticks after which subscriptions with alternatives look again what others publish."""


class LiveNetwork(Network):
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
        """Sinks that receive every message, such as a recorder."""
        self.taps: list[Sink] = []
        self.outbox: list[tuple[Callable[[bytes], None], bytes]] = []
        """What was said in this tick, behind what sends it. All leaves at once: a reader that sleeps is woken once a tick."""
        self.sent = 0
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
        self._handover: Handover | None = None
        self.transport(0)

    def tap(self, sink: Sink) -> None:
        """Add a sink for the messages that are sent and delivered anyway: nodes build no messages for it."""
        self.taps.append(sink)

    def untap(self, sink: Sink) -> None:
        """Remove a sink that `tap` added."""
        self.taps.remove(sink)

    def transport(self, handle: int) -> Transport:
        """The transport of a ROS 2 context's handle."""
        domain = self._domain(handle)
        if domain not in self._transports:
            self._transports[domain] = self._open_domain(domain)
            ends = partial(self._ends, domain)
            self._watches[domain] = Watch(self._transports[domain], ends, self.complain, definitions=self.definitions)
        return self._transports[domain]

    def _domain(self, handle: int) -> int:
        return handle - 1 if handle else self._domain_id

    @contextmanager
    def handing_over(self) -> Iterator[None]:
        """Return a context in which a node that opens an endpoint gets the open endpoint of an equal claim, if there is one."""
        self._handover = Handover([*self.publishers, *self.subscriptions, *self._servers, *self._clients])
        try:
            yield
        finally:
            self._handover = None

    def _end(self, kind: type[E], claim: EndpointClaim, ends: list[E], make: Callable[[], E]) -> E:
        """Return the handed over endpoint of a claim, or a new one."""
        end = self._handover.take(kind, claim) if self._handover is not None else None
        if end is None:
            end = make()
            end.opened_as = claim
            ends.append(end)
        return end

    def publisher(self, claim: EndpointClaim) -> LivePublisher:
        """An endpoint to write to."""

        def make() -> LivePublisher:
            writer = self.transport(claim.ros_context).writer(claim.topic, claim.message_type, claim.qos)
            return LivePublisher(self, claim, writer)

        end = self._end(LivePublisher, claim, self.publishers, make)
        self._watches[self._domain(claim.ros_context)].hurry()
        return end

    def subscription(self, claim: EndpointClaim) -> LiveSubscription:
        """An endpoint to read from."""
        end = self._end(LiveSubscription, claim, self.subscriptions, lambda: LiveSubscription(self, claim))
        self._watches[self._domain(claim.ros_context)].hurry()
        return end

    def server(self, claim: EndpointClaim, handle: int) -> LiveServer:
        """An endpoint that answers."""
        return self._end(LiveServer, claim, self._servers, lambda: LiveServer(self, claim, handle))

    def client(self, claim: EndpointClaim) -> LiveClient:
        """An endpoint that asks."""
        return self._end(LiveClient, claim, self._clients, lambda: LiveClient(self, claim))

    @property
    def hearing(self) -> list[LiveSubscription | LiveServer | LiveClient]:
        """Whoever something can be delivered to, in a fixed order."""
        return [*self.subscriptions, *self._servers, *self._clients]

    def leave(self, end: object) -> None:
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
                for sink in (*self.sinks, *self.taps):
                    sink.deliver(end.claim, arrived)
        self.look()

    def look(self) -> None:
        """Report what keeps the session and its peers apart; for runs that make no ticks too."""
        for watch in self._watches.values():
            watch.look()

    def _ends(self, domain: int) -> Iterator[LivePublisher | LiveSubscription]:
        """The ends in a domain, of those that there are now: the iterator may be used later, and by another thread."""
        ends: list[LivePublisher | LiveSubscription] = [*self.publishers, *self.subscriptions]
        return (end for end in ends if self._is_in(domain, end))

    def _is_in(self, domain: int, end: LivePublisher | LiveSubscription) -> bool:
        return self._domain(end.claim.ros_context) == domain

    def _follow(self) -> None:
        """Let subscriptions with alternatives read the types that are published."""
        for domain, watch in self._watches.items():
            ends = [end for end in self.subscriptions if end.claim.alternatives and self._is_in(domain, end)]
            published = watch.published({end.topic for end in ends}) if ends else {}
            for end in ends:
                end.follow(published.get(end.topic, ()))

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

    def save(self) -> Any:
        """A copy of what has arrived and was not taken, of open calls, and of what transports keep."""
        ends = [(_key(end), end.save()) for end in self.hearing]
        return self._ticks, ends, {domain: transport.save() for domain, transport in self._transports.items()}

    def restore(self, saved: Any) -> None:
        """Go back to what `save` returned, as far as messages have not left this process."""
        self._ticks, ends, transports = saved
        self.outbox.clear()
        known: defaultdict[object, deque[Any]] = defaultdict(deque)
        for key, state in ends:
            known[key].append(state)
        for end in self.hearing:
            if known[_key(end)]:
                end.restore(known[_key(end)].popleft())
        for domain, state in transports.items():
            if domain in self._transports:
                self._transports[domain].restore(state)

    @property
    def subscribers(self) -> int:
        """Number of readers of all topics that nodes publish, recorders excluded."""
        return sum(publisher.subscribers for publisher in self.publishers)

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
            transport.log(severity, message)

    @property
    def description(self) -> str:
        """What carries the messages."""
        return "; ".join(transport.description for transport in self._transports.values())

    def close(self) -> None:
        """Leave every domain."""
        for watch in self._watches.values():
            watch.close()
        for transport in self._transports.values():
            transport.close()
        for kept in (self._transports, self._watches):
            kept.clear()
        for ends in (self.publishers, self.subscriptions, self._servers, self._clients):
            ends.clear()


def _key(end: LiveSubscription | LiveServer | LiveClient) -> object:
    """What an endpoint has in common with the one that its node opens when it is set up again."""
    return type(end), end.claim.node, end.claim.topic
