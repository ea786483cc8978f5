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
from graphengine.ros.transport import Transport

PERIOD, LONGEST_PERIOD = 0.5, 5.0
"""Shortest and longest time between two searches, s; longer searches run less often."""
SHARE = 0.005
"""Fraction of the wall time that searches may take, unless `LONGEST_PERIOD` requires more."""
REPORTED_A_TICK = 5
"""Maximum number of faults reported per tick; the others wait for the next tick."""

RECEIVE_BUFFER = Path("/proc/sys/net/core/rmem_default")
"""File with the default receive buffer size of sockets in Linux, bytes; Fast DDS does not request a larger one."""


class Watch:
    """Compares the session's endpoints on a transport with their peers. Used by one thread.

    Args:
        transport: transport that discovers the peers.
        ends: returns the session's endpoints; called in the thread that runs ticks. The search iterates over the result in
            its own thread.
        tell: receives each fault, with the remedy on a second line.
        clock: returns the time, s.
        buffer: size of a peer's receive buffer in the kernel, bytes; None: the default size on this machine.
        definitions: message types of the session.
    """

    def __init__(
        self,
        transport: Transport,
        ends: Callable[[], Iterable[End]],
        tell: Callable[[str], None],
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
        """The search in progress; its result has the faults, and the time when the next search is due."""
        self._due = 0.0
        self._found: deque[str] = deque()

    def published(self, topics: Iterable[str]) -> Mapping[str, Set[str]]:
        """Return the types published on the given topics, as of the last search; for a transport without a node, as of now."""
        if self._transport.node:
            return self._finder.published
        return published_types(self._transport.graph({(topic, "publish") for topic in topics}), topics)

    def hurry(self) -> None:
        """Search again at the next `look`, because the session's endpoints have changed."""
        self._due = 0.0

    def look(self) -> None:
        """Start a search if one is due, and report some of the faults that earlier searches found."""
        if self._look is not None and self._look.done():
            self._collect(self._look)
        if self._found:
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
        """End the thread; safe to call twice."""
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
        self._due = min(self._due, due)  # which is 0 where a look was asked for meanwhile


def _receive_buffer() -> int:
    """Return the default size of a receive buffer, bytes; 0 if the system does not report it."""
    try:
        return int(RECEIVE_BUFFER.read_text())
    except (OSError, ValueError):
        return 0
