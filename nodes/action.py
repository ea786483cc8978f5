"""Events of the timeline (`omni.graph.action`)."""

from __future__ import annotations

from graphengine.context import Clock, Context
from graphengine.node import ExecOut, Node, Out, State


class OnPlaybackTick(Node, type="omni.graph.action.OnPlaybackTick"):
    """Fires once a tick while the simulation plays."""

    tick = ExecOut(doc="fires every tick")
    delta_seconds: float = Out(unit="s", doc="time between two ticks")
    frame: float = Out(doc="number of the tick since play; the first is 1")
    time: float = Out(unit="s", doc="simulation time; the first tick is at one tick period")

    clock: Clock = State()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock

    def compute(self) -> None:
        """Read the clock."""
        clock = self.clock
        self.delta_seconds = clock.delta
        self.frame = float(clock.frame)
        self.time = clock.time
