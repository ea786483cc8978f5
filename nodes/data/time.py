"""Time (`omni.graph.nodes`)."""

from __future__ import annotations

from graphengine.node import Out
from graphengine.nodes.clocked import ClockNode


class ReadTime(ClockNode, type="omni.graph.nodes.ReadTime", volatile=True):
    """Simulation time in several forms; the first tick is at one tick period, and a stop sets time back to 0."""

    absolute_sim_time: float = Out(unit="s", doc="simulation time since the session began, over all plays")
    delta_seconds: float = Out(unit="s", doc="time between two passes of the graph")
    frame: float = Out(doc="number of the tick since play; the first is 1")
    is_playing: bool = Out(doc="true whenever a graph runs")
    time: float = Out(unit="s", doc="simulation time")
    time_since_start: float = Out(unit="s", doc="the same as absoluteSimTime")

    def compute(self) -> None:
        """Read it."""
        clock = self.clock
        self.time, self.frame, self.delta_seconds = clock.time, float(clock.frame), clock.delta
        self.absolute_sim_time = self.time_since_start = clock.monotonic_time
        self.is_playing = True
