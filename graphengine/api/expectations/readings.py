"""The readings by which conditions refer to the ports, topics, robots and time of a session, or to the topics of a bag."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from functools import lru_cache, partial
from operator import itemgetter, methodcaller
from typing import Any, Protocol

import numpy as np

from graphengine.api.expectations.operators import TIME_ERROR
from graphengine.api.expectations.reading_types import Kind, Reading, Readings, ReadingState, Shared
from graphengine.api.session import Session
from graphengine.devices.backend import World
from graphengine.devices.rotation import Pose
from graphengine.devices.stage import Prim
from graphengine.format.errors import UsageError
from graphengine.format.wording import unknown
from graphengine.messages.field_reader import number_reader

Place = str | Sequence[float]
"""Name of a robot or object, a prim path, or a point in the world frame, m; two numbers are a point in the horizontal plane."""
KEPT = 100
"""Maximum number of messages per tick whose ages are compared."""
FAR = 2.0
"""Maximum value of `clearance`, m; more distant bodies are ignored."""
SEVERITIES = ("info", "warning", "error")
"""Severities of messages that nodes log, from low to high."""
WORLD = ("port", "pose", "velocity", "tilt", "distance", "clearance", "contact", "log")
"""Names of the functions that need a session and are not available for bags."""
READINGS = (*WORLD, "time", "message", "age", "rate")
"""Names of all functions of conditions."""


class Source(Protocol):
    """The source of the values of readings: a session or a bag."""

    @property
    def time(self) -> float:
        """Time since the beginning, s."""

    @property
    def tick(self) -> int:
        """Number of the current tick, or of the current group of messages of a bag."""

    def subscribe(self, topic: str, *, keep: int) -> Any:
        """Subscribe to a topic; the result has the attributes of `Subscription`."""

    def mark(self, text: str) -> None:
        """Add a mark to the recording of the session."""


def readings_of(session: Session) -> Readings:
    """Return the functions for the conditions of a session, by the names that conditions use.

    | function | value |
    |---|---|
    | `time` | simulation time, s |
    | `port(address)` | value of a port, with an address as in `Session.value` |
    | `message(topic)` | newest message of a topic |
    | `age(topic)` | largest time from stamp to arrival of the messages of this tick, s; no value in ticks without messages |
    | `rate(topic, over=1.0)` | messages per second in the last `over` seconds; has a value only at the end of such an interval |
    | `pose(body)` | record with `position`, m, and `orientation`, quaternion (x, y, z, w), in the world frame |
    | `velocity(body)` | record with `linear`, m/s, and `angular`, rad/s, in the world frame |
    | `tilt(body)` | angle between the z axis of the body and the vertical, rad |
    | `distance(one, other)` | distance of two bodies or points, m; horizontal if a point has two numbers |
    | `clearance(body, other="*")` | distance to the nearest body whose name matches, m, at most 2 m, as in `Body.clearance` |
    | `log(level)` | number of messages that nodes have logged with this severity or a higher one: info, warning or error |
    | `contact(body, other="*", but="")` | whether a robot or object touched, in any physics step of this tick, a body whose name
      matches `other` and not `but`; a pattern that begins with `/` is compared with `/World/NAME` |

    A body is the name of a robot or object, or a prim path. A function raises UsageError if an argument names something that the
    session does not have.
    """
    runner = session._runner

    def world() -> World:
        return runner.session.services.world

    def port(address: str) -> Reading:
        value = session.value(address)
        kind: Kind = "number" if isinstance(value, bool | int | float) else "vector" if _is_vector(value) else "other"
        return Reading(partial(session._port_value, address), kind)

    def tracked(read: str, body: str, handle_of: Callable[[World], Callable[[Prim], Any]]) -> Shared:
        """Return the result of the method `read` of a body's handle. After the handle was released, it is looked up again."""
        find, call = session.body(body).find, methodcaller(read)
        handle = handle_of(world())(find())

        def value() -> Any:
            nonlocal handle
            if handle.released:
                handle = handle_of(world())(find())
            return call(handle)

        return f"{read} of {body}", value

    def frame(place: Place) -> Shared:
        """Return the pose of a body, or the position of a point."""
        if isinstance(place, str):
            return tracked("pose", place, lambda world: world.frame)
        numbers = [float(part) for part in place]
        if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
            raise UsageError(f"a point has two or three finite numbers, got {place!r}")
        return f"point {numbers}", lambda: (numbers,)

    def record(value: Callable[[], Any], of: Shared, *names: str) -> Reading:
        """Return the reading of a record. Its fields are the vectors in the shared value `of`, in the order of `names`."""
        fields = {name: Reading(itemgetter(index), "vector", of=(of,)) for index, name in enumerate(names)}
        return Reading(value, "other", fields.get)

    def pose(body: str) -> Reading:
        found = session.body(body)
        return record(lambda: found.pose, frame(body), "position", "orientation")

    def velocity(body: str) -> Reading:
        found = session.body(body)
        return record(lambda: found.velocity, tracked("velocity", body, lambda world: world.body), "linear", "angular")

    def tilt(body: str) -> Reading:
        return Reading(_tilt, of=(frame(body),))

    def distance(one: Place, other: Place) -> Reading:
        size = 2 if any(not isinstance(place, str) and len(place) == 2 for place in (one, other)) else 3
        return Reading(lambda a, b: math.dist(a[0][:size], b[0][:size]), of=(frame(one), frame(other)))

    def clearance(body: str, other: str = "*") -> Reading:
        found = session.body(body)
        found.clearance()  # raises UsageError for a body without shapes

        def nearest() -> float:
            return min((gap for name, gap in found.clearance(FAR).items() if _matches(name, other)), default=FAR)

        return Reading(nearest)

    def log(level: str) -> Reading:
        if level not in SEVERITIES:
            raise UsageError(unknown("severity", level, SEVERITIES))
        logged, counted = runner.problems.logged, SEVERITIES[SEVERITIES.index(level) :]
        return Reading(lambda: sum(logged[severity] for severity in counted))

    def contact(body: str, other: str = "*", but: str = "") -> Reading:
        session.body(body).touched  # noqa: B018  (starts the observation of physics steps)

        @lru_cache(maxsize=64)
        def matched(names: tuple[str, ...]) -> bool:
            return any(_matches(name, other) and not _matches(name, but) for name in names)

        return Reading(matched, of=((f"contacts of {body}", lambda: world().entities.touched(body)),))

    return {
        **topic_readings(SessionSource(session)),
        "port": port,
        "pose": pose,
        "velocity": velocity,
        "tilt": tilt,
        "distance": distance,
        "clearance": clearance,
        "contact": contact,
        "log": log,
    }


class SessionSource:
    """A session as a source of readings; its properties take less time than those of `Session`, which check the thread."""

    def __init__(self, session: Session) -> None:
        self._runner, self.subscribe, self.mark = session._runner, session.subscribe, session.mark

    @property
    def time(self) -> float:
        """Simulation time, s."""
        return self._runner.session.clock.time

    @property
    def tick(self) -> int:
        """Number of ticks since the last reset of the time."""
        return self._runner.session.clock.frame


def topic_readings(source: Source, epoch: int = 0) -> Readings:
    """Return the functions that `readings_of` describes and that need only topics: `time`, `message`, `age` and `rate`.

    Args:
        source: a session or a bag.
        epoch: ROS time at the time 0 of the source, ns.
    """
    time = "time", lambda: source.time
    return {
        "time": lambda: Reading(float, of=(time,)),
        "message": lambda topic: _newest(source.subscribe(topic, keep=1)),
        "age": lambda topic: _reading(_Age(source, topic, epoch)),
        "rate": lambda topic, over=1.0: _reading(_Rate(source, topic, over), time),
    }


def _reading(state: _Age | _Rate, *of: Shared) -> Reading:
    return Reading(state, state=state, arrives=True, of=of)


def _is_vector(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 1 and value.dtype.kind in "biuf"
    return isinstance(value, tuple) and bool(value) and all(isinstance(part, bool | int | float) for part in value)


def _newest(arrivals: Any) -> Reading:
    """Return the reading of the newest message; its numbers are read without decoding the message, where this is possible."""
    decoded = lru_cache(maxsize=1)(lambda received: arrivals.latest)

    def field(path: str) -> Reading | None:
        number = number_reader(arrivals.type, path, arrivals.definitions)
        if number is None:
            return None

        def read() -> float | None:
            data = arrivals.latest_data
            return None if data is None else number(data)

        return Reading(read, arrives=True)

    return Reading(lambda: decoded(arrivals.received), "other", field, arrives=True)


def _tilt(pose: Pose) -> float:
    _, (x, y, _, _) = pose
    return math.acos(max(-1.0, 1.0 - 2.0 * (x * x + y * y)))


@lru_cache(maxsize=1000)
def _matches(name: str, pattern: str) -> bool:
    return fnmatchcase(f"/World/{name}" if pattern.startswith("/") else name, pattern)


class _Age(ReadingState):
    """The largest age of the messages that arrive in a tick, s; None in ticks without messages."""

    kept = ("_tick", "_value")

    def __init__(self, source: Source, topic: str, epoch: int) -> None:
        self._source = source
        self._arrivals = source.subscribe(topic, keep=KEPT)
        self._topic, self._epoch = topic, divmod(epoch, 10**9)
        self._seconds, self._nanoseconds = (
            number_reader(self._arrivals.type, f"header.stamp.{name}", self._arrivals.definitions)
            for name in ("sec", "nanosec")
        )
        self._last = 0
        """Number of messages that had arrived at the last reading."""
        self.reset()

    def reset(self) -> None:
        """Restart at the current time."""
        self._tick = -1
        self._value: float | None = None

    def __call__(self) -> float | None:
        if (tick := self._source.tick) != self._tick:
            new, self._last = self._arrivals.received - self._last, self._arrivals.received
            self._tick, self._value = tick, max(map(self._age, self._arrivals.newest_data(new)), default=None)
        return self._value

    def _age(self, data: bytes) -> float:
        if self._seconds is None or self._nanoseconds is None:
            raise UsageError(f"age: the messages of {self._topic} have no header with a stamp")
        seconds, nanoseconds = self._epoch
        return self._source.time + (seconds - self._seconds(data)) + 1e-9 * (nanoseconds - self._nanoseconds(data))


class _Rate(ReadingState):
    """The mean rate of messages in successive intervals of equal duration, Hz; each interval includes its end.

    The value is None before the end of the first interval and between two ends.
    """

    kept = ("_begin", "_count", "_value")

    def __init__(self, source: Source, topic: str, over: float) -> None:
        if not 0.0 < over < math.inf:
            raise UsageError(f"rate: expected an interval of more than 0 s, got {over!r}")
        self._source, self._over = source, over
        self._arrivals = source.subscribe(topic, keep=1)
        self.reset()

    def reset(self) -> None:
        """Restart at the current time."""
        self._begin, self._count = self._source.time, 0
        self._value: float | None = None

    @property
    def _count(self) -> int:
        """Number of messages that have arrived in the present interval."""
        return int(self._arrivals.received) - self._before

    @_count.setter
    def _count(self, count: int) -> None:
        self._before = int(self._arrivals.received) - count

    def __call__(self, time: float) -> float | None:
        elapsed = time - self._begin
        if elapsed <= 0.0:
            if self._value is None:
                self._count = 0  # an interval does not include its beginning
            return self._value
        if elapsed < self._over - TIME_ERROR:
            return None
        self._begin, self._value, self._count = time, self._count / elapsed, 0
        return self._value
