"""Observations of an environment: ports, topics and functions of the session, as arrays with limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.api.session import Session
from graphengine.format.errors import UsageError
from graphengine.format.wording import shown, unknown
from graphengine.runtime.addresses import find_port_at

Limit = float | Sequence[float] | NDArray[Any] | None


@dataclass(frozen=True)
class Observation:
    """A value that an environment observes, and its limits. Where neither you nor the scene give limits, they are infinite.

    Attributes:
        source: a port, as in `Session.value`, such as `dd100/joint_states/ComputeOdom.position`; or the newest message of a topic
            or all numbers below one of its fields, such as `/dd100_0000/odom.pose.pose`; or the same of the newest sample of a
            sensor, such as `dd100.sensors.sim_lidar.ranges`; or a function of the session.
        low: least value, or one for each number; None is the bound of the port, or `range_min` of the message for `ranges`.
        high: greatest value, or one for each number; None is the bound of the port, or `range_max` of the message for `ranges`.
    """

    source: str | Callable[[Session], Any]
    low: Limit = None
    high: Limit = None

    def _open(self, sim: Session) -> Signal:
        """Return the observation in a session.

        Raises:
            UsageError: the session has no such port, robot or sensor, or no graph uses the topic.
        """
        source = self.source
        if not isinstance(source, str):
            return Signal(self, getattr(source, "__name__", "a function"), lambda: source(sim))
        robot, found, part = source.partition(".sensors.")
        if found:
            name, _, path = part.partition(".")
            sensor = sim.robots[robot].sensors[name]
            sensor.sample()  # the first call requests samples
            return Signal(self, source, lambda: _part(source, sensor.sample(), path))
        if not source.startswith("/"):
            port = find_port_at(sim._runner.session.graphs, source).port
            bounds = (port.gt if port.ge is None else port.ge), (port.lt if port.le is None else port.le)
            return Signal(self, source, lambda: sim.value(source), lambda: bounds)
        topic, _, path = source.partition(".")
        newest = sim.subscribe(topic, keep=1)

        def ranges() -> tuple[Any, Any]:
            of = newest.latest if path in ("range", "ranges") else None
            return getattr(of, "range_min", None), getattr(of, "range_max", None)

        return Signal(self, source, lambda: _part(source, newest.latest, path), ranges, newest.clear)


@dataclass(frozen=True)
class Signal:
    """An observation in a session.

    Attributes:
        observation: the observation.
        name: its source, for messages.
        read: returns the newest value; None if there is none.
        bounds: returns the limits that the scene gives to the value; None is no limit.
        restart: discards the value, after the session was restored.
    """

    observation: Observation
    name: str
    read: Callable[[], Any]
    bounds: Callable[[], tuple[Any, Any]] = lambda: (None, None)
    restart: Callable[[], None] = lambda: None

    def array(self) -> NDArray[Any]:
        """Return the value as a new array of bytes, for bytes as those of an image, or otherwise of 32-bit numbers."""
        return _numbers(self.name, self.read())

    def limits(self) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the least and the greatest value of each number, in the type of the array."""
        array, given, bounds = self.array(), self.observation, self.bounds()
        least, most = (0, 255) if array.dtype == np.uint8 else (-math.inf, math.inf)
        low, high = spread(self.name, (given.low, bounds[0], least), (given.high, bounds[1], most), array.shape)
        return low.astype(array.dtype), high.astype(array.dtype)


def spread(name: str, low: Sequence[Any], high: Sequence[Any], shape: Sequence[int]) -> Sequence[NDArray[np.float64]]:
    """Return limits as arrays of a shape: of each sequence, the first one that is not None.

    Raises:
        UsageError: the limits do not fit the shape, or a lower limit is not below the upper limit.
    """
    first = [next(limit for limit in limits if limit is not None) for limits in (low, high)]
    try:
        limits = [np.broadcast_to(np.asarray(limit, np.float64), shape) for limit in first]
    except ValueError:
        raise UsageError(f"{name}: low, high: expected one number, or numbers of shape {tuple(shape)}") from None
    if not (limits[0] < limits[1]).all():
        raise UsageError(f"{name}: expected low below high, got {first[0]} and {first[1]}")
    return limits


def _names(value: Any) -> list[str]:
    """Return the names of the fields of a message; none for another value."""
    return [field.name for field in fields(value) if field.name != "__msgtype__"] if is_dataclass(value) else []


def _part(name: str, message: Any, path: str) -> Any:
    """Return a field of a message, such as `pose.pose`; the message itself for an empty path; None for None."""
    for field in path.split(".") if path and message is not None else ():
        if field not in _names(message):
            raise UsageError(f"{name}: {unknown('field', field, _names(message))}")
        message = getattr(message, field)
    return message


def _numbers(name: str, value: Any) -> NDArray[Any]:
    """Return a number or an array as an array of one dimension or more, and a message as a flat array of all its numbers."""
    if names := _names(value):
        return np.concatenate([_numbers(f"{name}.{each}", getattr(value, each)).ravel() for each in names])
    found = np.atleast_1d(value)
    if found.dtype.kind not in "biuf":
        raise UsageError(f"{name}: expected numbers, got {shown(value)}")
    return found.astype(np.uint8 if found.dtype == np.uint8 else np.float32)
