"""Temporal operators: each judges a sequence of samples, with constant time and memory per sample.

A sample is the value of a condition at a time: whether the condition holds, and its margin. The margin of `a < b` is `b - a`,
which is positive if the condition holds and negative if it does not. The robustness of a verdict is the distance from the
opposite verdict, in the unit of the margin unless the operator documents another one. It follows the quantitative semantics of
signal temporal logic (Donzé and Maler, "Robust Satisfaction of Temporal Logic over Real-Valued Signals", FORMATS 2010).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Literal, NamedTuple

Outcome = Literal["open", "passed", "failed"]

TIME_ERROR = 1e-9
"""Difference up to which two times count as equal, s; the times of ticks are rounded products."""


class Sample(NamedTuple):
    """The value of a condition at a time.

    Attributes:
        holds: whether the condition holds.
        margin: distance from the limit, positive if the condition holds; infinite for conditions without numbers.
    """

    holds: bool
    margin: float


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a run meets an expectation.

    Attributes:
        outcome: `open` until the samples decide it.
        decided: time at which the outcome was decided, s; None while it is open.
        robustness: distance from the other outcome, negative if the expectation is not met; NaN without samples.
        time: time of the sample that determines the robustness, s; NaN without samples.
    """

    outcome: Outcome
    decided: float | None
    robustness: float
    time: float


class Operator(ABC):
    """Judges samples in chronological order.

    Samples after the decision still change the robustness, which therefore covers the whole run.

    Attributes:
        begin: time from which durations are measured, s.
        outcome: `open` until the samples decide it.
        now: time of the newest sample, s.
        quiet: margin from which a sample that holds changes only `now`; NaN if there is no such margin.
    """

    def __init__(self) -> None:
        self.begin = self.now = 0.0
        self.quiet = math.nan
        self.outcome: Outcome = "open"
        self._decided: float | None = None
        self._robustness = self._time = math.nan

    @property
    def verdict(self) -> Verdict:
        """The verdict on the samples so far."""
        return Verdict(self.outcome, self._decided, self._robustness, self._time)

    @abstractmethod
    def add(self, time: float, holds: bool, margin: float, /) -> bool:
        """Judge a sample, and return whether it decides the outcome; `time` is the time of the sample, s."""

    def end(self) -> None:
        """Decide an open verdict after the last sample."""
        self._decide(self._is_met())

    @abstractmethod
    def _is_met(self) -> bool:
        """Return whether an undecided expectation is met by a run that ends now."""

    def _decide(self, met: bool) -> bool:
        if self.outcome != "open":
            return False
        self.outcome, self._decided = "passed" if met else "failed", self.now
        return True

    def _lower(self, robustness: float) -> None:
        if not self._robustness <= robustness:
            self._robustness, self._time = float(robustness), self.now

    def _raise(self, robustness: float) -> None:
        if not self._robustness >= robustness:
            self._robustness, self._time = float(robustness), self.now


class Always(Operator):
    """The condition holds in all samples; it fails at the first sample in which the condition does not hold.

    The robustness is the smallest margin.

    Args:
        after: time for the condition to settle, s; earlier samples do not count. If the run ends within this time, only its last
            sample counts.
    """

    def __init__(self, after: float = 0.0) -> None:
        super().__init__()
        self._after = after
        self._counts = False
        self._held = True

    def add(self, time: float, holds: bool, margin: float) -> bool:
        """Judge a sample."""
        self.now = time
        if not self._counts:
            self._robustness = math.nan  # discards the samples that do not count
            self._counts = time - self.begin >= self._after - TIME_ERROR
        self._held = holds
        self._lower(margin)
        self.quiet = self._robustness if self._counts else math.nan
        return self._counts and not holds and self._decide(False)

    def _is_met(self) -> bool:
        return self._held


class Within(Operator):
    """The condition holds in at least one sample of the first seconds; it passes at the first such sample.

    The robustness is the largest margin in this time.

    Args:
        seconds: the duration, s; infinite for the whole run.
    """

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self._seconds = seconds

    def add(self, time: float, holds: bool, margin: float) -> bool:
        """Judge a sample."""
        self.now = time
        if time - self.begin > self._seconds + TIME_ERROR:
            return self._decide(False)
        self._raise(margin)
        return holds and self._decide(True)

    def _is_met(self) -> bool:
        return False


class Until(Operator):
    """The second condition holds in a sample, and the first condition holds in all samples before it.

    The robustness is the maximum over all samples of min(margin of the second condition, all earlier margins of the first one).
    """

    def __init__(self) -> None:
        super().__init__()
        self._before = math.inf

    def add(self, time: float, holds: bool, margin: float, reached: bool = False, second: float = -math.inf) -> bool:
        """Judge a sample of each condition; `reached` and `second` are the value and the margin of the second condition."""
        self.now = time
        self._raise(min(second, self._before))
        if margin < self._before:
            self._before = float(margin)
        return (reached or not holds) and self._decide(reached)

    def _is_met(self) -> bool:
        return False


class Holds(Operator):
    """The condition holds without interruption for a duration; it passes at the end of the first such duration.

    The robustness is the longest time for which the condition held, minus the duration, s.

    Args:
        seconds: the duration, s.
    """

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self._seconds = seconds
        self._since: float | None = None

    def add(self, time: float, holds: bool, margin: float) -> bool:
        """Judge a sample."""
        self.now, elapsed = time, time - self.begin
        self._since = (elapsed if self._since is None else self._since) if holds else None
        length = 0.0 if self._since is None else elapsed - self._since
        self._raise(length - self._seconds)
        return holds and length >= self._seconds - TIME_ERROR and self._decide(True)

    def _is_met(self) -> bool:
        return False


class Count(Operator):
    """The number of times that the condition becomes true is within limits.

    The robustness is the distance of the number from the nearer limit.

    Args:
        at_least: smallest number.
        at_most: largest number; infinite for no limit.
    """

    def __init__(self, at_least: float = 0, at_most: float = math.inf) -> None:
        super().__init__()
        self._limits = at_least, at_most
        self._number, self._held = 0, False

    def add(self, time: float, holds: bool, margin: float) -> bool:
        """Judge a sample."""
        if holds and not self._held:
            self._number += 1
        self.now, self._held = time, holds
        low, high = self._limits
        self._robustness, self._time = min(self._number - low, high - self._number), time
        if self._number > high:
            return self._decide(False)
        return self._number >= low and high == math.inf and self._decide(True)

    def _is_met(self) -> bool:
        low, high = self._limits
        return low <= self._number <= high
