"""Finds messages that a recording already holds: published by the run, or seen by another node.

A bag has each message of a topic once. So what a node saw is held against the last messages of the topic by its bytes, and
counted: who sees three messages of the same bytes where two are known sees one that came from outside.
"""

from __future__ import annotations

import hashlib
from collections import Counter, defaultdict, deque
from collections.abc import Sequence

REMEMBERED = 1000
"""Messages of a topic; who sees an older one is taken for the first who does."""


class SeenMessages:
    """The last messages of one topic, and how many of each a node saw."""

    def __init__(self) -> None:
        self._order: deque[bytes] = deque()
        self._known: Counter[bytes] = Counter()
        self._seen: defaultdict[str, Counter[bytes]] = defaultdict(Counter)

    def add(self, data: bytes) -> None:
        """Add a published message."""
        self._add(_digest(data))

    def see(self, nodes: Sequence[str], data: bytes) -> bool:
        """Add a message that nodes saw; return whether it was known."""
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
