"""The readings of a session by which conditions refer to its ports, topics, robots and time."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from graphengine.api.expectations.conditions import Kind, NoValueError, Reading, Readings
from graphengine.api.expectations.operators import TIME_ERROR
from graphengine.api.session import Session
from graphengine.api.topics import Subscription
from graphengine.format.errors import UsageError

Place = str | Sequence[float]
"""Name of a robot or object, a prim path, or a point in the world frame, m; two numbers are a point in the horizontal plane."""
_POSE: dict[str, Kind] = {"position": "vector", "orientation": "vector"}
_VELOCITY: dict[str, Kind] = {"linear": "vector", "angular": "vector"}


def readings_of(session: Session) -> Readings:
    """Return the functions for the conditions of a session, by the names that conditions use.

    | function | value |
    |---|---|
    | `time` | simulation time, s |
    | `port(address)` | value of a port, with an address as in `Session.value` |
    | `message(topic)` | newest message of a topic |
    | `age(topic)` | time from the stamp of a message to its arrival, s; has a value in ticks in which a message arrives |
    | `rate(topic, over=1.0)` | messages per second in the last `over` seconds; has a value at the end of each such interval |
    | `pose(body)` | record with `position`, m, and `orientation`, quaternion (x, y, z, w), in the world frame |
    | `velocity(body)` | record with `linear`, m/s, and `angular`, rad/s, in the world frame |
    | `tilt(body)` | angle between the z axis of the body and the vertical, rad |
    | `distance(one, other)` | distance of two bodies or points, m; horizontal if a point has two numbers |
    | `contact(body, other="*", but="")` | whether a robot or object touched something in this tick whose name matches the first
      pattern and not the second one, in any physics step; a pattern that begins with `/` is one for `/World/NAME` |

    A body is the name of a robot or object, or a prim path. A function raises UsageError if the session lacks what it names.
    """

    def port(address: str) -> Reading:
        value = session.value(address)
        kind: Kind = "number" if isinstance(value, bool | int | float) else "vector" if _is_vector(value) else "other"
        return Reading(lambda: session.value(address), kind)

    def message(topic: str) -> Reading:
        subscription = session.subscribe(topic, keep=1)
        return Reading(lambda: _newest(subscription), "other")

    def pose(body: str) -> Reading:
        found = session.body(body)
        return Reading(lambda: found.pose, "record", _POSE)

    def velocity(body: str) -> Reading:
        found = session.body(body)
        return Reading(lambda: found.velocity, "record", _VELOCITY)

    def tilt(body: str) -> Reading:
        found = session.body(body)
        return Reading(lambda: _tilt(found.pose.orientation))

    def distance(one: Place, other: Place) -> Reading:
        places = [_position(session, place) for place in (one, other)]
        plane = any(not isinstance(place, str) and len(place) == 2 for place in (one, other))
        return Reading(lambda: math.dist(*(place()[: 2 if plane else 3] for place in places)))

    def contact(body: str, other: str = "*", but: str = "") -> Reading:
        found = session.body(body)
        found.touched  # noqa: B018  (lets the steps of the next tick be observed)
        return Reading(lambda: any(_matches(name, other) and not _matches(name, but) for name in found.touched))

    return {
        "time": lambda: Reading(lambda: session.time),
        "port": port,
        "message": message,
        "age": lambda topic: Reading(_Age(session, topic)),
        "rate": lambda topic, over=1.0: Reading(_Rate(session, topic, over)),
        "pose": pose,
        "velocity": velocity,
        "tilt": tilt,
        "distance": distance,
        "contact": contact,
    }


def _is_vector(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 1 and value.dtype.kind in "biuf"
    return isinstance(value, tuple) and all(isinstance(part, bool | int | float) for part in value)


def _newest(subscription: Subscription[Any]) -> Any:
    message = subscription.latest
    if message is None:
        raise NoValueError
    return message


def _tilt(orientation: Sequence[float]) -> float:
    x, y, _, _ = orientation
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))


def _position(session: Session, place: Place) -> Callable[[], Sequence[float]]:
    """Return the function that reads the position of a body, m; that of a point is constant.

    Raises:
        UsageError: the point does not have two or three finite numbers.
    """
    if isinstance(place, str):
        body = session.body(place)
        return lambda: body.pose.position
    numbers = [float(part) for part in place]
    if len(numbers) not in (2, 3) or not all(map(math.isfinite, numbers)):
        raise UsageError(f"a point has two or three finite numbers, got {place!r}")
    return lambda: numbers


def _matches(name: str, pattern: str) -> bool:
    return fnmatchcase(f"/World/{name}" if pattern.startswith("/") else name, pattern)


class _Arrivals(ABC):
    """A number that the arrivals on a topic give once in a tick, however often it is read."""

    def __init__(self, session: Session, topic: str) -> None:
        self._session = session
        self._subscription = session.subscribe(topic, keep=1)
        self._tick = -1
        self._value: float | None = None

    def __call__(self) -> float:
        if self._session.tick != self._tick:
            self._tick, self._value = self._session.tick, self._read()
        if self._value is None:
            raise NoValueError
        return self._value

    @abstractmethod
    def _read(self) -> float | None:
        """Return the value in this tick; None if there is none."""


class _Age(_Arrivals):
    """The age of the newest message on arrival, s."""

    _seen = 0

    def _read(self) -> float | None:
        received, message = self._subscription.received, self._subscription.latest
        if received == self._seen or message is None:
            return None
        self._seen, stamp = received, message.header.stamp
        return float(self._session.time - stamp.sec - 1e-9 * stamp.nanosec)


class _Rate(_Arrivals):
    """The mean rate of messages in successive intervals of equal duration, Hz."""

    def __init__(self, session: Session, topic: str, over: float) -> None:
        if not 0.0 < over < math.inf:
            raise UsageError(f"rate: expected an interval of more than 0 s, got {over!r}")
        super().__init__(session, topic)
        self._over, self._begin, self._before = over, session.time, 0

    def _read(self) -> float | None:
        elapsed = self._session.time - self._begin
        if 0.0 <= elapsed < self._over - TIME_ERROR:
            return None
        received = self._subscription.received
        number, self._before, self._begin = received - self._before, received, self._session.time
        return number / elapsed if elapsed > 0.0 else None  # else, the time was reset
