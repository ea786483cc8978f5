"""The entries of `expect:` in a scenario file; each names the operator by its key, such as `always: tilt("dd100") < 0.1`."""

from __future__ import annotations

import math
from typing import Any

from pydantic import Field, model_validator

from graphengine.api.expectations import expectations
from graphengine.api.expectations.expectations import Expectation
from graphengine.format.spec import Duration, FileSpec, NotNegative, Period
from graphengine.format.wording import listing

_PARTS = {
    "always": (),
    "never": (),
    "within": ("reach",),
    "until": ("keep",),
    "holds": ("for",),
    "settles": ("after",),
    "count": ("at_least", "at_most"),
    "rate": (),
    "latency": (),
}
"""The other keys of an entry, by the key of its operator."""
_OPTIONAL = ("at_least", "at_most")
_KEYS = {*_PARTS, *(key for parts in _PARTS.values() for key in parts)}


class RateSpec(FileSpec):
    """Limits for the rate of a topic."""

    topic: str
    """Full name of the topic."""
    at_least: NotNegative = 0.0
    """Lowest rate in each interval, Hz."""
    at_most: NotNegative | None = None
    """Highest rate in each interval, Hz; default: no limit."""
    over: Period = 1.0
    """Duration of an interval in simulation time."""


class LatencySpec(FileSpec):
    """Limit for the time from the stamp of a message to its arrival."""

    topic: str
    """Full name of the topic."""
    at_most: Duration
    """Longest time."""


class ExpectationSpec(FileSpec):
    """An expectation: one operator, with the condition that it judges."""

    always: str | None = None
    """Condition that holds after every tick, as `tilt("dd100") < 0.1`."""
    never: str | None = None
    """Condition that holds after no tick."""
    within: Period | None = None
    """Time in which the condition of `reach` holds at least once."""
    reach: str | None = None
    """Condition of `within`."""
    until: str | None = None
    """Condition that becomes true in the run; the condition of `keep` holds in all ticks before."""
    keep: str | None = None
    """Condition that holds before that of `until`."""
    holds: str | None = None
    """Condition that holds without interruption for the time of `for`."""
    for_: Duration | None = Field(default=None, alias="for", description="Duration of `holds`.")
    settles: str | None = None
    """Condition that holds in every tick from the time of `after` on."""
    after: Duration | None = None
    """Time of `settles`."""
    count: str | None = None
    """Condition that begins to hold `at_least` to `at_most` times."""
    at_least: int | None = Field(default=None, ge=0)
    """Smallest number for `count`; default: 0."""
    at_most: int | None = Field(default=None, ge=0)
    """Largest number for `count`; default: no limit."""
    rate: RateSpec | None = None
    """Rate of a topic, as {topic: /scan, at_least: 9.5}."""
    latency: LatencySpec | None = None
    """Time from the stamps of a topic's messages to their arrival, as {topic: /scan, at_most: 100ms}."""

    @model_validator(mode="before")
    @classmethod
    def _is_one_operator(cls, value: Any) -> Any:
        if not isinstance(value, dict):
            return value
        operators = [key for key in value if key in _PARTS]
        if len(operators) != 1:
            found = " and ".join(map(repr, operators)) or "none"
            raise ValueError(f"expected one operator, got {found}; {listing(_PARTS, 'operators')}")
        if value[operators[0]] is None:
            raise ValueError(f"{operators[0]!r} needs a value")
        needed = _PARTS[operators[0]]
        excess = [key for key in value if key in _KEYS and key not in (operators[0], *needed)]
        if excess:
            raise ValueError(f"{excess[0]!r} does not belong to {operators[0]!r}")
        limited = value["rate"] if operators == ["rate"] else value
        if operators[0] in ("count", "rate") and isinstance(limited, dict) and not {"at_least", "at_most"} & {*limited}:
            raise ValueError(f"{operators[0]!r} needs a limit: at_least, at_most or both")
        for key in needed:
            if value.get(key) is None and key not in _OPTIONAL:
                raise ValueError(f"{operators[0]!r} needs the key {key!r}")
        return value

    def expectation(self) -> Expectation:
        """Return the expectation.

        Raises:
            UsageError: the limits of `count` are in the wrong order.
        """
        match self:
            case ExpectationSpec(always=str(condition)):
                return expectations.always(condition)
            case ExpectationSpec(never=str(condition)):
                return expectations.never(condition)
            case ExpectationSpec(within=float(time), reach=str(condition)):
                return expectations.within(time, condition)
            case ExpectationSpec(until=str(reached), keep=str(condition)):
                return expectations.until(condition, reached)
            case ExpectationSpec(holds=str(condition), for_=float(time)):
                return expectations.holds(time, condition)
            case ExpectationSpec(settles=str(condition), after=float(time)):
                return expectations.settles(time, condition)
            case ExpectationSpec(count=str(condition)):
                return expectations.count(condition, self.at_least or 0, _limit(self.at_most))
            case ExpectationSpec(rate=RateSpec() as rate):
                return expectations.rate(rate.topic, rate.at_least, _limit(rate.at_most), rate.over)
        assert self.latency is not None
        return expectations.latency(self.latency.topic, self.latency.at_most)


def _limit(number: float | None) -> float:
    return math.inf if number is None else number
