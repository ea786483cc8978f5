"""The simulation clock that nodes read."""

from __future__ import annotations

from graphengine.format.stateful import Stateful


class Clock(Stateful):
    """The simulation time that the nodes of a graph read. The time changes only between two executions of the graph.

    The period of the clock is the time between two executions: a tick or a physics step. The period in seconds is stored
    as a fraction, and the time is `frame * numerator / denominator`, so rounding errors do not accumulate.

    Attributes:
        time: simulation time since the start of play, s; one period at the first execution.
        monotonic_time: simulation time since the session began, s. A stop does not reset it.
        delta: period of the clock, s.
        period: period of the clock as an exact fraction: numerator and denominator, s.
        frame: number of this tick or physics step since the start of play; the first is 1.
        wall_time_was_read: whether a node read `wall_time` in this tick.
    """

    kept = ("_past", "_wall_time", "frame", "monotonic_time", "time", "wall_time_was_read")

    def __init__(self, period: tuple[int, int]) -> None:
        self.period = self._numerator, self._denominator = period
        self.delta: float = period[0] / period[1]
        self.wall_time = 0.0
        self._past = 0
        self.set_frame(0)

    @property
    def wall_time(self) -> float:
        """Wall-clock time at the start of the tick, in seconds since the Unix epoch."""
        self.wall_time_was_read = True
        return self._wall_time

    @wall_time.setter
    def wall_time(self, seconds: float) -> None:
        self._wall_time = seconds
        self.wall_time_was_read = False

    def set_frame(self, frame: int) -> None:
        """Set `frame`, and compute `time` and `monotonic_time` from it."""
        self.frame = frame
        self.time: float = frame * self._numerator / self._denominator
        self.monotonic_time: float = (self._past + frame) * self._numerator / self._denominator

    def stop(self) -> None:
        """Reset `frame` and `time` to 0; `monotonic_time` keeps its value."""
        self._past += self.frame
        self.set_frame(0)
