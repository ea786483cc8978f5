"""Judges expectations over the topics of a bag: a recording of a real robot, of another simulator, or of a run."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Iterator
from functools import partial
from heapq import merge
from operator import itemgetter
from pathlib import Path
from typing import Any, NoReturn

from graphengine.api.expectations.bag_file import BagFile
from graphengine.api.expectations.expectations import Expectation, ExpectationCheck
from graphengine.api.expectations.judging import Judging
from graphengine.api.expectations.operators import TIME_ERROR
from graphengine.api.expectations.reading_types import Reading, Readings
from graphengine.api.expectations.readings import WORLD, topic_readings
from graphengine.format.errors import ExpectationError, UsageError
from graphengine.messages import messages
from graphengine.messages.definitions import Definitions

MAX_INTERVALS = 1_000_000
"""Maximum number of intervals in which the rate of a topic is measured in a bag."""
CLOCK = "/clock"


def judge_bag(path: str | os.PathLike[str], *expectations: Expectation) -> tuple[ExpectationCheck, ...]:
    """Judge expectations over the topics of a recording, without a simulation, and return the checks.

    >>> stays, arrives = ge.judge_bag(
    ...     "real.mcap",
    ...     ge.always("abs(message('/odom').twist.twist.linear.x) < 1.1"),
    ...     ge.within(20.0, "message('/odom').pose.pose.position.x > 5"),
    ... )

    Conditions can use `time`, `message`, `age` and `rate`; a bag has no ports, body poses or contacts. The time is the log time,
    at which the recorder received a message; it is 0 at the first message of the bag. If the bag has the topic `/clock`, the
    time is that of the newest message of `/clock`; it is 0 at the first one. In a recording of graphengine, the time is the
    simulation time of the run.

    A condition is evaluated after each message of a topic that it reads, at the end of each interval of its rates, and at the end
    of the bag. Messages with the same time are delivered together. A condition that reads no topic is evaluated after every
    message.

    Args:
        path: an MCAP or SQLite file (`.mcap`, `.db3`), or the folder of `ros2 bag record`.
        expectations: expectations such as `ge.always(…)`.

    Raises:
        ExpectationError: an expectation is not met or could not be judged; the message reports all of these.
        RecordingError: the bag cannot be read.
        UsageError: a condition is not legal, or names a topic that the bag does not have.
    """
    bag = Bag(Path(path))
    try:
        checks = tuple(bag.expect(expectation) for expectation in expectations)
        bag.play()
    finally:
        bag.close()
    missed = [check.report() for check in checks if check.outcome != "passed"]
    if missed:
        raise ExpectationError("\n".join(missed))
    return checks


class Bag:
    """Plays a bag and judges expectations over its topics.

    `judge_bag` documents the time and the evaluation of conditions.

    Args:
        path: an MCAP or SQLite file, or a folder with such files.

    Raises:
        RecordingError: the bag cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._file = BagFile(path)
        self.tick, self.time = 0, 0.0
        self._topics: dict[str, _Topic] = {}
        self._watched: list[tuple[Judging, set[str | float]]] = []
        self._read: set[str | float] = set()
        """Topics and intervals (s) that trigger the evaluation of the expectation that is being added."""
        self._begin = 0 if self._file.is_run else self._file.begin
        self._origin = 0
        """Tick of the last reset of the time."""
        self._clock: _Topic | None = None
        self._epoch = self._begin
        if not self._file.is_run:
            for _, _, data in itertools.islice(self._file.messages([CLOCK]), 1):
                self._clock = _Topic(*self._file.message_type(CLOCK))
                self._epoch = self._clock.nanoseconds(data)

    @property
    def _length(self) -> float:
        return (self._file.end - self._begin) / 1e9

    def close(self) -> None:
        """Close the files."""
        self._file.close()

    def expect(self, expectation: Expectation) -> ExpectationCheck:
        """Add an expectation, which `play` judges.

        Raises:
            UsageError: a condition is not legal, or uses a topic or function that the bag does not have.
        """
        self._read = set()
        check = ExpectationCheck(expectation, self, self._readings())
        self._watched.append((Judging(self, check), self._read))
        return check

    def play(self, length: float = math.inf) -> None:
        """Play the bag up to the time `length` (s) or to its end, and judge all expectations.

        Raises:
            RecordingError: the bag is damaged.
        """
        for at, group in itertools.groupby(self._events(), key=itemgetter(0)):
            events = list(group)
            time = self._time_of(at, events)
            if time > length + TIME_ERROR:
                break
            was_reset = time < self.time - TIME_ERROR
            if was_reset:
                self._origin = self.tick + 1
            self.time = time
            for _, token, data in events:
                if data is not None and token in self._topics:
                    self._topics[token].deliver(data)
            self._judge(None if was_reset else {token for _, token, _ in events})
        if self._clock is None:
            self.time = max(self.time, min(length, self._length))
        self._judge(None)
        for judging, _ in self._watched:
            for check in judging.checks:
                check.end()

    def _judge(self, arrived: set[Any] | None) -> None:
        self.tick += 1
        for judging, read in self._watched:
            if arrived is None or not read or read & arrived:
                judging.after_tick(self.tick - self._origin)

    def _events(self) -> Iterator[tuple[int, Any, bytes | None]]:
        """Yield (log time in ns, topic, data) for each message and (time in ns, duration in s, None) at each interval's end."""
        tokens = set().union(*(read for _, read in self._watched))
        intervals = [token for token in tokens if isinstance(token, float)]
        every = any(not read for _, read in self._watched)
        topics = None if every else {CLOCK, *(token for token in tokens if isinstance(token, str))}
        yield from merge(self._file.messages(topics), *map(self._ends, intervals), key=itemgetter(0))

    def _ends(self, over: float) -> Iterator[tuple[int, float, None]]:
        for count in range(1, math.floor(self._length / over + TIME_ERROR) + 1):
            yield self._begin + round(count * over * 1e9), over, None

    def _time_of(self, at: int, events: list[tuple[int, Any, bytes | None]]) -> float:
        """Return the time (s) at a log time (ns), given the messages with this log time."""
        if self._clock is None:
            return max(at - self._begin, 0) / 1e9
        clocks = [data for _, token, data in events if token == CLOCK and data is not None]
        return (self._clock.nanoseconds(clocks[-1]) - self._epoch) / 1e9 if clocks else self.time

    def _readings(self) -> Readings:
        readings = topic_readings(self, self._epoch)

        def rate(topic: str, over: float = 1.0) -> Reading:
            reading = readings["rate"](topic, over)
            if (number := self._length / over) > MAX_INTERVALS:
                raise UsageError(f"rate: the bag has {number:.3g} intervals of {over:g} s, more than {MAX_INTERVALS}")
            self._read.add(float(over) if self._clock is None else CLOCK)
            return reading

        return {**readings, "rate": rate, **{name: partial(_refuse, name) for name in WORLD}}

    def subscribe(self, topic: str, *, keep: int) -> _Topic:
        """Return the messages of a topic; only the newest one is kept."""
        self._read.add(topic)
        if topic not in self._topics:
            self._topics[topic] = _Topic(*self._file.message_type(topic))
        return self._topics[topic]

    def mark(self, text: str) -> None:
        """Do nothing: marks are not written to a bag."""


class _Topic:
    """The messages of a topic up to the current time."""

    def __init__(self, message_type: str, definitions: Definitions) -> None:
        self.type, self.definitions = message_type, definitions
        self.latest_data: bytes | None = None
        self.received = 0

    def _decode(self, data: bytes) -> Any:
        return messages.decode(data, self.type, self.definitions)

    def deliver(self, data: bytes) -> None:
        self.latest_data, self.received = data or None, self.received + 1

    @property
    def latest(self) -> Any:
        return self._decode(self.latest_data) if self.latest_data is not None else None

    def newest_data(self, count: int) -> list[bytes]:
        """Return the newest message; an empty list if `count` is 0 or no message has arrived."""
        return [self.latest_data] if count > 0 and self.latest_data is not None else []

    def nanoseconds(self, data: bytes) -> int:
        """Return the time (ns) in a message of `/clock`."""
        time = self._decode(data).clock
        return int(time.sec * 10**9 + time.nanosec)


def _refuse(name: str, *arguments: object) -> NoReturn:
    raise UsageError(
        f"{name}: a bag has only topics; use a message, such as message('/odom').pose.pose.position.x\n"
        "  a bag has: time, message(topic), age(topic), rate(topic)"
    )
