"""Listening at one's own pace: a queue between a transport's thread and a thread that prints, and the clocks of ROS."""

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
"""Nanoseconds: of the wall clock since 1970, or of a simulation since it began."""


@dataclass(frozen=True, slots=True)
class Arrival:
    """A message as it came.

    Args:
        data: CDR.
        time: when, by the clock of the one who listens.
    """

    data: bytes
    time: int


class MessageQueue:
    """Messages that wait to be looked at; where too many wait, the oldest are dropped and counted.

    Args:
        depth: how many may wait.
        clock: what their arrival is timed with.
    """

    def __init__(self, depth: int, clock: Clock = time.time_ns) -> None:
        self.dropped = 0
        self._clock = clock
        self._waiting: deque[Arrival] = deque(maxlen=depth)
        self._arrived = threading.Condition()

    def deliver(self, data: bytes) -> None:
        """Take one message from the transport's thread."""
        arrival = Arrival(data, self._clock())
        with self._arrived:
            self.dropped += len(self._waiting) == self._waiting.maxlen
            self._waiting.append(arrival)
            self._arrived.notify()

    def take(self, timeout: float | None) -> Arrival | None:
        """The oldest message, or None when there is none within so many seconds; without a timeout it waits for one."""
        with self._arrived:
            self._arrived.wait_for(lambda: self._waiting, timeout)
            return self._waiting.popleft() if self._waiting else None


class SimulationClock:
    """The time that a simulation publishes; 0 until it does."""

    def __init__(self, transport: Transport) -> None:
        self._now = 0
        self._heard = threading.Event()
        transport.reader(CLOCK, "rosgraph_msgs/msg/Clock", CLOCK_QOS, self._deliver)

    def __call__(self) -> int:
        """Nanoseconds since the simulation began."""
        return self._now

    def wait(self, timeout: float) -> bool:
        """Whether the simulation tells its time, waiting so many seconds for it."""
        return self._heard.wait(timeout)

    def _deliver(self, data: bytes) -> None:
        try:
            clock = messages.decode(data, "rosgraph_msgs/msg/Clock").clock
        except TransportError:
            return  # a peer that sends rubbish
        self._now = clock.sec * 1_000_000_000 + clock.nanosec
        self._heard.set()
