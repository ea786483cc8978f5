"""Nodes that fire after a delay in simulation time (`omni.graph.action`, `omni.graph.nodes`)."""

from __future__ import annotations

from graphengine.node import ExecIn, ExecOut, Fire, Float, In, Int, Node, Out, State
from graphengine.nodes.checked import check_finite
from graphengine.nodes.clocked import ClockNode


class Delay(ClockNode, type="omni.graph.action.Delay"):
    """Fires `finished` once, in the first tick in which `duration` has passed since the last execution."""

    exec_in = ExecIn(doc="starts or restarts the wait")
    duration: float = In(default=0.0, ge=0.0, unit="s", doc="simulation time to wait; fixed when the wait starts")
    finished = ExecOut()

    end: float = State(default=0.0)

    def compute(self) -> None:
        """Start or restart the wait.

        Raises:
            BadValueError: `duration` is not finite.
        """
        check_finite(self, "duration")
        self.end = self.clock.time + self.duration
        self.active = True

    def update(self) -> Fire:
        """Return `finished` if the wait is over in the next tick. The engine fires the returned output in the next tick."""
        ticks_left = (self.end - self.clock.time) / self.clock.delta
        if ticks_left > 1.0 + 1e-6:  # a sum of periods may be a little more than the time it should be
            return None
        self.active = False
        return self.finished


class Timer(ClockNode, type="omni.graph.nodes.Timer"):
    """Moves `value` from `startValue` to `endValue` in `duration` seconds of simulation time.

    `updated` fires in each tick of this motion, `finished` in the first tick after it.
    """

    play = ExecIn(doc="starts the motion of `value` in the next tick; ignored during a motion")
    duration: float = In(default=1.0, ge=0.0, unit="s", doc="simulation time of the motion; below 0 counts as 0")
    start_value: float = In(default=0.0, doc="first `value` of the motion")
    end_value: float = In(default=1.0, doc="last `value` of the motion")
    updated = ExecOut()
    finished = ExecOut()
    value: float = Out(doc="current value, linear in time between `startValue` and `endValue`")

    start: float = State(default=0.0)
    arrived: bool = State(default=False)

    def compute(self) -> None:
        """Start the motion of `value`, unless it is already in motion."""
        if not self.active:
            self.start, self.arrived = self.clock.time + self.clock.delta, False
            self.active = True

    def update(self) -> Fire:
        """Set `value` for the next tick, and return the output to fire in the next tick: `updated` or `finished`.

        Raises:
            BadValueError: `duration`, `startValue` or `endValue` is not finite.
        """
        if self.arrived:
            self.active = False
            return self.finished
        check_finite(self, "duration", "start_value", "end_value")
        passed = self.clock.time + self.clock.delta - self.start
        self.arrived = passed > self.duration - 1e-6 * self.clock.delta  # a sum of periods may be a little less
        way = self.end_value - self.start_value
        self.value = self.end_value if self.arrived else self.start_value + way * passed / self.duration
        return self.updated


class Countdown(Node, type="omni.graph.action.Countdown"):
    """Counts `duration` ticks after an execution. Fires `tick` every `period` ticks, and `finished` in the last tick."""

    exec_in = ExecIn(doc="starts or restarts the count at 0; the outputs do not fire in the tick of this execution")
    duration: Int = In(default=5, ge=0, doc="number of ticks to count")
    period: Int = In(default=1, ge=0, doc="number of ticks from one `tick` to the next; 0 counts as 1")
    tick = ExecOut()
    tick_value: Int = Out(
        doc="number of ticks since the last execution: 0 in the tick of the execution, `duration` when `finished` fires"
    )
    alpha: Float = Out(doc="`tickValue` / `duration`, from 0 to 1")
    finished = ExecOut()

    count: Int = State(default=-1)

    def compute(self) -> None:
        """Start or restart the count at 0."""
        self.count = self.tick_value = 0
        self.alpha = 0.0
        self.active = True

    def update(self) -> Fire:
        """Count the next tick, set the outputs for it, and return the outputs to fire in it."""
        self.count += 1
        self.tick_value = self.count
        self.alpha = min(1.0, self.count / max(1, self.duration))
        fired = self.tick if self.count % max(1, self.period) == 0 else 0
        if self.count >= self.duration:
            self.active = False
            self.count = -1
            fired |= self.finished
        return fired
