"""Nodes that read and split times: simulation time and wall time (`isaacsim.core.nodes`).

The engine reads the wall clock once, at the start of a tick; all nodes get the same value in this tick.
"""

from __future__ import annotations

import math
from typing import Any

from graphengine.node import BadValueError, ExecIn, ExecOut, Float, In, Int, Node, Out, State, UInt, UInt64
from graphengine.nodes.clocked import ClockNode


class TimeNode(ClockNode):
    """Base of nodes that output the time of a clock, or a reference time if `referenceTimeDenominator` is above 0.

    The reference time is `referenceTimeNumerator` / `referenceTimeDenominator`, s.
    """

    reference_time_numerator: int = In(default=0, doc="numerator of the reference time, s; needs a denominator above 0")
    reference_time_denominator: UInt64 = In(
        default=0, doc="denominator of the reference time, s; 0: output the time of the clock"
    )

    def or_reference(self, time: float) -> float:
        """Return the reference time (s) if `referenceTimeDenominator` is above 0, otherwise `time`."""
        denominator = self.reference_time_denominator
        return self.reference_time_numerator / denominator if denominator > 0 else time


class IsaacReadSimulationTime(TimeNode, type="isaacsim.core.nodes.IsaacReadSimulationTime", volatile=True):
    """Outputs the simulation time. It is constant within a pass of the graph."""

    reset_on_stop: bool = In(default=True, doc="true: output the time since play; false: since the session began")
    simulation_time: float = Out(unit="s")

    def compute(self) -> None:
        """Output the simulation time, or the reference time if one is given."""
        clock = self.clock
        self.simulation_time = self.or_reference(clock.time if self.reset_on_stop else clock.monotonic_time)


class IsaacReadSimulationTimeAnnotator(
    IsaacReadSimulationTime, type="isaacsim.core.nodes.IsaacReadSimulationTimeAnnotator"
):
    """Outputs the simulation time at each execution."""

    exec_in = ExecIn()
    exec_out = ExecOut()


class IsaacReadSystemTime(TimeNode, type="isaacsim.core.nodes.IsaacReadSystemTime", volatile=True):
    """Outputs the wall time at which the tick started. All nodes get the same time in a tick."""

    system_time: float = Out(unit="s", doc="time since 1970-01-01 UTC")

    def compute(self) -> None:
        """Output the wall time, or the reference time if one is given."""
        self.system_time = self.or_reference(self.clock.wall_time)


class IsaacReadSystemTimeAnnotator(IsaacReadSystemTime, type="isaacsim.core.nodes.IsaacReadSystemTimeAnnotator"):
    """At each execution, outputs the wall time at which the tick started."""

    exec_in = ExecIn()
    exec_out = ExecOut()


class IsaacTimeSplitter(Node, type="isaacsim.core.nodes.IsaacTimeSplitter"):
    """Splits a time into whole seconds and a remainder below one second.

    Each of the outputs `milliseconds`, `microseconds` and `nanoseconds` is the whole remainder in its unit. The time is truncated
    to nanoseconds, as in the stamps of messages.
    """

    time: Any = In(type="double|float|half|int|int64|uint|uint64", unit="s")
    seconds: Int = Out(unit="s", doc="time rounded down to whole seconds")
    milliseconds: UInt = Out(unit="ms", doc="remainder in milliseconds, rounded down, below 10^3")
    microseconds: UInt = Out(unit="us", doc="remainder in microseconds, rounded down, below 10^6")
    nanoseconds: UInt = Out(unit="ns", doc="remainder in nanoseconds, below 10^9")

    def compute(self) -> None:
        """Split the time.

        Raises:
            BadValueError: the magnitude of the time is 2^31 s or more, or the time is NaN.
        """
        if not abs(self.time) < 2**31:
            raise BadValueError("time", self.time, "above -2^31 s and below 2^31 s")
        self.seconds, self.nanoseconds = divmod(int(self.time * 10**9), 10**9)
        self.microseconds, self.milliseconds = self.nanoseconds // 10**3, self.nanoseconds // 10**6


class IsaacRealTimeFactor(ClockNode, type="isaacsim.core.nodes.IsaacRealTimeFactor", volatile=True):
    """Computes the real-time factor: elapsed simulation time divided by elapsed wall time.

    Both times are measured between the last two ticks in which the node was computed.
    """

    rtf: Float = Out(doc="1 is real time, above 1 is faster; 0 until the node was computed in two ticks")

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
