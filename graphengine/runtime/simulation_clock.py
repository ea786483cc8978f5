"""Simulation time in ticks, as a running session counts it."""

from __future__ import annotations


class SimulationClock:
    """Time counted in ticks: `tick * numerator / denominator`, so that nothing adds up."""

    __slots__ = (
        "_denominator",
        "_numerator",
        "_past",
        "_wall_time",
        "delta",
        "frame",
        "monotonic_time",
        "period",
        "time",
        "wall_time_was_read",
    )

    def __init__(self, period: tuple[int, int]) -> None:
        self.period = self._numerator, self._denominator = period
        self.delta: float = period[0] / period[1]
        self.wall_time = 0.0
        self._past = 0
        self.set_frame(0)

    @property
    def wall_time(self) -> float:
        """Seconds since 1970 when the tick began."""
        self.wall_time_was_read = True
        return self._wall_time

    @wall_time.setter
    def wall_time(self, seconds: float) -> None:
        self._wall_time = seconds
        self.wall_time_was_read = False

    def set_frame(self, frame: int) -> None:
        """Go to a tick since play."""
        self.frame = frame
        self.time: float = frame * self._numerator / self._denominator
        self.monotonic_time: float = (self._past + frame) * self._numerator / self._denominator

    def stop(self) -> None:
        """Back to 0; monotonic time stays where it is."""
        self._past += self.frame
        self.set_frame(0)
