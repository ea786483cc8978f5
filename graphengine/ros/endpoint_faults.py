"""Faults between the endpoints of a session and their peers, found by topic, with one comparison for all that are alike.

DDS says nothing where two ends of a topic do not fit, nor where the receiver's kernel has no room for a message.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from typing import Any, Protocol, TypeAlias

from graphengine.messages.definitions import Definitions, another_definition
from graphengine.messages.endpoints import EndpointClaim, QoS
from graphengine.messages.qos import mismatch, policy_json, short_of
from graphengine.ros.network_graph import PATIENCE, Direction, Endpoint, NetworkGraph
from graphengine.ros.transport import Transport
from graphengine.ros.transports.vendors import CYCLONE, FAST_DDS

CLOCK = "rosgraph_msgs/msg/Clock"
MOST = 20
"""Faults of one topic that are reported; one line mentions that there are more."""
ROOM = 0.85
"""Part of a receive buffer that a message may fill, as the kernel counts its own book-keeping of each packet too.

Measured from Cyclone DDS to Fast DDS on one machine with a buffer of 212992 bytes, 60 messages at 30 Hz: all arrive up to
190 kB; of 210 kB 22 where both ends are reliable, of 300 kB 20 and 6 where they are not, of 922 kB 14 to 18 and 2.
"""
AMPLE = 4194304
"""Bytes of a receive buffer with which all of them arrive."""

_OTHER: Mapping[str, Direction] = {"publish": "subscribe", "subscribe": "publish"}

Fault: TypeAlias = tuple[str, str]
"""A fault and its remedy."""
_Form: TypeAlias = tuple[str, QoS, str]
"""Message type, QoS and type hash of a peer, on which its fit depends."""


class End(Protocol):
    """A publisher or subscription of the session."""

    claim: EndpointClaim
    largest: int
    """Bytes of the largest message that was sent."""


class Finder:
    """Finds faults between a session's endpoints and their peers. Used by one thread at a time.

    Args:
        transport: whose graph is searched.
        definitions: message types of the session.
        buffer: bytes that the kernel keeps for a receiver; 0 where they are not known.
    """

    def __init__(self, transport: Transport, definitions: Definitions, buffer: int) -> None:
        self._transport = transport
        self._definitions = definitions
        self._buffer = buffer
        self._reported: defaultdict[str, set[str]] = defaultdict(set)
        """Faults that earlier looks returned, by topic."""
        self._nameless: dict[bytes, float] = {}
        """Peers whose node is not known, and since when they are."""
        self._mistyped: set[str] = set()
        """Topics on which a peer publishes another definition of their type."""
        self.published: Mapping[str, Set[str]] = {}
        """Types that were published on each topic of a subscription with alternatives, at the last look."""

    def look(self, ends: Iterable[End], now: float) -> list[str]:
        """Texts of the faults that no earlier look returned, in order of the ends, then of the graph.

        Args:
            ends: of the session.
            now: s.
        """
        ends = list(ends)
        asked = {(end.claim.topic, _OTHER[end.claim.direction]) for end in ends}
        asked |= {(end.claim.topic, "publish") for end in ends if _is_clock(end) or self._is_large(end)}
        graph = self._transport.graph(asked)
        choosing = {end.claim.topic for end in ends if end.claim.alternatives}
        self.published = published_types(graph, choosing)
        nameless = {peer.gid for where in asked for peer in graph.ends(*where) if not peer.node}
        self._nameless = {gid: self._nameless.get(gid, now) for gid in nameless}
        known = NetworkGraph(peer for peer in graph.endpoints if self._is_known(peer, now))
        comparison = _Comparison(ends, known, self._transport.node, self._definitions)
        found = [text for end in ends for text in self._new(end.claim.topic, self._faults(end, comparison), MOST)]
        self._mistyped |= comparison.mistyped
        return [*found, *self._new("", self._dropped(), math.inf)]

    def _new(self, topic: str, faults: Iterable[Fault], most: float) -> Iterator[str]:
        """Texts of faults that were not reported, up to a number of them for each topic."""
        reported = self._reported[topic]
        for what, remedy in faults if len(reported) <= most else ():
            if what in reported:
                continue
            if len(reported) == most:
                what, remedy = f"{topic}: more of its ends do not fit", "the others are not listed"
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

    def _dropped(self) -> Iterator[Fault]:
        """Faults of services, and topics of which the transport dropped messages for no other fault that is known."""
        foreign = self._transport.foreign_services
        yield from ((warning, "") for warning in foreign.values())
        if rivals := self._transport.rival_services:
            yield _rival_servers(rivals)
        for topic in sorted(self._transport.malformed.keys() - foreign.keys() - self._mistyped):
            yield f"{topic}: a peer sends what is no message of the topic's type; dropped", ""

    def _is_known(self, peer: Endpoint, now: float) -> bool:
        """Whether its node is known by now, or never will be."""
        return now - self._nameless.get(peer.gid, -PATIENCE) >= PATIENCE or not self._transport.node

    def _is_large(self, end: End) -> bool:
        """Whether messages may exceed the receive buffer; its size is known on Linux only."""
        return 0 < self._buffer * ROOM < end.largest


def published_types(graph: NetworkGraph, topics: Iterable[str]) -> dict[str, set[str]]:
    """Types that are published on each of some topics."""
    return {topic: {peer.message_type for peer in graph.publishers(topic)} for topic in topics}


class _Comparison:
    """A session's ends and their peers at one moment, by topic and direction.

    Args:
        ends: of the session.
        graph: with the ends and their peers.
        node: name of the session's node.
        definitions: message types of the session.
    """

    def __init__(self, ends: Sequence[End], graph: NetworkGraph, node: str, definitions: Definitions) -> None:
        self._graph = graph
        self._node = node
        self._definitions = definitions
        self._alike: dict[tuple[str, Direction], dict[tuple[str, _Form], Endpoint]] = {}
        self._unfit: dict[Any, list[Endpoint]] = {}
        """Peers that do not fit, by what that depends on."""
        self._own: defaultdict[tuple[str, str, str], list[EndpointClaim]] = defaultdict(list)
        """Claims of the session by topic, direction and type."""
        for end in ends:
            self._own[end.claim.topic, end.claim.direction, end.claim.message_type].append(end.claim)
        self.mistyped: set[str] = set()
        """Topics on which a peer publishes another definition of their type."""

    def misfits(self, claim: EndpointClaim) -> Iterator[Fault]:
        """Why a claim of the session and its peers do not hear each other; peers are named for a fault only."""
        key = (claim.topic, claim.direction, claim.message_type, claim.alternatives, claim.qos)
        if key not in self._unfit:
            alike = self._distinct(claim.topic, _OTHER[claim.direction])
            types = {kind for _, (kind, _, _) in alike}
            apart = {form for form in {form for _, form in alike} if not self._fits(claim, form, types)}
            self._unfit[key] = [peer for (_, form), peer in alike.items() if form in apart]
        for peer in self._unfit[key]:
            yield _misfit(claim, peer, self._name(peer))

    def losses(self, end: End, buffer: int) -> Iterator[Fault]:
        """Readers on Fast DDS that lose large messages of Cyclone DDS."""
        publishers = self._graph.publishers(end.claim.topic)
        own = {peer.gid[: len(CYCLONE)] for peer in publishers if peer.full_node == self._node}
        if own == {CYCLONE}:
            for peer in self._distinct(end.claim.topic, "subscribe").values():
                if peer.gid.startswith(FAST_DDS):
                    yield _loss(end, self._name(peer), buffer)

    def rivals(self, topic: str) -> Iterator[Fault]:
        """Nodes that publish another time; publishers of this node beyond those of the session are another process."""
        publishers = self._graph.publishers(topic)
        others = [peer.full_node for peer in publishers if peer.full_node != self._node]
        if len(publishers) - len(others) > len(self._own[topic, "publish", CLOCK]):
            others.append(f"another process named {self._node}")
        for other in others:
            what = f"{topic}: {other} publishes it too: time will jump to and fro for every listener"
            yield what, "end either of them, or give it another ROS_DOMAIN_ID"

    def _distinct(self, topic: str, direction: Direction) -> dict[tuple[str, _Form], Endpoint]:
        """The first of the peers of each node that are of one form, in the graph's order."""
        if (topic, direction) not in self._alike:
            alike = self._alike[topic, direction] = {}
            for peer in self._graph.ends(topic, direction):
                alike.setdefault((peer.full_node, (peer.message_type, peer.qos, peer.type_hash)), peer)
        return self._alike[topic, direction]

    def _fits(self, claim: EndpointClaim, form: _Form, types: Collection[str]) -> bool:
        """Whether a claim and a peer hear each other; `types` are those of all peers there."""
        kind, qos, type_hash = form
        if kind != claim.message_type:
            # A subscription takes one of its alternatives where its own type is not published.
            return kind in claim.alternatives and claim.message_type not in types
        if not self._definitions.agrees(kind, type_hash):
            self.mistyped |= {claim.topic} if claim.direction == "subscribe" else set()
            return False
        return not mismatch(*_offer(claim, claim.qos, qos))

    def _name(self, peer: Endpoint) -> str:
        """The prim path of a node of the session, else the name of a node of ROS."""
        if peer.full_node == self._node:
            for claim in self._own[peer.topic, peer.direction, peer.message_type]:
                if not short_of(claim.qos, peer.qos) and not short_of(peer.qos, claim.qos):
                    return claim.node
        return peer.full_node or "a program that is no node of ROS"


def _offer(claim: EndpointClaim, ours: Any, theirs: Any) -> tuple[Any, Any]:
    """The writer's value, then the reader's."""
    return (ours, theirs) if claim.direction == "publish" else (theirs, ours)


def _misfit(claim: EndpointClaim, peer: Endpoint, name: str) -> Fault:
    """Why a claim and a peer that do not fit do not."""
    writer, reader = _offer(claim, claim.node, name)
    sent, read = _offer(claim, claim.message_type, peer.message_type)
    if sent != read:
        what = f"{writer} publishes {sent}, {reader} reads {read}"
        return f"{claim.topic}: {what}: nothing arrives", "a topic has one type: change either of them, or its topic"
    offered, requested = _offer(claim, claim.qos, peer.qos)
    if why := mismatch(offered, requested, writer, reader):
        policies = ", ".join(policy_json(peer.qos, policy) for policy in short_of(offered, requested))
        remedy = f"write {policies} in the qosProfile of {claim.node}, or change what {name} asks for or offers"
        return f"{claim.topic}: {why}: nothing arrives", remedy
    effect = "its messages are dropped" if claim.direction == "subscribe" else "it cannot read what is sent"
    return another_definition(claim.topic, name, sent, claim.node, effect)


def _loss(end: End, reader: str, buffer: int) -> Fault:
    what = f"{reader} runs Fast DDS and loses many messages: Linux keeps {buffer} bytes for it"
    ways = f"`sudo sysctl -w net.core.rmem_default={AMPLE}` and start {reader} again, or run it on rmw_cyclonedds_cpp"
    return f"{end.claim.topic}: {what}", f"they have up to {end.largest}: {ways}"


def _rival_servers(services: Sequence[str]) -> Fault:
    """Services that are offered twice, as one fault: two equal runs share dozens."""
    shown = f"{', '.join(services[:3])}{' and others' if len(services) > 3 else ''}"
    ways = "end either of them, or give it other names, as with --simulation-interfaces /one, or its own ROS_DOMAIN_ID"
    return "another program offers services that this run offers too: either may answer a call", f"{shown}: {ways}"


def _is_clock(end: End) -> bool:
    return (end.claim.message_type, end.claim.direction) == (CLOCK, "publish")
