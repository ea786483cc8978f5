"""A data node that reads the simulation clock (`omni.graph.nodes`)."""

from __future__ import annotations

from graphengine.node import Out
from graphengine.nodes.clocked import ClockNode


class ReadTime(ClockNode, type="omni.graph.nodes.ReadTime", volatile=True):
    """Reads the clock of the simulation.

    A stop resets `time` to 0. In the first tick, `time` is one tick period.
    """

    absolute_sim_time: float = Out(unit="s", doc="simulation time since the session began; not reset by a stop")
    delta_seconds: float = Out(unit="s", doc="simulation time between two executions of the graph")
    frame: float = Out(doc="number of the tick since play; the first is 1")
    is_playing: bool = Out(doc="always true: graphs run only while the simulation plays")
    time: float = Out(unit="s", doc="simulation time since play")
    time_since_start: float = Out(unit="s", doc="equal to `absoluteSimTime`")

    def compute(self) -> None:
        """Set the outputs to the current values of the clock."""
        clock = self.clock
        self.time, self.frame, self.delta_seconds = clock.time, float(clock.frame), clock.delta
        self.absolute_sim_time = self.time_since_start = clock.monotonic_time
        self.is_playing = True
