"""Simulation time and the wall clock (`isaacsim.core.nodes`).

The wall clock is read once, at the start of a tick; all nodes get the same value in that tick.
"""

from __future__ import annotations

import math
from typing import Any

from graphengine.node import BadValueError, ExecIn, ExecOut, Float, In, Int, Node, Out, State, UInt, UInt64
from graphengine.nodes.clocked import ClockNode


class TimeNode(ClockNode):
    """Base of nodes that output the time of a clock, or a reference time (numerator / denominator) if one is given."""

    reference_time_numerator: int = In(
        default=0, doc="numerator of the reference time (s); used if `referenceTimeDenominator` is above 0"
    )
    reference_time_denominator: UInt64 = In(
        default=0,
        doc="denominator of a reference time (s) to output; 0: output the clock's time instead",
    )

    def or_reference(self, time: float) -> float:
        """Return the reference time (s) if its denominator is above 0, else the given time."""
        denominator = self.reference_time_denominator
        return self.reference_time_numerator / denominator if denominator > 0 else time


class IsaacReadSimulationTime(TimeNode, type="isaacsim.core.nodes.IsaacReadSimulationTime", volatile=True):
    """Reads the simulation time, which is constant within a tick."""

    reset_on_stop: bool = In(default=True, doc="true: output the time since play; false: since the session began")
    simulation_time: float = Out(unit="s")

    def compute(self) -> None:
        """Read the clock."""
        clock = self.clock
        self.simulation_time = self.or_reference(clock.time if self.reset_on_stop else clock.monotonic_time)


class IsaacReadSimulationTimeAnnotator(
    IsaacReadSimulationTime, type="isaacsim.core.nodes.IsaacReadSimulationTimeAnnotator"
):
    """Reads the simulation time when executed."""

    exec_in = ExecIn()
    exec_out = ExecOut()


class IsaacReadSystemTime(TimeNode, type="isaacsim.core.nodes.IsaacReadSystemTime", volatile=True):
    """Reads the wall time at the start of the tick; it is the same for all nodes of a tick."""

    system_time: float = Out(unit="s", doc="time since 1970-01-01 UTC")

    def compute(self) -> None:
        """Read the clock."""
        self.system_time = self.or_reference(self.clock.wall_time)


class IsaacReadSystemTimeAnnotator(IsaacReadSystemTime, type="isaacsim.core.nodes.IsaacReadSystemTimeAnnotator"):
    """Reads the wall time at the start of the tick, when executed."""

    exec_in = ExecIn()
    exec_out = ExecOut()


class IsaacTimeSplitter(Node, type="isaacsim.core.nodes.IsaacTimeSplitter"):
    """Splits a time into whole seconds and the remainder, given in milliseconds, microseconds and nanoseconds.

    The time is truncated to nanoseconds, as in message stamps.
    """

    time: Any = In(type="double|float|half|int|int64|uint|uint64", unit="s")
    seconds: Int = Out(unit="s", doc="time rounded down to whole seconds")
    milliseconds: UInt = Out(unit="ms", doc="remainder beyond the whole seconds, rounded down")
    microseconds: UInt = Out(unit="us", doc="remainder beyond the whole seconds, rounded down")
    nanoseconds: UInt = Out(unit="ns", doc="remainder beyond the whole seconds, below 10^9")

    def compute(self) -> None:
        """Split the time.

        Raises:
            BadValueError: the seconds do not fit into an int.
        """
        if not abs(self.time) < 2**31:
            raise BadValueError("time", self.time, "less than 2^31 s")
        self.seconds, self.nanoseconds = divmod(int(self.time * 10**9), 10**9)
        self.microseconds, self.milliseconds = self.nanoseconds // 10**3, self.nanoseconds // 10**6


class IsaacRealTimeFactor(ClockNode, type="isaacsim.core.nodes.IsaacRealTimeFactor", volatile=True):
    """Computes the real-time factor, simulation time per wall time, between the last two ticks in which it was read."""

    rtf: Float = Out(doc="real-time factor: 1 is real time, above 1 is faster; 0 before the second tick")

    last: tuple[float, float] = State(default=(math.nan, math.nan))

    def compute(self) -> None:
        """Divide the elapsed simulation time by the elapsed wall time."""
        now = self.clock.monotonic_time, self.clock.wall_time
        simulated, elapsed = now[0] - self.last[0], now[1] - self.last[1]
        if elapsed == 0.0:
            return
        if simulated > 0.0 and elapsed > 0.0:  # the wall clock may have been set back
            self.rtf = simulated / elapsed
        self.last = now
