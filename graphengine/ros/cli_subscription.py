"""Subscriptions of command line tools: a message queue between the transport's thread and the printing thread, and clocks."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from graphengine.format.errors import TransportError
from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.transport import Transport

CLOCK = "/clock"
CLOCK_QOS = QoS(depth=1, reliability="bestEffort")

Clock = Callable[[], int]
"""Function that returns the current time in ns: wall clock time since 1970, or simulation time."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """A received message.

    Args:
        data: CDR bytes.
        time: time of arrival by the subscriber's clock, ns.
    """

    data: bytes
    time: int


class MessageQueue:
    """A queue of received messages; a full queue drops and counts its oldest message.

    Args:
        depth: maximum number of messages.
        clock: returns the current time, ns, as the time of arrival.
    """

    def __init__(self, depth: int, clock: Clock = time.time_ns) -> None:
        self.dropped = 0
        self._clock = clock
        self._waiting: deque[Arrival] = deque(maxlen=depth)
        self._arrived = threading.Condition()

    def deliver(self, data: bytes) -> None:
        """Add a message; called in the transport's thread."""
        arrival = Arrival(data, self._clock())
        with self._arrived:
            self.dropped += len(self._waiting) == self._waiting.maxlen
            self._waiting.append(arrival)
            self._arrived.notify()

    def take(self, timeout: float | None) -> Arrival | None:
        """Remove and return the oldest message; None if no message arrives within `timeout` s (None: wait forever)."""
        with self._arrived:
            self._arrived.wait_for(lambda: self._waiting, timeout)
            return self._waiting.popleft() if self._waiting else None


class SimulationClock:
    """The simulation time from `/clock`; 0 until the first message."""

    def __init__(self, transport: Transport) -> None:
        self._now = 0
        self._heard = threading.Event()
        transport.reader(CLOCK, "rosgraph_msgs/msg/Clock", CLOCK_QOS, self._deliver)

    def __call__(self) -> int:
        """Return the simulation time, ns."""
        return self._now

    def wait(self, timeout: float) -> bool:
        """Wait up to `timeout` s for the first message on `/clock`; return whether it has arrived."""
        return self._heard.wait(timeout)

    def _deliver(self, data: bytes) -> None:
        try:
            clock = messages.decode(data, "rosgraph_msgs/msg/Clock").clock
        except TransportError:
            return  # a peer that sends rubbish
        self._now = clock.sec * 1_000_000_000 + clock.nanosec
        self._heard.set()
