"""What keeps a session and its peers apart, told once each: who offers what, who asks for what, and what to do about it.

DDS says nothing where two ends of a topic do not fit, nor where the receiver's kernel has no room for a message.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Protocol, TypeAlias

from graphengine.backend import EndpointClaim
from graphengine.ros.graph import PATIENCE, Direction, Endpoint, Graph
from graphengine.ros.qos import mismatch, policy_json, short_of
from graphengine.ros.transport import Transport
from graphengine.ros.vendors import CYCLONE, FAST_DDS

CLOCK = "rosgraph_msgs/msg/Clock"
PERIOD, LONGEST_PERIOD = 1.0, 5.0
"""Seconds between two looks, which are the rarer the longer they take."""
SHARE = 0.005
"""Part of the time that looking may take, as long as that is not too rare."""

RECEIVE_BUFFER = Path("/proc/sys/net/core/rmem_default")
"""Bytes that Linux keeps for a socket which does not ask for more, as those of Fast DDS do not."""
ROOM = 0.85
"""Part of it that a message may fill, as the kernel counts its own book-keeping of each packet too.

Measured from Cyclone DDS to Fast DDS on one machine with a buffer of 212992 bytes, 60 messages at 30 Hz: all arrive up to
190 kB; of 210 kB 22 where both ends are reliable, of 300 kB 20 and 6 where they are not, of 922 kB 14 to 18 and 2.
"""
AMPLE = 4194304
"""Bytes of a receive buffer with which all of them arrive."""

_OTHER: dict[str, Direction] = {"publish": "subscribe", "subscribe": "publish"}


Fault: TypeAlias = tuple[str, str]
"""What is wrong, and the remedy."""


class End(Protocol):
    """A publisher or subscription of the session."""

    claim: EndpointClaim
    largest: int
    """Bytes of the largest message that was sent."""


class Watch:
    """Looks now and then at who else is on the topics that a session has on a transport.

    Args:
        transport: what is asked.
        tell: is given what is wrong and, in a second line, the remedy.
        clock: seconds.
        buffer: bytes that the kernel keeps for a receiver; None for what this machine says.
    """

    def __init__(
        self,
        transport: Transport,
        tell: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
        buffer: int | None = None,
    ) -> None:
        self._transport = transport
        self._tell = tell
        self._clock = clock
        self._buffer = _receive_buffer() if buffer is None else buffer
        self._due = 0.0
        self._told: set[str] = set()
        self._nameless: dict[bytes, float] = {}
        """Peers whose node is not known, and since when they are."""

    def hurry(self) -> None:
        """Look next time: the session has other topics than before."""
        self._due = 0.0

    def look(self, ends: Callable[[], Sequence[End]]) -> None:
        """Compare the session's ends with all others, if it is time to."""
        begun = self._clock()
        if begun >= self._due:
            self._compare(ends(), begun)
            self._due = begun + min(max(PERIOD, (self._clock() - begun) / SHARE), LONGEST_PERIOD)

    def _compare(self, ends: Sequence[End], now: float) -> None:
        asked = {(end.claim.topic, _OTHER[end.claim.direction]) for end in ends}
        asked |= {(end.claim.topic, "publish") for end in ends if _is_clock(end) or self._is_large(end)}
        graph = self._transport.graph(asked)
        nameless = {peer.gid for where in asked for peer in graph.ends(*where) if not peer.node}
        self._nameless = {gid: self._nameless.get(gid, now) for gid in nameless}
        for what, remedy in self._faults(ends, graph, now):
            self._say(what, remedy)
        foreign = self._transport.foreign_services
        for warning in foreign.values():
            self._say(warning)
        if rivals := self._transport.rival_services:
            self._say(*_rival_servers(rivals))
        for topic in sorted(self._transport.malformed.keys() - foreign.keys()):
            self._say(f"{topic}: a peer sends what is no message of the topic's type; dropped")

    def _say(self, what: str, remedy: str = "") -> None:
        if what not in self._told:
            self._told.add(what)
            self._tell(f"{what}\n  {remedy}" if remedy else what)

    def _faults(self, ends: Sequence[End], graph: Graph, now: float) -> Iterator[Fault]:
        def known(topic: str, direction: Direction) -> list[Endpoint]:
            return [peer for peer in graph.ends(topic, direction) if self._is_known(peer, now)]

        for end in ends:
            claim = end.claim
            peers = known(claim.topic, _OTHER[claim.direction])
            for peer in peers:
                yield from _misfits(claim, peer, self._name(peer, ends), [other.message_type for other in peers])
            publishers = known(claim.topic, "publish")
            if self._is_large(end):
                own = [other for other in publishers if other.full_node == self._transport.node]
                lossy = [peer for peer in peers if _vendors(own) == {CYCLONE} and _vendors([peer]) == {FAST_DDS}]
                yield from (_loss(end, self._name(peer, ends), self._buffer) for peer in lossy)
            if _is_clock(end):
                own_number = sum(_is_clock(other) and other.claim.topic == claim.topic for other in ends)
                yield from _rivals(claim.topic, publishers, self._transport.node, own_number)

    def _is_known(self, peer: Endpoint, now: float) -> bool:
        """Whether its node is known by now, or never will be."""
        return now - self._nameless.get(peer.gid, -PATIENCE) >= PATIENCE or not self._transport.node

    def _is_large(self, end: End) -> bool:
        """Whether what is sent may not fit; no system but Linux tells."""
        return 0 < self._buffer * ROOM < end.largest

    def _name(self, peer: Endpoint, ends: Sequence[End]) -> str:
        """The prim path of a node of the session, else the name of a node of ROS."""
        if peer.full_node == self._transport.node:
            for claim in (end.claim for end in ends):
                ours = (claim.topic, claim.direction, claim.message_type)
                alike = not short_of(claim.qos, peer.qos) and not short_of(peer.qos, claim.qos)
                if ours == (peer.topic, peer.direction, peer.message_type) and alike:
                    return claim.node
        return peer.full_node or "a program that is no node of ROS"


def _misfits(claim: EndpointClaim, peer: Endpoint, name: str, types: Collection[str]) -> Iterator[Fault]:
    """Why the session and a peer do not hear each other; `types` are those of all peers there."""
    ours, theirs = (claim.node, claim.qos, claim.message_type), (name, peer.qos, peer.message_type)
    sides = (ours, theirs) if claim.direction == "publish" else (theirs, ours)
    (writer, offered, sent), (reader, requested, read) = sides
    if sent != read:
        # A subscription takes one of its alternatives where its own type is not published.
        if peer.message_type not in claim.alternatives or claim.message_type in types:
            what = f"{writer} publishes {sent}, {reader} reads {read}"
            yield f"{claim.topic}: {what}: nothing arrives", "a topic has one type: change either of them, or its topic"
    elif why := mismatch(offered, requested, writer, reader):
        policies = ", ".join(policy_json(peer.qos, policy) for policy in short_of(offered, requested))
        remedy = f"write {policies} in the qosProfile of {claim.node}, or change what {name} asks for or offers"
        yield f"{claim.topic}: {why}: nothing arrives", remedy


def _loss(end: End, reader: str, buffer: int) -> Fault:
    what = f"{reader} runs Fast DDS and loses many messages: Linux keeps {buffer} bytes for it"
    ways = f"`sudo sysctl -w net.core.rmem_default={AMPLE}` and start {reader} again, or run it on rmw_cyclonedds_cpp"
    return f"{end.claim.topic}: {what}", f"they have up to {end.largest}: {ways}"


def _rivals(topic: str, publishers: Sequence[Endpoint], node: str, own: int) -> Iterator[Fault]:
    """Who publishes another time; as many of the publishers of that node as are our own are not meant."""
    others = [peer.full_node for peer in publishers if peer.full_node != node]
    if len(publishers) - len(others) > own:
        others.append(f"another process named {node}")
    for other in others:
        what = f"{topic}: {other} publishes it too: time will jump to and fro for whoever listens"
        yield what, "end either of them, or give it a ROS_DOMAIN_ID of its own"


def _rival_servers(services: Sequence[str]) -> Fault:
    """That services are offered twice, in the same words whichever they are: of two runs alike, that is dozens."""
    shown = f"{', '.join(services[:3])}{' and others' if len(services) > 3 else ''}"
    ways = "end either of them, or give it other names, as with --simulation-interfaces /one, or its own ROS_DOMAIN_ID"
    return "another program offers services that this run offers too: either may answer a call", f"{shown}: {ways}"


def _vendors(ends: Iterable[Endpoint]) -> set[bytes]:
    return {end.gid[: len(CYCLONE)] for end in ends}


def _is_clock(end: End) -> bool:
    return (end.claim.message_type, end.claim.direction) == (CLOCK, "publish")


def _receive_buffer() -> int:
    """Bytes; 0 where the system does not tell."""
    try:
        return int(RECEIVE_BUFFER.read_text())
    except (OSError, ValueError):
        return 0
