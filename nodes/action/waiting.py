"""What fires later than it was executed (`omni.graph.action`). Time is that of the simulation."""

from __future__ import annotations

from graphengine.context import Clock, Context
from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.types import Float, Int


class Delay(Node, type="omni.graph.action.Delay"):
    """Fires in the first tick in which so much time has passed since it was last executed."""

    exec_in = ExecIn(doc="starts the wait anew where one is under way")
    duration: float = In(default=0.0, unit="s", doc="read when it is executed")
    finished = ExecOut()

    clock: Clock = State()
    end: float = State(default=0.0)

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock

    def compute(self) -> None:
        """Begin to wait."""
        self.end = self.clock.time + self.duration
        self.active = True

    def update(self) -> Fire:
        """Fire in the tick that follows, when the time has passed by then."""
        ticks_left = (self.end - self.clock.time) / self.clock.delta
        if ticks_left > 1.0 + 1e-6:  # a sum of periods may be a little more than the time it should be
            return None
        self.active = False
        return self.finished


class Countdown(Node, type="omni.graph.action.Countdown"):
    """Counts ticks from its last execution up to a duration, fires tick at every period-th and finished at the last."""

    exec_in = ExecIn(doc="starts the count anew where one is under way; this tick is number 0 and fires nothing")
    duration: Int = In(default=5, doc="ticks")
    period: Int = In(default=1, ge=1, doc="ticks")
    tick = ExecOut()
    tick_value: Int = Out(doc="number of the tick, 1 to duration")
    alpha: Float = Out(doc="tickValue / duration")
    finished = ExecOut()

    count: Int = State(default=-1)

    def compute(self) -> None:
        """Begin to count."""
        self.count = 0
        self.active = True

    def update(self) -> Fire:
        """Count the tick that follows."""
        self.count += 1
        self.tick_value = self.count
        self.alpha = min(1.0, self.count / max(1, self.duration))
        fired = self.tick if self.count % self.period == 0 else 0
        if self.count >= self.duration:
            self.active = False
            self.count = -1
            fired |= self.finished
        return fired
