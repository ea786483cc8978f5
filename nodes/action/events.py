"""Event nodes that fire at the start of a tick (`omni.graph.action`)."""

from __future__ import annotations

from graphengine.node import Bound, Clock, Context, ContextError, ExecOut, Fire, In, Node, Out, State, Variable
from graphengine.node.types import Token, UInt


class TickEvent(Node):
    """Base of event nodes that count ticks with the clock of their graph. The graph must run once a tick."""

    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        """Store the clock of the node's graph in `clock`.

        Raises:
            ContextError: the graph runs at every physics step instead of once a tick.
        """
        if context.runs != "tick":
            text = "the node needs a graph that runs once a tick, but this graph runs at every physics step"
            raise ContextError(text, None, "use OnPhysicsStep, or write `runs: tick` into the graph file")
        self.clock = context.clock


class OnPlaybackTick(TickEvent, type="omni.graph.action.OnPlaybackTick"):
    """Fires once a tick while the simulation plays, in a graph with `runs: tick` (the default)."""

    tick = ExecOut(doc="fires every tick")
    delta_seconds: float = Out(unit="s", doc="simulation time between two ticks")
    frame: float = Out(doc="number of the tick since play; the first is 1")
    time: float = Out(unit="s", doc="simulation time since play; one tick period in the first tick")

    def compute(self) -> None:
        """Output the tick period, the tick number and the simulation time."""
        clock = self.clock
        self.delta_seconds, self.frame, self.time = clock.delta, float(clock.frame), clock.time


class OnTick(TickEvent, type="omni.graph.action.OnTick", gated=True):
    """Fires in the first tick of play, then every `framePeriod` + 1 ticks.

    The node needs a graph with `runs: tick` (the default).
    """

    frame_period: UInt = In(default=0, doc="number of ticks to skip between two firings; 0: fire in every tick")
    only_playback: bool = In(default=True, doc="no effect: graphs run only while the simulation plays")
    tick = ExecOut()
    time: float = Out(unit="s", doc="simulation time since play")
    delta_seconds: float = Out(unit="s", doc="simulation time since the previous firing; at the first, since play")
    frame: float = Out(doc="number of the tick since play; the first is 1")
    is_playing: bool = Out()
    absolute_sim_time: float = Out(unit="s", doc="simulation time since the session began; a stop does not reset it")
    time_since_start: float = Out(unit="s", doc="simulation time since the session began; a stop does not reset it")

    accumulated_seconds: float = State(default=0.0)
    frame_count: UInt = State(default=0)
    fired: bool = State(default=False)

    def compute(self) -> Fire:
        """Count the tick; if enough ticks have passed, set the outputs and fire."""
        clock = self.clock
        self.accumulated_seconds += clock.delta
        self.frame_count += 1
        if self.fired and self.frame_count <= self.frame_period:
            return None
        self.fired = True
        self.time, self.frame, self.is_playing = clock.time, float(clock.frame), True
        self.absolute_sim_time = self.time_since_start = clock.monotonic_time
        self.delta_seconds = self.accumulated_seconds
        self.accumulated_seconds, self.frame_count = 0.0, 0
        return self.tick


class OnVariableChange(Node, type="omni.graph.action.OnVariableChange", gated=True):
    """Fires in each tick that follows a tick in which the value of a graph variable changed."""

    variable_name: Token = In(default="", setup=True, required=True, doc="variable from `variables:` of the graph file")
    only_playback: bool = In(default=True, doc="no effect: graphs run only while the simulation plays")
    changed = ExecOut()

    variable: Variable = Bound()

    def setup(self, context: Context) -> None:
        """Look up the graph variable `variableName` and keep it.

        Raises:
            ContextError: the graph has no variable with this name.
        """
        self.variable = context.variable(self.variable_name)

    def compute(self) -> Fire:
        """Fire if the variable changed in the previous tick."""
        return self.changed if self.variable.changed else None
