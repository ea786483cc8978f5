"""Measures the rate and delay of messages as ros2cli does; times are in nanoseconds."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from dataclasses import dataclass
from statistics import fmean, pstdev

SECOND = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Summary:
    """Statistics of a window of times, ns; `deviation` is the population standard deviation."""

    mean: float
    least: int
    most: int
    deviation: float
    number: int

    def __str__(self) -> str:
        least, most, deviation = (value / SECOND for value in (self.least, self.most, self.deviation))
        return f"\tmin: {least:.3f}s max: {most:.3f}s std dev: {deviation:.5f}s window: {self.number}"

    @staticmethod
    def of(window: Collection[int]) -> Summary | None:
        """Return the statistics of a window; None if it is empty."""
        if not window:
            return None
        return Summary(fmean(window), min(window), max(window), pstdev(window), len(window))


class Intervals:
    """Measures the time between messages.

    Args:
        size: number of most recent intervals that the statistics cover.
    """

    def __init__(self, size: int) -> None:
        self._window: deque[int] = deque(maxlen=size)
        self._last: int | None = None
        self._told: int | None = None

    def add(self, now: int) -> bool:
        """Add the time of a message, ns. If the clock has jumped back, restart the measurement and return False."""
        forward = self._last is None or now >= self._last
        if not forward:
            self._window.clear()
            self._told = None
        elif self._last is not None:
            self._window.append(now - self._last)
            self._told = now if self._told is None else self._told
        self._last = now
        return forward

    def report(self) -> Summary | None:
        """Return the statistics, or None if the last report is less than 1 s old by the clock of the messages."""
        if self._last is None or self._told is None or self._last < self._told + SECOND:
            return None
        self._told = self._last
        return Summary.of(self._window)
