"""The network of a session; it delivers messages to nodes at the beginning of a tick and sends messages at the tick's end."""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.messages.endpoints import EndpointClaim, Sink, Supply
from graphengine.ros.endpoint_base import EndpointHost, HeldEndpoint
from graphengine.ros.endpoint_faults import find_publishers
from graphengine.ros.qos_diagnostics import Watch
from graphengine.ros.service_endpoints import LiveClient, LiveServer
from graphengine.ros.topic_endpoints import LivePublisher, LiveSubscription
from graphengine.ros.transport import Complain, Transport

E = TypeVar("E", bound=HeldEndpoint)

LOOK_EVERY = 30
"""Number of ticks between two checks of whether a subscription should switch to one of its alternative types."""


class LiveNetwork(EndpointHost):
    """The endpoints of a session, and one transport for each ROS 2 domain that they use.

    Args:
        open_domain: joins the domain with this id and returns a transport.
        domain_id: domain of the session; endpoints with the context handle 0 use this domain.
        complain: called once with each warning about malformed messages or incompatible peers.
        definitions: message types.
    """

    def __init__(
        self,
        open_domain: Callable[[int], Transport],
        domain_id: int,
        complain: Complain,
        definitions: Definitions = DEFINITIONS,
    ) -> None:
        super().__init__(complain, definitions)
        self.sent = 0
        self.past_drops: Counter[str] = Counter()
        """Number of messages that closed publishers dropped, by topic."""
        self.past_overwritten: Counter[str] = Counter()
        """Number of messages overwritten in subscriptions that are closed now, by topic."""
        self._open_domain = open_domain
        self._domain_id = domain_id
        self._ticks = 0
        self._transports: dict[int, Transport] = {}
        self._watches: dict[int, Watch] = {}
        self.publishers: list[LivePublisher] = []
        self.subscriptions: list[LiveSubscription] = []
        self._servers: list[LiveServer] = []
        self._clients: list[LiveClient] = []
        self._handover: list[HeldEndpoint] = []
        """Within `handing_over`, the open endpoints that no node of the changed graphs has taken over yet."""
        self.identity = self.transport(0).identity

    def tap(self, sink: Sink) -> None:
        """Copy all messages that nodes send or receive to a sink, without making publishers `wanted` as `sinks` do."""
        self.taps.append(sink)

    def untap(self, sink: Sink) -> None:
        """Remove a sink that `tap` added."""
        self.taps.remove(sink)

    def transport(self, handle: int) -> Transport:
        """Return the transport for the handle of a ROS 2 context; join its domain at the first call."""
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
        """Return a context in which a node takes over an open endpoint of an equal claim, instead of creating an endpoint."""
        self._handover = [*self.publishers, *self.subscriptions, *self._servers, *self._clients]
        try:
            yield
        finally:
            self._handover = []

    def _end(self, kind: type[E], claim: EndpointClaim, ends: list[E], make: Callable[[], E]) -> E:
        """Return the endpoint for a claim: within `handing_over` an open endpoint of an equal claim, otherwise a new one."""
        for end in self._handover:
            if isinstance(end, kind) and _essence(end.opened_as) == _essence(claim):
                self._handover.remove(end)
                end.holders += 1
                return end
        made = make()
        made.opened_as = claim
        ends.append(made)
        return made

    def publisher(self, claim: EndpointClaim) -> LivePublisher:
        """Return a publisher for a node's claim: a new one, or within `handing_over` an open publisher of an equal claim."""
        end = self._end(LivePublisher, claim, self.publishers, lambda: LivePublisher(self, claim))
        self._watches[self._domain(claim.ros_context)].hurry()
        return end

    def subscription(self, claim: EndpointClaim) -> LiveSubscription:
        """Return a subscription for a node's claim: a new one, or within `handing_over` an open one of an equal claim."""
        end = self._end(LiveSubscription, claim, self.subscriptions, lambda: LiveSubscription(self, claim))
        self._watches[self._domain(claim.ros_context)].hurry()
        return end

    def server(self, claim: EndpointClaim, handle: int) -> LiveServer:
        """Return a service server for a node's claim, new or handed over; `handle` is that of `Network.server`."""
        return self._end(LiveServer, claim, self._servers, lambda: LiveServer(self, claim, handle))

    def client(self, claim: EndpointClaim) -> LiveClient:
        """Return a service client for a node's claim: a new one, or within `handing_over` an open client of an equal claim."""
        return self._end(LiveClient, claim, self._clients, lambda: LiveClient(self, claim))

    @property
    def hearing(self) -> list[LiveSubscription | LiveServer | LiveClient]:
        """All endpoints that can receive messages: subscriptions, servers, then clients, each in creation order."""
        return [*self.subscriptions, *self._servers, *self._clients]

    def leave(self, end: HeldEndpoint) -> None:
        """Remove a closed endpoint; the messages that the endpoint lost stay counted."""
        if isinstance(end, LivePublisher) and end in self.publishers:
            self.past_drops[end.topic] += end.dropped
            self.publishers.remove(end)
        if isinstance(end, LiveSubscription) and end in self.subscriptions:
            self.past_overwritten[end.topic] += end.overwritten
            self.subscriptions.remove(end)
        self._servers = [server for server in self._servers if server is not end]
        self._clients = [client for client in self._clients if client is not end]

    def freeze(self) -> None:
        """Begin a tick: deliver the messages since the last tick to nodes, sinks and taps, and report incompatible peers."""
        if self._ticks % LOOK_EVERY == 0:
            self._follow()
        self._ticks += 1
        self.faults.begin_tick()
        for end in self.hearing:
            arrived = end.freeze()
            if arrived:
                end.arrival = self._ticks
                for sink in (*self.sinks, *self.taps):
                    sink.deliver(end.claim, arrived)
        self.look()

    def supply(self, claim: EndpointClaim) -> Supply:
        """Return what reaches the subscription that a claim describes; peers are those that are discovered by now."""
        ends = [end for end in self.subscriptions if (end.claim.node, end.topic) == (claim.node, claim.topic)]
        if not ends:
            return Supply()
        end = ends[0]
        own = list(self._ends(self._domain(claim.ros_context)))
        peers = find_publishers(end.claim, own, self.transport(claim.ros_context), self.definitions)
        silence = self._ticks - end.arrival if end.arrival else None
        return replace(peers, messages=end.heard, silence=silence)

    def repeat_clock(self) -> None:
        """Send the newest /clock again without recording it, and look for new peers; called while a tick waits for messages."""
        self._follow()
        self.look()
        for publisher in self.publishers:
            if publisher.claim.message_type == "rosgraph_msgs/msg/Clock":
                publisher.repeat()

    def look(self) -> None:
        """Report the incompatible peers that searches in the background have found; call this also while no ticks run."""
        for watch in self._watches.values():
            watch.look()

    def _ends(self, domain: int) -> Iterator[LivePublisher | LiveSubscription]:
        """Return an iterator over the present publishers and subscriptions in a domain, which another thread may use later."""
        ends: list[LivePublisher | LiveSubscription] = [*self.publishers, *self.subscriptions]
        return (end for end in ends if self._is_in(domain, end))

    def _is_in(self, domain: int, end: LivePublisher | LiveSubscription) -> bool:
        return self._domain(end.claim.ros_context) == domain

    def _follow(self) -> None:
        """Switch each subscription whose current type is not published to an alternative type that is published."""
        for domain, watch in self._watches.items():
            ends = [end for end in self.subscriptions if end.claim.alternatives and self._is_in(domain, end)]
            published = watch.published({end.topic for end in ends}) if ends else {}
            for end in ends:
                end.follow(published.get(end.topic, ()))

    def flush(self) -> None:
        """End a tick: send the published messages in order."""
        for publisher in self.publishers if self.faults.acting else ():
            publisher.publish_late()
        leaving, self.outbox = self.outbox, []
        for send, data in leaving:
            send(data)
        self.sent += len(leaving)
        for client in self._clients:
            client.end_tick()

    def forget_calls(self) -> None:
        """Discard unanswered requests and calls, and end faults; called when graphs restart."""
        self.faults.clear()
        for server in self._servers:
            server.forget_calls()
        for client in self._clients:
            client.forget_calls()

    def save(self) -> Any:
        """Return a copy of the waiting messages, the open calls, the faults, and the state of the transports."""
        ends = [(_key(end), end.save()) for end in self.hearing]
        transports = {domain: transport.save() for domain, transport in self._transports.items()}
        return self._ticks, self.faults.save(), ends, transports

    def restore(self, saved: Any) -> None:
        """Restore the state that `save` returned; messages that were already sent cannot be recalled."""
        self._ticks, faults, ends, transports = saved
        self.faults.restore(faults)
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
        """Number of matched readers of all publishers together; recorders do not count."""
        return sum(publisher.subscribers for publisher in self.publishers)

    @property
    def malformed(self) -> Counter[str]:
        """Number of malformed messages dropped on each topic or service, by name: they do not fit the message type."""
        return +sum((Counter(transport.malformed) for transport in self._transports.values()), self.undecoded)

    @property
    def given_up(self) -> Counter[str]:
        """Number of published messages on each topic that were dropped because a reader was too slow."""
        return +sum((Counter({end.topic: end.dropped}) for end in self.publishers), self.past_drops)

    @property
    def overwritten(self) -> Counter[str]:
        """Number of received messages on each topic that newer messages replaced in a full queue before a tick."""
        return +sum((Counter({end.topic: end.overwritten}) for end in self.subscriptions), self.past_overwritten)

    def log(self, severity: str, message: str) -> None:
        """Publish a log message on /rosout of each open transport; transports without a ROS node ignore it."""
        for transport in self._transports.values():
            transport.log(severity, message)

    @property
    def description(self) -> str:
        """Descriptions of the open transports, separated by semicolons."""
        return "; ".join(transport.description for transport in self._transports.values())

    @property
    def notices(self) -> Sequence[str]:
        """Lines for users about limitations of the open transports that affect endpoints of the session."""
        return [notice for transport in self._transports.values() for notice in transport.notices]

    def close(self) -> None:
        """Close the transports of all ROS 2 domains, and remove all endpoints of the session."""
        for watch in self._watches.values():
            watch.close()
        for transport in self._transports.values():
            transport.close()
        for kept in (self._transports, self._watches):
            kept.clear()
        for ends in (self.publishers, self.subscriptions, self._servers, self._clients):
            ends.clear()


def _essence(claim: EndpointClaim) -> object:
    """Return the fields of a claim that must be equal for a handover: direction, types, node, topic, QoS and context."""
    kinds = claim.direction, claim.message_type, claim.alternatives
    return kinds, claim.node, claim.topic, claim.qos, claim.ros_context


def _key(end: LiveSubscription | LiveServer | LiveClient) -> object:
    """Return the class, node and topic that identify an endpoint in a saved state."""
    return type(end), end.claim.node, end.claim.topic
