"""Expectations: statements about a run that a session judges while it runs.

with ge.load("dd100_warehouse").session(seed=3) as sim:
    sim.expect(always("tilt('dd100') < 0.1"))
    arrives = sim.expect(within(10.0, "distance('dd100', [-3, 9]) < 0.1"))
    sim.run(30.0, until=sim.decided)
    sim.judge()
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from graphengine.api.after_tick import AfterTick
from graphengine.api.checks import Check, Outcome
from graphengine.api.expectations.conditions import Condition
from graphengine.api.expectations.judging import Judging
from graphengine.api.expectations.operators import Always, Count, Holds, Operator, Until, Verdict, Within
from graphengine.api.expectations.reading_types import Readings, ReadingState
from graphengine.api.expectations.readings import SessionSource, Source, readings_of
from graphengine.api.session import Session
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.stateful import Stateful

_READ = 200
"""Maximum number of characters of a value in a report."""
_ROUNDING = 1e-9
"""Largest absolute value that a report shows as 0."""
_ELEMENTS = 8
"""Maximum number of elements of a list that a report formats individually."""


@dataclass(frozen=True, slots=True)
class Expectation:
    """A statement about a run; `Session.expect` begins to judge it.

    Attributes:
        text: the statement, for reports.
        conditions: the conditions; one, or two for `until`.
        make: returns a new operator, which judges the samples of the conditions.
        inverted: whether the operator judges the opposite of the condition.
    """

    text: str
    conditions: tuple[str, ...]
    make: Callable[[], Operator]
    inverted: bool = False

    def __call__(self, session: Session) -> ExpectationCheck:
        """Begin to judge a session.

        Raises:
            UsageError: a condition is not legal, or names something that the session does not have.
        """
        return ExpectationCheck(self, SessionSource(session), readings_of(session))


def always(condition: str) -> Expectation:
    """Expect a condition to hold after every tick.

    >>> check = sim.expect(always("tilt('dd100') < 0.1"))
    >>> sim.run(1.0)
    True
    >>> sim.judge()
    >>> check.verdict.robustness > 0.09  # rad
    True
    """
    return Expectation(f"always {condition}", (condition,), Always)


def never(condition: str) -> Expectation:
    """Expect a condition not to hold after any tick."""
    return Expectation(f"never {condition}", (condition,), Always, inverted=True)


def within(seconds: float, condition: str) -> Expectation:
    """Expect a condition to hold after at least one tick of the next `seconds` of simulation."""
    return Expectation(f"within {seconds:g} s: {condition}", (condition,), lambda: Within(_duration(seconds)))


def until(condition: str, reached: str) -> Expectation:
    """Expect a condition to hold until another one holds, which must happen before the run ends."""
    return Expectation(f"{condition} until {reached}", (condition, reached), Until)


def holds(seconds: float, condition: str) -> Expectation:
    """Expect a condition to hold without interruption for `seconds` of simulation, at any time of the run."""
    return Expectation(f"holds for {seconds:g} s: {condition}", (condition,), lambda: Holds(_duration(seconds)))


def settles(seconds: float, condition: str) -> Expectation:
    """Expect a condition to hold after every tick from `seconds` of simulation on; earlier ticks do not count."""
    return Expectation(f"settles in {seconds:g} s: {condition}", (condition,), lambda: Always(_duration(seconds)))


def count(condition: str, at_least: int = 0, at_most: float = math.inf) -> Expectation:
    """Expect a condition to become true `at_least` to `at_most` times; a condition that is true at first counts as one time."""
    if not 0 <= at_least <= at_most:
        raise UsageError(f"count: expected 0 <= at_least <= at_most, got {at_least!r} and {at_most!r}")
    return Expectation(f"{at_least} to {at_most:g} times: {condition}", (condition,), lambda: Count(at_least, at_most))


def rate(topic: str, at_least: float = 0.0, at_most: float = math.inf, over: float = 1.0) -> Expectation:
    """Expect the messages of a topic to arrive at a rate, Hz, in each interval of `over` seconds of simulation.

    The measured rate is a whole number of messages divided by `over`, so its resolution is 1 / `over`.
    """
    parts = [f"at least {at_least:g}" * (at_least > 0.0), f"at most {at_most:g}" * (at_most < math.inf)]
    text = f"rate of {topic}: {' and '.join(filter(None, parts)) or 'any'} Hz in each {over:g} s"
    return Expectation(text, (_bounded(f"rate({topic!r}, {float(over)!r})", at_least, at_most),), Always)


def latency(topic: str, at_most: float) -> Expectation:
    """Expect each message of a topic to arrive at most `at_most` seconds of simulation after its stamp."""
    return Expectation(f"latency of {topic}: at most {at_most:g} s", (f"age({topic!r}) <= {float(at_most)!r}",), Always)


def _shown(value: Any) -> str:
    """Return a value as text, with few digits."""
    if isinstance(value, float):
        return f"{value:.6g}" if abs(value) > _ROUNDING else "0"
    if isinstance(value, tuple | list | np.ndarray) and len(value) <= _ELEMENTS:
        return f"({', '.join(map(_shown, value))})"
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = [field.name for field in dataclasses.fields(value) if not field.name.startswith("_")]
        return ", ".join(f"{name} {_shown(getattr(value, name))}" for name in names)
    return str(value)


def _bounded(value: str, least: float, most: float) -> str:
    """Return the condition `least` <= value <= `most`, without an infinite upper limit or a lower limit of 0."""
    if math.isinf(most):
        return f"{float(least)!r} <= {value}"
    return f"{float(least)!r} <= {value} <= {float(most)!r}" if least > 0.0 else f"{value} <= {float(most)!r}"


def _duration(seconds: float) -> float:
    if not seconds >= 0.0:
        raise UsageError(f"expected a duration of 0 s or more, got {seconds!r}")
    return seconds


class ExpectationCheck(Check, Stateful):
    """The judgement of one expectation in one session or bag.

    A reset of the time restarts the judgement. Checkpoints contain its state.

    Attributes:
        expectation: the statement that is judged.
        conditions: the conditions of the expectation.
        operator: judges the samples of the conditions.
        error: why the expectation cannot be judged; empty if there is no error.
        trace: time (s) and margin of each sample, if the caller sets a list before the run; otherwise None.
    """

    kept = ("operator", "error", "_values")

    def __init__(self, expectation: Expectation, source: Source, readings: Readings) -> None:
        self.expectation = expectation
        self.source = source
        self.conditions = [Condition(text, readings) for text in expectation.conditions]
        self.inverted = expectation.inverted
        self.trace: list[tuple[float, float]] | None = None
        self._begin()

    def save(self) -> Any:
        """Return a copy of the state of the judgement and of its readings."""
        return super().save(), [state.save() for state in self._states()]

    def restore(self, saved: Any) -> None:
        """Restore a saved state."""
        own, states = saved
        super().restore(own)
        for state, kept in zip(self._states(), states, strict=True):
            state.restore(kept)

    def _states(self) -> list[ReadingState]:
        return [state for condition in self.conditions for state in condition.states]

    def _begin(self) -> None:
        self.operator = self.expectation.make()
        self.operator.begin = self.source.time
        self.error = ""
        self._values: dict[str, str] = {}
        """Values of the readings in the tick that decided the outcome, as text."""

    def restart(self) -> None:
        """Restart the judgement at the current time."""
        self._begin()
        for state in self._states():
            state.reset()

    @property
    def outcome(self) -> Outcome:
        """The outcome so far."""
        return "error" if self.error else self.operator.outcome

    @property
    def verdict(self) -> Verdict:
        """The verdict so far, with its robustness."""
        return self.operator.verdict

    def begin(self, actions: dict[object, AfterTick]) -> None:
        """Let the session judge the expectation after each tick, together with those that began before it in the same tick."""
        newest = next(reversed(actions.values()), None)
        if not isinstance(newest, Judging) or not newest.is_new:
            newest = Judging(self.source)
            actions[newest] = newest
        newest.change(*newest.checks, self)

    def stop(self, actions: dict[object, AfterTick]) -> None:
        """Stop the judgement. Safe to call twice."""
        for action in tuple(actions.values()):
            if isinstance(action, Judging) and self in action.checks:
                action.change(*(check for check in action.checks if check is not self))

    def end(self) -> None:
        """Decide the outcome at the end of the run."""
        if self.outcome == "open":
            if math.isnan(self.verdict.robustness):
                self.error = "never had a value; the run was too short, or a topic had no messages"
                return
            self.operator.end()
            self.note_values()

    def find_error(self) -> None:
        """Set `error` if a condition cannot be sampled now."""
        try:
            for condition in self.conditions:
                condition.sample()
        except GraphError as error:
            self.error = str(error)

    def note_values(self) -> None:
        """Keep the values of the readings for the report, and mark the decision in the recording."""
        self.source.mark(f"{self.outcome}: {self.expectation.text}")
        values = [pair for condition in self.conditions for pair in condition.values().items()]
        self._values = {text: _shown(value)[:_READ] for text, value in values}

    def report(self) -> str:
        """Return the outcome, the statement, the time of the decision, the robustness, and the values of the readings."""
        verdict, text = self.verdict, self.expectation.text
        if self.error:
            return f"error: {text}\n  {self.error}"
        if verdict.decided is None:
            return f"open: {text}"
        lines = [f"{verdict.outcome}: {text}", f"  decided at {verdict.decided:.3f} s"]
        if math.isfinite(verdict.robustness):
            lines.append(f"  robustness {verdict.robustness:.4g}, at {verdict.time:.3f} s")
        return "\n".join([*lines, *(f"  {name} = {value}" for name, value in self._values.items())])

    def __repr__(self) -> str:
        return f"<{self.outcome}: {self.expectation.text}>"
