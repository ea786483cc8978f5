"""The clock as a data node (`omni.graph.nodes`)."""

from __future__ import annotations

from graphengine.node import Out
from graphengine.nodes.clocked import ClockNode


class ReadTime(ClockNode, type="omni.graph.nodes.ReadTime", volatile=True):
    """Reads the clock of the simulation; a stop resets `time` to 0, and in the first tick it is one tick period."""

    absolute_sim_time: float = Out(unit="s", doc="simulation time since the session began; a stop does not reset it")
    delta_seconds: float = Out(unit="s", doc="time between two passes of the graph")
    frame: float = Out(doc="number of the tick since play; the first is 1")
    is_playing: bool = Out(doc="always true: graphs run only while the simulation plays")
    time: float = Out(unit="s", doc="simulation time since play")
    time_since_start: float = Out(unit="s", doc="equal to `absoluteSimTime`")

    def compute(self) -> None:
        """Read the clock."""
        clock = self.clock
        self.time, self.frame, self.delta_seconds = clock.time, float(clock.frame), clock.delta
        self.absolute_sim_time = self.time_since_start = clock.monotonic_time
        self.is_playing = True
