"""Finds received messages that a recording already contains: published by the run, or received by another node.

A bag contains each message of a topic once. So the bytes of each received message are compared with the last messages of the
topic, and counted: if a node receives three equal messages and the recording contains two, the third message is new.
"""

from __future__ import annotations

import hashlib
from collections import Counter, defaultdict, deque
from collections.abc import Sequence

REMEMBERED = 1000
"""Number of remembered messages per topic; a received message that equals only older messages counts as new."""


class SeenMessages:
    """Remembers the last messages of one topic, and counts how often each node has received each message."""

    def __init__(self) -> None:
        self._order: deque[bytes] = deque()
        self._known: Counter[bytes] = Counter()
        self._seen: defaultdict[str, Counter[bytes]] = defaultdict(Counter)

    def add(self, data: bytes) -> None:
        """Add a published message."""
        self._add(_digest(data))

    def see(self, nodes: Sequence[str], data: bytes) -> bool:
        """Add a message that nodes received; return whether the recording already contains the message."""
        digest = _digest(data)
        for node in nodes:
            self._seen[node][digest] += 1
        known = all(self._seen[node][digest] <= self._known[digest] for node in nodes)
        if not known:
            self._add(digest)
        return known

    def _add(self, digest: bytes) -> None:
        self._order.append(digest)
        self._known[digest] += 1
        if len(self._order) > REMEMBERED:
            oldest = self._order.popleft()
            for counts in (self._known, *self._seen.values()):
                counts[oldest] -= 1
                if counts[oldest] <= 0:
                    del counts[oldest]


def _digest(data: bytes) -> bytes:
    return hashlib.blake2b(data, digest_size=16).digest()
