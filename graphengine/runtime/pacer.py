"""Schedules ticks at equal intervals of wall time."""

from __future__ import annotations

import time

SLOWEST = 0.01
"""Smallest real-time factor."""


class Pacer:
    """Computes the deadlines of ticks. After a delay of more than five periods it restarts from now instead of catching up.

    Args:
        period: wall time between two ticks, s.
    """

    PATIENCE = 5

    def __init__(self, period: float) -> None:
        self.period = period
        self.begin()

    def begin(self) -> None:
        """Restart; the next tick is due immediately."""
        self._due = time.perf_counter()

    def early(self) -> float:
        """Return the time until the next tick is due, s; negative if it is late."""
        return self._due - time.perf_counter()

    def count(self) -> bool:
        """Count an executed tick; return whether it ended after the next tick was due."""
        self._due += self.period
        late = -self.early()
        if late > self.PATIENCE * self.period:
            self.begin()
        return late > 0.0
