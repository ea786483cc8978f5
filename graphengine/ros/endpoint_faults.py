"""Finds faults between a session's endpoints and their peers: incompatible types, incompatible QoS, lost messages.

Without these reports, a user notices only that messages do not arrive. Equal endpoints of a topic are compared once.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from typing import Any, Protocol, TypeAlias

from graphengine.messages.definitions import Definitions
from graphengine.messages.endpoints import EndpointClaim, QoS, Supply
from graphengine.messages.qos import mismatch, policy_json, short_of
from graphengine.ros.network_graph import PATIENCE, Direction, Endpoint, NetworkGraph, another_definition
from graphengine.ros.transport import Transport
from graphengine.ros.transports.vendors import CYCLONE, FAST_DDS

CLOCK = "rosgraph_msgs/msg/Clock"
MOST = 20
"""Maximum number of faults to report per topic; a last report says that there are more."""
ROOM = 0.85
"""Fraction of a receive buffer that one message may fill; the kernel needs the rest for its own data about each packet.

Measured from Cyclone DDS to Fast DDS on one machine: a receive buffer of 212992 bytes, 60 messages of each size at 30 Hz.
All 60 messages of up to 190 kB arrive. With reliable endpoints, 22 messages of 210 kB arrive, 20 of 300 kB, and 14 to 18 of
922 kB. With best-effort endpoints, 6 messages of 300 kB arrive and 2 of 922 kB.
"""
AMPLE = 4194304
"""Receive buffer size with which all messages of the measurement for `ROOM` arrive, bytes."""

_OTHER: Mapping[str, Direction] = {"publish": "subscribe", "subscribe": "publish"}

UNNAMED = "a program that is not a ROS node"
"""Name of a peer without a node in reports."""

Fault: TypeAlias = tuple[str, str]
"""Description of a fault, and its remedy; the remedy may be empty."""
_Form: TypeAlias = tuple[str, QoS, str]
"""Message type, QoS and type hash of a peer, which determine whether the peer matches."""


class End(Protocol):
    """A publisher or subscription of the session."""

    claim: EndpointClaim
    largest: int
    """Size of the largest sent message, bytes."""


class Finder:
    """Finds faults between a session's endpoints and their peers. Used by one thread at a time.

    Args:
        transport: transport that discovers the peers.
        definitions: message types of the session.
        buffer: size of a peer's receive buffer in the kernel, bytes; 0 if unknown.
    """

    def __init__(self, transport: Transport, definitions: Definitions, buffer: int) -> None:
        self._transport = transport
        self._definitions = definitions
        self._buffer = buffer
        self._reported: defaultdict[str, set[str]] = defaultdict(set)
        """Faults that `look` has already returned, by topic."""
        self._nameless: dict[bytes, float] = {}
        """For each peer whose node is unknown, by GID: the time at which the peer was first seen, s."""
        self._unread: dict[str, float] = {}
        """For each topic with foreign publishers and no subscriber: the time since then, s; infinite after a report."""
        self._mistyped: set[str] = set()
        """Subscribed topics on which a peer defines the message type in another way than the session."""
        self.published: Mapping[str, Set[str]] = {}
        """Published types of each topic that subscriptions with alternative types read, as of the last `look`."""

    def look(self, ends: Iterable[End], now: float) -> list[str]:
        """Return the texts of new faults, in the order of the session's endpoints; no text is returned twice.

        Args:
            ends: publishers and subscriptions of the session.
            now: current time, s.
        """
        ends = list(ends)
        asked = {(end.claim.topic, _OTHER[end.claim.direction]) for end in ends}
        asked |= {(end.claim.topic, "publish") for end in ends if _is_clock(end) or self._is_large(end)}
        reads = [end.claim for end in ends if end.claim.direction == "subscribe"]
        graph = self._transport.graph(asked | set(_shorter_names(reads)))
        choosing = {end.claim.topic for end in ends if end.claim.alternatives}
        self.published = published_types(graph, choosing)
        nameless = {peer.gid for where in asked for peer in graph.ends(*where) if not peer.node}
        self._nameless = {gid: self._nameless.get(gid, now) for gid in nameless}
        known = NetworkGraph(peer for peer in graph.endpoints if self._is_known(peer, now))
        comparison = _Comparison(ends, known, self._transport.node, self._definitions)
        found = [text for end in ends for text in self._new(end.claim.topic, self._faults(end, comparison), MOST)]
        self._mistyped |= comparison.mistyped
        found += self._strays(ends, reads, graph, now)
        return [*found, *self._new("", self._dropped(), math.inf)]

    def _new(self, topic: str, faults: Iterable[Fault], most: float) -> Iterator[str]:
        """Yield the texts of faults not reported before: up to `most` for each topic, then one note that there are more."""
        reported = self._reported[topic]
        for what, remedy in faults if len(reported) <= most else ():
            if what in reported:
                continue
            if len(reported) == most:
                what, remedy = f"{topic}: more endpoints do not match", "the others are not listed"
            reported.add(what)
            yield f"{what}\n  {remedy}" if remedy else what
            if len(reported) > most:
                return

    def _faults(self, end: End, comparison: _Comparison) -> Iterator[Fault]:
        yield from comparison.misfits(end.claim)
        if self._is_large(end):
            yield from comparison.losses(end, self._buffer)
        if _is_clock(end):
            yield from comparison.rivals(end.claim.topic)

    def _strays(
        self, ends: Iterable[End], reads: Iterable[EndpointClaim], graph: NetworkGraph, now: float
    ) -> Iterator[str]:
        """Yield a text for each topic that another node publishes and no node reads, if the session reads a similar topic.

        The similar topic has the same last part and message type, such as /robot/cmd_vel for /cmd_vel, and no publisher. A
        published topic is reported once, if no subscriber appears within `PATIENCE` s.
        """
        node, own = self._transport.node, {end.claim.topic for end in ends}
        wanting: defaultdict[tuple[str, str], list[EndpointClaim]] = defaultdict(list)
        for claim in reads:
            if not graph.publishers(claim.topic):
                for kind in (claim.message_type, *claim.alternatives):
                    wanting[_last_part(claim.topic), kind].append(claim)
        unread = {topic: since for topic, since in self._unread.items() if since == math.inf}
        for peer in graph.endpoints if node and wanting else ():
            near = wanting.get((_last_part(peer.topic), peer.message_type))
            strange = peer.direction == "publish" and peer.full_node not in ("", node) and peer.topic not in own
            if near and strange and not graph.subscribers(peer.topic):
                unread.setdefault(peer.topic, self._unread.get(peer.topic, now))
                if now - unread[peer.topic] >= PATIENCE:
                    unread[peer.topic] = math.inf
                    yield _stray(peer, near)
        self._unread = unread

    def _dropped(self) -> Iterator[Fault]:
        """Yield the faults of services, then of topics with malformed messages that no other fault explains."""
        foreign = self._transport.foreign_services
        yield from ((warning, "") for warning in foreign.values())
        if rivals := self._transport.rival_services:
            yield _rival_servers(rivals)
        for topic in sorted(self._transport.malformed.keys() - foreign.keys() - self._mistyped):
            yield f"{topic}: a peer sends messages that do not fit the topic's type; they are dropped", ""

    def _is_known(self, peer: Endpoint, now: float) -> bool:
        """Return whether a peer can be reported: the peer's node is known, or was unknown for `PATIENCE` s."""
        return now - self._nameless.get(peer.gid, -PATIENCE) >= PATIENCE or not self._transport.node

    def _is_large(self, end: End) -> bool:
        """Return whether messages of an endpoint may be too large for a peer's receive buffer; False if its size is unknown."""
        return 0 < self._buffer * ROOM < end.largest


def published_types(graph: NetworkGraph, topics: Iterable[str]) -> dict[str, set[str]]:
    """Return the published message types of each given topic."""
    return {topic: {peer.message_type for peer in graph.publishers(topic)} for topic in topics}


def find_publishers(
    claim: EndpointClaim, ends: Sequence[End], transport: Transport, definitions: Definitions
) -> Supply:
    """Return the publishers of a subscription's topic, why their messages do not arrive, and similar topics without readers.

    Args:
        claim: claim of the subscription.
        ends: all endpoints of the session in the domain.
        transport: transport of the domain.
        definitions: message types of the session.
    """
    graph = transport.graph()
    comparison = _Comparison(ends, graph, transport.node, definitions)
    kinds = {claim.message_type, *claim.alternatives}
    others = (peer for peer in graph.endpoints if peer.direction == "publish" and peer.topic != claim.topic)
    strays = {
        peer.topic: None
        for peer in others
        if _last_part(peer.topic) == _last_part(claim.topic) and peer.message_type in kinds
        if not graph.subscribers(peer.topic)
    }
    unnamed = UNNAMED if transport.node else "this program"
    names = dict.fromkeys(peer.full_node or unnamed for peer in graph.publishers(claim.topic))
    misfits = ["\n  ".join(filter(None, fault)) for fault in comparison.misfits(claim)]
    return Supply(tuple(names), misfits, tuple(strays))


class _Comparison:
    """Compares a session's endpoints with their peers.

    Args:
        ends: publishers and subscriptions of the session.
        graph: graph with the endpoints and their peers.
        node: name of the session's node.
        definitions: message types of the session.
    """

    def __init__(self, ends: Sequence[End], graph: NetworkGraph, node: str, definitions: Definitions) -> None:
        self._graph = graph
        self._node = node
        self._definitions = definitions
        self._alike: dict[tuple[str, Direction], dict[tuple[str, _Form], Endpoint]] = {}
        self._unfit: dict[Any, list[Endpoint]] = {}
        """The peers that do not match an endpoint; the key has topic, direction, types and QoS of the endpoint."""
        self._own: defaultdict[tuple[str, str, str], list[EndpointClaim]] = defaultdict(list)
        """Claims of the session's endpoints for each topic, direction and message type."""
        for end in ends:
            self._own[end.claim.topic, end.claim.direction, end.claim.message_type].append(end.claim)
        self.mistyped: set[str] = set()
        """Subscribed topics on which a peer defines the message type in another way than the session."""

    def misfits(self, claim: EndpointClaim) -> Iterator[Fault]:
        """Yield one fault for each peer that does not match an endpoint of the session."""
        key = (claim.topic, claim.direction, claim.message_type, claim.alternatives, claim.qos)
        if key not in self._unfit:
            alike = self._distinct(claim.topic, _OTHER[claim.direction])
            types = {kind for _, (kind, _, _) in alike}
            apart = {form for form in {form for _, form in alike} if not self._fits(claim, form, types)}
            self._unfit[key] = [peer for (_, form), peer in alike.items() if form in apart]
        for peer in self._unfit[key]:
            yield _misfit(claim, peer, self._name(peer))

    def losses(self, end: End, buffer: int) -> Iterator[Fault]:
        """Yield a fault for each reader on Fast DDS: such a reader loses large messages that Cyclone DDS sends."""
        publishers = self._graph.publishers(end.claim.topic)
        own = {peer.gid[: len(CYCLONE)] for peer in publishers if peer.full_node == self._node}
        if own == {CYCLONE}:
            for peer in self._distinct(end.claim.topic, "subscribe").values():
                if peer.gid.startswith(FAST_DDS):
                    yield _loss(end, self._name(peer), buffer)

    def rivals(self, topic: str) -> Iterator[Fault]:
        """Yield a fault for each publisher of /clock outside this session; another process may have the session's node name."""
        publishers = self._graph.publishers(topic)
        others = [peer.full_node for peer in publishers if peer.full_node != self._node]
        if len(publishers) - len(others) > len(self._own[topic, "publish", CLOCK]):
            others.append(f"another process named {self._node}")
        for other in others:
            what = f"{topic}: {other} also publishes this topic: the time of all subscribers will jump back and forth"
            yield what, "stop one of the two publishers, or give its program another ROS_DOMAIN_ID"

    def _distinct(self, topic: str, direction: Direction) -> dict[tuple[str, _Form], Endpoint]:
        """Return one peer for each combination of node, message type, QoS and type hash, in the graph's order."""
        if (topic, direction) not in self._alike:
            alike = self._alike[topic, direction] = {}
            for peer in self._graph.ends(topic, direction):
                alike.setdefault((peer.full_node, (peer.message_type, peer.qos, peer.type_hash)), peer)
        return self._alike[topic, direction]

    def _fits(self, claim: EndpointClaim, form: _Form, types: Collection[str]) -> bool:
        """Return whether a peer matches an endpoint of the session; `types` has the message types of all peers on the topic."""
        kind, qos, type_hash = form
        if kind != claim.message_type:
            # A subscription uses one of its alternative types if nobody publishes its own type.
            return kind in claim.alternatives and claim.message_type not in types
        if not self._definitions.agrees(kind, type_hash):
            self.mistyped |= {claim.topic} if claim.direction == "subscribe" else set()
            return False
        return not mismatch(*_offer(claim, claim.qos, qos))

    def _name(self, peer: Endpoint) -> str:
        """Return the name of a peer for reports: the prim path of a node of this session, otherwise the ROS node name."""
        if peer.full_node == self._node:
            for claim in self._own[peer.topic, peer.direction, peer.message_type]:
                if not short_of(claim.qos, peer.qos) and not short_of(peer.qos, claim.qos):
                    return claim.node
        return peer.full_node or UNNAMED


def _last_part(topic: str) -> str:
    return topic.rpartition("/")[2]


def _shorter_names(claims: Iterable[EndpointClaim]) -> Iterator[tuple[str, Direction]]:
    """Yield the claimed topics without leading namespaces, such as /cmd_vel for /robot/cmd_vel, with each direction."""
    topics = {claim.topic for claim in claims}
    shorter = {topic[number:] for topic in topics for number, sign in enumerate(topic) if number and sign == "/"}
    for topic in shorter - topics:
        yield from ((topic, direction) for direction in _OTHER.values())


def _stray(peer: Endpoint, near: Sequence[EndpointClaim]) -> str:
    """Return the message about a topic that no node reads; `near` has the session's subscriptions on topics of this name."""
    others = len({claim.topic for claim in near}) - 1
    more = f", and {others} more topics of this name have subscribers" if others else ""
    what = f"{peer.full_node} publishes {peer.message_type}, but no node reads this topic"
    return f"{peer.topic}: {what}; {near[0].node} reads {near[0].topic}{more}"


def _offer(claim: EndpointClaim, ours: Any, theirs: Any) -> tuple[Any, Any]:
    """Return the writer's and the reader's value, in this order, from the session's and the peer's value."""
    return (ours, theirs) if claim.direction == "publish" else (theirs, ours)


def _misfit(claim: EndpointClaim, peer: Endpoint, name: str) -> Fault:
    """Return the reason why a peer does not match an endpoint of the session, and the remedy."""
    writer, reader = _offer(claim, claim.node, name)
    sent, read = _offer(claim, claim.message_type, peer.message_type)
    if sent != read:
        remedy = "a topic has one type: change one type, or rename one topic"
        return f"{claim.topic}: {writer} publishes {sent}, {reader} reads {read}: no messages arrive", remedy
    offered, requested = _offer(claim, claim.qos, peer.qos)
    if why := mismatch(offered, requested, writer, reader):
        policies = ", ".join(policy_json(peer.qos, policy) for policy in short_of(offered, requested))
        remedy = f"write {policies} in the qosProfile of {claim.node}, or change the profile of {name}"
        return f"{claim.topic}: {why}: no messages arrive", remedy
    effect = "its messages are dropped" if claim.direction == "subscribe" else "it cannot read the messages"
    return another_definition(claim.topic, name, sent, claim.node, effect)


def _loss(end: End, reader: str, buffer: int) -> Fault:
    what = f"{reader} runs Fast DDS and loses many messages: its receive buffer in Linux has {buffer} bytes"
    ways = f"run `sudo sysctl -w net.core.rmem_default={AMPLE}` and restart {reader}, or run it on rmw_cyclonedds_cpp"
    return f"{end.claim.topic}: {what}", f"messages have up to {end.largest} bytes: {ways}"


def _rival_servers(services: Sequence[str]) -> Fault:
    """Return one fault for all services that another program also offers; two runs of a scene share dozens of services."""
    shown = f"{', '.join(services[:3])}{' and others' if len(services) > 3 else ''}"
    ways = "stop one of the two, or give it another ROS_DOMAIN_ID or other names, such as --simulation-interfaces /one"
    return "another program also offers services of this run: either program may answer a call", f"{shown}: {ways}"


def _is_clock(end: End) -> bool:
    return (end.claim.message_type, end.claim.direction) == (CLOCK, "publish")
