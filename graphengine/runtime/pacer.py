"""Ticks at equal distances of wall time."""

from __future__ import annotations

import time

SLOWEST = 0.01
"""Least factor of real time."""


class Pacer:
    """Absolute deadlines; what is more than five periods late starts a new count instead of a race to catch up.

    Args:
        period: s of wall time from one tick to the next.
    """

    PATIENCE = 5

    def __init__(self, period: float) -> None:
        self.period = period
        self.begin()

    def begin(self) -> None:
        """Count anew; the first tick is due at once."""
        self._due = time.perf_counter()

    def early(self) -> float:
        """Seconds until the next tick is due; negative when it is late."""
        return self._due - time.perf_counter()

    def count(self) -> bool:
        """Count an executed tick; return whether it was late: it ended after the next one was due."""
        self._due += self.period
        late = -self.early()
        if late > self.PATIENCE * self.period:
            self.begin()
        return late > 0.0
