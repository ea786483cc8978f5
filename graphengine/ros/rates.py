"""How often messages come and how late, in the words of ros2cli; times are nanoseconds."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from dataclasses import dataclass
from statistics import fmean, pstdev

SECOND = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Summary:
    """Of the values in a window, whose own deviation it tells, not that of what they are a sample of."""

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
        """The summary of a window; None of an empty one."""
        if not window:
            return None
        return Summary(fmean(window), min(window), max(window), pstdev(window), len(window))


class Intervals:
    """The time between messages.

    Args:
        size: how many intervals count.
    """

    def __init__(self, size: int) -> None:
        self._window: deque[int] = deque(maxlen=size)
        self._last: int | None = None
        self._told: int | None = None

    def add(self, now: int) -> bool:
        """Count a message; false when the clock was set back, so that counting begins anew."""
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
        """What there is to tell, once a second of the clock that messages are timed with."""
        if self._last is None or self._told is None or self._last < self._told + SECOND:
            return None
        self._told = self._last
        return Summary.of(self._window)
