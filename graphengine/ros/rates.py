"""How often messages come and how late, in the words of ros2cli; times are nanoseconds."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

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


class Window:
    """The newest values.

    Args:
        size: how many.
    """

    def __init__(self, size: int) -> None:
        self._values: deque[int] = deque(maxlen=size)

    def add(self, value: int) -> None:
        """Take a value; the oldest goes when there are too many."""
        self._values.append(value)

    def clear(self) -> None:
        """Forget all."""
        self._values.clear()

    def summary(self) -> Summary | None:
        """Of what is there; None of nothing."""
        if not self._values:
            return None
        number = len(self._values)
        mean = sum(self._values) / number
        deviation = math.sqrt(sum((value - mean) ** 2 for value in self._values) / number)
        return Summary(mean, min(self._values), max(self._values), deviation, number)


class Intervals:
    """The time between messages.

    Args:
        size: how many intervals count.
    """

    def __init__(self, size: int) -> None:
        self._window = Window(size)
        self._last: int | None = None
        self._told: int | None = None

    def add(self, now: int) -> bool:
        """Count a message; false when the clock was set back, so that counting begins anew."""
        forward = self._last is None or now >= self._last
        if not forward:
            self._window.clear()
            self._told = None
        elif self._last is not None:
            self._window.add(now - self._last)
            self._told = now if self._told is None else self._told
        self._last = now
        return forward

    def report(self) -> Summary | None:
        """What there is to tell, once a second of the clock that messages are timed with."""
        if self._last is None or self._told is None or self._last < self._told + SECOND:
            return None
        self._told = self._last
        return self._window.summary()
