"""The entries of `expect:` and `metrics:` in a scenario file, each with one operator as a key: `always: tilt("dd100") < 0.1`."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any

from pydantic import Field, model_validator

from graphengine.api.expectations import expectations
from graphengine.api.expectations.expectations import Expectation
from graphengine.api.expectations.metrics import FOLDS, Metric
from graphengine.format.spec import Duration, FileSpec, NotNegative, Period
from graphengine.format.wording import listing

_OPERATORS: Mapping[str, tuple[Callable[..., Expectation], Mapping[str, str]]] = {
    "always": (expectations.always, {"condition": "always"}),
    "never": (expectations.never, {"condition": "never"}),
    "within": (expectations.within, {"seconds": "within", "condition": "reach"}),
    "until": (expectations.until, {"reached": "until", "condition": "keep"}),
    "holds": (expectations.holds, {"condition": "holds", "seconds": "for"}),
    "settles": (expectations.settles, {"condition": "settles", "seconds": "after"}),
    "count": (expectations.count, {"condition": "count", "at_least": "at_least", "at_most": "at_most"}),
    "rate": (expectations.rate, {}),
    "latency": (expectations.latency, {}),
}
"""For each operator, its function and the keys of the arguments; those of `rate` and `latency` are in a mapping of their own."""
_OPTIONAL = ("at_least", "at_most")
_KEYS = {*_OPERATORS, *(key for _, keys in _OPERATORS.values() for key in keys.values())}


def _only_operator(entry: Mapping[str, Any], operators: Collection[str]) -> str:
    """Return the only key of an entry that is an operator.

    Raises:
        ValueError: the entry has no operator, or several ones.
    """
    found = [key for key in entry if key in operators]
    if len(found) != 1:
        names = " and ".join(map(repr, found)) or "none"
        raise ValueError(f"expected one operator, got {names}; {listing(operators, 'operators')}")
    return found[0]


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
        operator = _only_operator(value, _OPERATORS)
        if value[operator] is None:
            raise ValueError(f"{operator!r} needs a value")
        needed = [key for key in _OPERATORS[operator][1].values() if key != operator]
        excess = [key for key in value if key in _KEYS and key not in (operator, *needed)]
        if excess:
            raise ValueError(f"{excess[0]!r} does not belong to {operator!r}")
        limited = value["rate"] if operator == "rate" else value
        if operator in ("count", "rate") and isinstance(limited, dict) and not {*_OPTIONAL} & {*limited}:
            raise ValueError(f"{operator!r} needs a limit: at_least, at_most or both")
        for key in needed:
            if value.get(key) is None and key not in _OPTIONAL:
                raise ValueError(f"{operator!r} needs the key {key!r}")
        return value

    def expectation(self) -> Expectation:
        """Return the expectation.

        Raises:
            UsageError: the limits of `count` are in the wrong order.
        """
        given = self.model_dump(by_alias=True, exclude_none=True)
        operator = _only_operator(given, _OPERATORS)
        expectation, keys = _OPERATORS[operator]
        if not keys:
            return expectation(**given[operator])
        return expectation(**{argument: given[key] for argument, key in keys.items() if key in given})


class MetricSpec(FileSpec):
    """A number that describes a run: one operator, with its expression."""

    min: str | None = None
    """Expression whose smallest value in all ticks is the metric."""
    max: str | None = None
    """Expression whose largest value in all ticks is the metric, as `velocity("dd100").linear[0]`."""
    mean: str | None = None
    """Expression whose mean over all ticks is the metric."""
    final: str | None = None
    """Expression whose value in the last tick is the metric."""
    time_to: str | None = None
    """Condition; the metric is the simulation time at which it first holds, s."""

    @model_validator(mode="before")
    @classmethod
    def _is_one_operator(cls, value: Any) -> Any:
        if isinstance(value, dict):
            _only_operator(value, FOLDS)
        return value

    def metric(self) -> Metric:
        """Return the metric."""
        (operator,) = self.model_fields_set
        return Metric(operator, getattr(self, operator))
