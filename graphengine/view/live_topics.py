"""Measures the topics of a session, and keeps the newest message of each topic that a viewer selected."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from graphengine.format.errors import GraphError
from graphengine.messages.endpoints import EndpointClaim, Publisher
from graphengine.view.wire import TopicMessage

if TYPE_CHECKING:
    from graphengine.runtime.session_core import SessionCore

WINDOW = 2.0
"""Simulation time over which rates are averaged, s."""
MOST_TOPICS = 2000
"""Maximum number of topics to list."""
LARGEST = 4_000_000
"""Maximum size of a message whose content is shown, bytes."""


class Newest(Protocol):
    """A subscription that keeps the newest message; implemented in `api.topics`."""

    type: str

    @property
    def latest_data(self) -> bytes | None:
        """The newest message, encoded as CDR; None before the first message."""

    def close(self) -> None:
        """Unsubscribe from the topic."""


Listen = Callable[[str], Newest]
"""Function that subscribes to the topic with this name; raises GraphError if this fails."""


class _Traffic:
    """A tap of the network that counts messages and bytes of each topic."""

    def __init__(self) -> None:
        self.counts: defaultdict[str, list[int]] = defaultdict(lambda: [0, 0])

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Count a message that a node published."""
        count = self.counts[claim.topic]
        count[0] += 1
        count[1] += len(data)

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Count messages that a node's subscription received."""
        count = self.counts[claim.topic]
        count[0] += len(arrived)
        count[1] += sum(map(len, arrived))


class LiveTopics:
    """Measures the topics of a session. Rates are per second of simulation time; they do not depend on the speed of the run.

    Args:
        session: session to measure.
        listen: subscribes to a topic that a viewer selected.
    """

    def __init__(self, session: SessionCore, listen: Listen) -> None:
        self._session = session
        self._listen = listen
        self._traffic: _Traffic | None = None
        self._seen: deque[tuple[float, Mapping[str, tuple[int, int]]]] = deque()
        """Simulation times within `WINDOW`, s, each with the counts of messages and bytes by topic at that time."""
        self._version = session.version
        self._watched: dict[str, Newest] = {}
        self._sent: dict[str, bytes | None] = {}

    def end(self) -> None:
        """Stop measuring and unsubscribe from all topics."""
        if self._watched:
            self.watch(())
        if self._traffic is not None:
            self._session.services.network.untap(self._traffic)
            self._traffic = None
            self._seen.clear()

    def rows(self, time: float) -> list[Mapping[str, Any]]:
        """Return name, type, rate, bandwidth and endpoints of each topic as JSON values; `time` is the simulation time, s."""
        rates = self._rates(time)
        publishers: defaultdict[str, list[Publisher]] = defaultdict(list)
        for publisher in self._session.services.network.publishers:
            publishers[publisher.topic].append(publisher)
        claims: defaultdict[str, list[EndpointClaim]] = defaultdict(list)
        for claim in self._session.services.claims:
            if not claim.is_service:
                claims[claim.topic].append(claim)
        return [
            _row(topic, claims[topic], publishers[topic], rates.get(topic)) for topic in sorted(claims)[:MOST_TOPICS]
        ]

    def _rates(self, time: float) -> Mapping[str, tuple[float, float]]:
        """Return messages per second and bytes per second by topic; empty before the second measurement."""
        if self._traffic is None:
            self._traffic = _Traffic()
            self._session.services.network.tap(self._traffic)
        if self._seen and time < self._seen[-1][0]:  # the time was reset
            self._seen.clear()
        if not self._seen or time > self._seen[-1][0]:
            self._seen.append((time, {name: (count[0], count[1]) for name, count in self._traffic.counts.items()}))
        while len(self._seen) > 2 and self._seen[1][0] <= time - WINDOW:
            self._seen.popleft()
        (begun, first), (_, last) = self._seen[0], self._seen[-1]
        seconds = self._seen[-1][0] - begun
        if seconds <= 0.0:
            return {}
        return {
            topic: ((count - first.get(topic, (0, 0))[0]) / seconds, (size - first.get(topic, (0, 0))[1]) / seconds)
            for topic, (count, size) in last.items()
        }

    def watch(self, topics: Collection[str]) -> None:
        """Subscribe to the topics that viewers have selected, and unsubscribe from all other topics."""
        version, self._version = self._version, self._session.version
        reloaded = version != self._version  # a topic may have another type
        for topic in [topic for topic in self._watched if reloaded or topic not in topics]:
            self._watched.pop(topic).close()
            self._sent.pop(topic, None)
        for topic in topics:
            if topic not in self._watched:
                try:
                    self._watched[topic] = self._listen(topic)
                except GraphError:  # the topic was removed with its robot
                    continue

    def messages(self) -> Iterator[TopicMessage]:
        """Yield the newest message of each watched topic that has a new message since the last call."""
        for topic, newest in self._watched.items():
            data = newest.latest_data
            if topic in self._sent and data is self._sent[topic]:
                continue
            self._sent[topic] = data
            size = len(data) if data is not None else 0
            yield TopicMessage(topic, newest.type, size, data if size <= LARGEST else None)


def _row(
    topic: str, claims: Sequence[EndpointClaim], publishers: Sequence[Publisher], rate: tuple[float, float] | None
) -> Mapping[str, Any]:
    readers = [claim for claim in claims if claim.direction == "subscribe"]
    return {
        "name": topic,
        "type": claims[0].message_type,
        "rate": rate[0] if rate else None,
        "bandwidth": rate[1] if rate else None,
        "publishers": len(publishers),
        "subscribers": sum(publisher.subscribers for publisher in publishers) if publishers else len(readers),
        "wanted": any(publisher.wanted for publisher in publishers) if publishers else bool(readers),
        "nodes": [claim.node for claim in claims][:20],
    }
