"""Events of the timeline (`omni.graph.action`)."""

from __future__ import annotations

from graphengine.context import Clock, Context
from graphengine.diagnostics import ContextError
from graphengine.node import ExecOut, Node, Out, State


class OnPlaybackTick(Node, type="omni.graph.action.OnPlaybackTick"):
    """Fires once a tick while the simulation plays, in a graph with `runs: tick`, which is what graphs do by default."""

    tick = ExecOut(doc="fires every tick")
    delta_seconds: float = Out(unit="s", doc="time between two ticks")
    frame: float = Out(doc="number of the tick since play; the first is 1")
    time: float = Out(unit="s", doc="simulation time; the first tick is at one tick period")

    clock: Clock = State()

    def setup(self, context: Context) -> None:
        """Bind the clock, which counts ticks.

        Raises:
            ContextError: the graph runs at every physics step.
        """
        if context.runs != "tick":
            raise ContextError(
                "it fires in graphs that run once a tick, and this one runs at every physics step",
                None,
                "use OnPhysicsStep, or write `runs: tick` into the graph file",
            )
        self.clock = context.clock

    def compute(self) -> None:
        """Read the clock."""
        clock = self.clock
        self.delta_seconds = clock.delta
        self.frame = float(clock.frame)
        self.time = clock.time
