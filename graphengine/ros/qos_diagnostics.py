"""Searches for incompatible peers in a separate thread, and reports them in the thread that runs ticks."""

from __future__ import annotations

import contextlib
import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Set
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from graphengine.format.errors import TransportError
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.ros.endpoint_faults import End, Finder, published_types
from graphengine.ros.transport import Complain, Transport

PERIOD, LONGEST_PERIOD = 0.5, 5.0
"""Shortest and longest time between the starts of two searches, s; see `SHARE`."""
SHARE = 0.005
"""Fraction of wall time for searches: after a long search, the next search starts later, up to `LONGEST_PERIOD`."""
REPORTED_A_TICK = 5
"""Maximum number of faults to report per tick; the remaining faults wait for the next tick."""

RECEIVE_BUFFER = Path("/proc/sys/net/core/rmem_default")
"""Linux file with the default receive buffer size of sockets, bytes; Fast DDS does not request a larger buffer."""


class Watch:
    """Searches in a background thread for peers that do not fit the session's endpoints on a transport. Not thread-safe.

    Args:
        transport: transport that discovers the peers.
        ends: returns the session's endpoints; called in the thread that runs ticks. The background thread iterates over the
            result.
        tell: called with the text of each fault, whose second line is the remedy.
        clock: returns the current time, s.
        buffer: size of a peer's receive buffer in the kernel, bytes; None for the default size on this machine.
        definitions: message types of the session.
    """

    def __init__(
        self,
        transport: Transport,
        ends: Callable[[], Iterable[End]],
        tell: Complain,
        clock: Callable[[], float] = time.monotonic,
        buffer: int | None = None,
        definitions: Definitions = DEFINITIONS,
    ) -> None:
        self._transport = transport
        self._ends = ends
        self._finder = Finder(transport, definitions, _receive_buffer() if buffer is None else buffer)
        self._tell = tell
        self._clock = clock
        self._worker = ThreadPoolExecutor(1, "watch")
        self._look: Future[tuple[list[str], float]] | None = None
        """The search in progress; the result has the texts of faults, and the time at which the next search is due, s."""
        self._due = 0.0
        self._found: deque[str] = deque()

    def published(self, topics: Iterable[str]) -> Mapping[str, Set[str]]:
        """Return the types that were published on the given topics at the last search; without a node, the current types."""
        if self._transport.node:
            return self._finder.published
        return published_types(self._transport.graph({(topic, "publish") for topic in topics}), topics)

    def hurry(self) -> None:
        """Make a search due at the next `look`; called when the session's endpoints have changed."""
        self._due = 0.0

    def look(self) -> None:
        """Report up to `REPORTED_A_TICK` faults of earlier searches, and start the next search if it is due."""
        if self._look is not None and self._look.done():
            self._collect(self._look)
        for _ in range(min(len(self._found), REPORTED_A_TICK)):
            self._tell(self._found.popleft())
        if self._look is None and (begun := self._clock()) >= self._due:
            self._due = math.inf
            self._look = self._worker.submit(self._search, self._ends(), begun)

    def finish(self) -> None:
        """Wait for the current search, and report all remaining faults."""
        if self._look is not None:
            self._collect(self._look)
        while self._found:
            self._tell(self._found.popleft())

    def close(self) -> None:
        """Wait for the current search, report all remaining faults, and end the thread; safe to call twice."""
        try:
            with contextlib.suppress(TransportError):  # where the transport was closed before
                self.finish()
        finally:
            self._worker.shutdown()

    def _search(self, ends: Iterable[End], begun: float) -> tuple[list[str], float]:
        found = self._finder.look(ends, begun)
        return found, begun + min(max(PERIOD, (self._clock() - begun) / SHARE), LONGEST_PERIOD)

    def _collect(self, look: Future[tuple[list[str], float]]) -> None:
        self._look = None
        found, due = look.result()
        self._found += found
        self._due = min(self._due, due)  # 0 if `hurry` was called during the search


def _receive_buffer() -> int:
    """Return the default size of a receive buffer, bytes; 0 if the system does not report it."""
    try:
        return int(RECEIVE_BUFFER.read_text())
    except (OSError, ValueError):
        return 0
