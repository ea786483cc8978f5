"""Computes when ticks are due at equal intervals of wall time."""

from __future__ import annotations

import time

SLOWEST = 0.01
"""Smallest legal real-time factor."""


class Pacer:
    """Computes when the next tick is due; after a delay of more than `PATIENCE` periods, the schedule restarts.

    Args:
        period: wall time between two ticks, s.
    """

    PATIENCE = 5
    """Largest delay for which a run catches up, in tick periods."""

    def __init__(self, period: float) -> None:
        self.period = period
        self.begin()

    def begin(self) -> None:
        """Restart the schedule; the next tick is due immediately."""
        self._due = time.perf_counter()

    def early(self) -> float:
        """Return the wall time until the next tick is due, s; negative if the tick is late."""
        return self._due - time.perf_counter()

    def count(self) -> bool:
        """Advance the schedule by one executed tick; return whether this tick ended after the next tick was due."""
        self._due += self.period
        late = -self.early()
        if late > self.PATIENCE * self.period:
            self.begin()
        return late > 0.0
