"""Metrics: numbers that describe a run, such as the top speed of a robot, each computed from one sample per tick.

with ge.load("dd100_flat").session() as sim:
    top_speed = sim.measure(metric(max="velocity('dd100').linear[0]"))
    sim.run(5.0)
    print(top_speed.value)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from graphengine.api.after_tick import AfterTick
from graphengine.api.expectations.conditions import Condition, Expression
from graphengine.api.expectations.reading_types import Readings
from graphengine.api.expectations.readings import readings_of
from graphengine.api.session import Session
from graphengine.format.errors import UsageError
from graphengine.format.wording import listing

Fold = Callable[[float, float, int], float]
"""Returns the updated metric; the arguments are the previous metric, a sample, and the number of samples including this one."""
FOLDS: Mapping[str, Fold] = MappingProxyType(
    {
        "min": lambda before, sample, _: min(before, sample),
        "max": lambda before, sample, _: max(before, sample),
        "mean": lambda before, sample, number: before + (sample - before) / number,
        "final": lambda before, sample, _: sample,
        "time_to": lambda before, sample, _: before,
    }
)


@dataclass(frozen=True, slots=True)
class Metric:
    """A number that describes a run; `Session.measure` begins to compute it.

    Attributes:
        operator: `min`, `max`, `mean`, `final` or `time_to`.
        text: the expression; for `time_to`, the condition.
    """

    operator: str
    text: str

    def __call__(self, session: Session) -> Measurement:
        """Begin to measure a session.

        Raises:
            UsageError: the expression is not legal, or names something that the session does not have.
        """
        return Measurement(self, session)


def metric(**operator: str) -> Metric:
    """Return a metric: `min`, `max`, `mean` or `final` of an expression over all ticks, or the `time_to` a condition.

    >>> top = sim.measure(metric(max="velocity('dd100').linear[0]"))
    >>> at = sim.measure(metric(time_to="time >= 0.5"))
    >>> sim.run(1.0)
    True
    >>> top.value < 0.01, at.value
    (True, 0.5)

    Raises:
        UsageError: no operator or more than one operator is given.
    """
    if len(operator) != 1 or not operator.keys() <= FOLDS.keys():
        raise UsageError(
            f"metric: expected one operator, got {', '.join(operator) or 'none'}\n  {listing(FOLDS, 'operators')}"
        )
    return Metric(*next(iter(operator.items())))


class Measurement(AfterTick):
    """The computation of one metric in one session. A reset of the time restarts it; checkpoints contain its state.

    Attributes:
        metric: the metric that is computed.
        value: the metric so far: a number, or for `time_to` the time since the beginning at which the condition first held, s.
            None if there was no sample, or the condition never held.
    """

    kept = ("value", "_number", "_begin", "_frame")

    def __init__(self, metric: Metric, session: Session) -> None:
        self.metric = metric
        self._session = session
        self._read = _reader(metric, readings_of(session), session)
        self._frame = session.tick
        self._restart()

    def _restart(self) -> None:
        self.value: float | None = None
        self._number = 0
        self._begin = self._session.time

    def after_tick(self, frame: int) -> None:
        """Take a sample; `frame` is the number of ticks since the start or since the last reset of the time.

        Raises:
            UsageError: the value is not a number.
        """
        if frame < self._frame:
            self._restart()
        self._frame = frame
        sample = self._read()
        if sample is None or math.isnan(sample):
            return
        if self.metric.operator == "time_to":
            sample -= self._begin
        self._number += 1
        self.value = sample if self.value is None else FOLDS[self.metric.operator](self.value, sample, self._number)


def _reader(metric: Metric, readings: Readings, session: Session) -> Callable[[], float | None]:
    """Return a function that samples a value, or the time at which a condition holds; it returns None without a sample."""
    if metric.operator != "time_to":
        return Expression(metric.text, readings).number
    condition = Condition(metric.text, readings)

    def time() -> float | None:
        sample = condition.sample()
        return session.time if sample is not None and sample.holds else None

    return time
