"""Nodes that fire some time after their execution (`omni.graph.action`, `omni.graph.nodes`). Times are simulation time."""

from __future__ import annotations

from graphengine.node import ExecIn, ExecOut, Fire, Float, In, Int, Node, Out, State
from graphengine.nodes.checked import check_finite
from graphengine.nodes.clocked import ClockNode


class Delay(ClockNode, type="omni.graph.action.Delay"):
    """Fires in the first tick in which `duration` or more has passed since the last execution."""

    exec_in = ExecIn(doc="starts or restarts the wait")
    duration: float = In(default=0.0, unit="s", doc="time to wait, read at the execution")
    finished = ExecOut()

    end: float = State(default=0.0)

    def compute(self) -> None:
        """Begin to wait.

        Raises:
            BadValueError: the duration is not finite.
        """
        check_finite(self, "duration")
        self.end = self.clock.time + self.duration
        self.active = True

    def update(self) -> Fire:
        """Fire in the next tick, if the duration has passed by then."""
        ticks_left = (self.end - self.clock.time) / self.clock.delta
        if ticks_left > 1.0 + 1e-6:  # a sum of periods may be a little more than the time it should be
            return None
        self.active = False
        return self.finished


class Timer(ClockNode, type="omni.graph.nodes.Timer"):
    """Moves a value from a start to an end; fires `updated` in each tick of the motion, and `finished` in the tick after it."""

    play = ExecIn(doc="starts the motion in the next tick; ignored while the value moves")
    duration: float = In(default=1.0, unit="s", doc="duration of the motion; values below 0 count as 0")
    start_value: float = In(default=0.0, doc="value at the beginning")
    end_value: float = In(default=1.0, doc="value after the duration")
    updated = ExecOut()
    finished = ExecOut()
    value: float = Out(doc="present value, linear in time from startValue to endValue")

    start: float = State(default=0.0)
    arrived: bool = State(default=False)

    def compute(self) -> None:
        """Begin to move."""
        if not self.active:
            self.start, self.arrived = self.clock.time + self.clock.delta, False
            self.active = True

    def update(self) -> Fire:
        """Set the value for the next tick.

        Raises:
            BadValueError: the duration, the start or the end is not finite.
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
    """Counts `duration` ticks after an execution; fires `tick` every `period` ticks and `finished` at the end."""

    exec_in = ExecIn(doc="starts or restarts the count; this tick is number 0 and fires nothing")
    duration: Int = In(default=5, doc="number of ticks to count")
    period: Int = In(default=1, ge=0, doc="number of ticks from one `tick` to the next; 0 counts as 1")
    tick = ExecOut()
    tick_value: Int = Out(doc="number of the tick, 1 to duration; 0 when the count begins")
    alpha: Float = Out(doc="tickValue / duration")
    finished = ExecOut()

    count: Int = State(default=-1)

    def compute(self) -> None:
        """Begin to count."""
        self.count = self.tick_value = 0
        self.alpha = 0.0
        self.active = True

    def update(self) -> Fire:
        """Count the next tick."""
        self.count += 1
        self.tick_value = self.count
        self.alpha = min(1.0, self.count / max(1, self.duration))
        fired = self.tick if self.count % max(1, self.period) == 0 else 0
        if self.count >= self.duration:
            self.active = False
            self.count = -1
            fired |= self.finished
        return fired
