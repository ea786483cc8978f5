"""Simulation time and the wall clock (`isaacsim.core.nodes`).

The wall clock is read once a tick, when the tick begins: whoever asks for it in that tick gets the same answer.
"""

from __future__ import annotations

import math
from typing import Any

from graphengine.node import BadValueError, ExecIn, ExecOut, Float, In, Int, Node, Out, State, UInt, UInt64
from graphengine.nodes.clocked import ClockNode


class TimeNode(ClockNode):
    """A node that reads the clock, or divides a reference time."""

    reference_time_numerator: int = In(default=0, doc="if set, the time is this fraction")
    reference_time_denominator: UInt64 = In(default=0, doc="denominator of the reference time")

    def or_reference(self, time: float) -> float:
        """The reference time where there is one, else a time of the clock."""
        denominator = self.reference_time_denominator
        return self.reference_time_numerator / denominator if denominator > 0 else time


class IsaacReadSimulationTime(TimeNode, type="isaacsim.core.nodes.IsaacReadSimulationTime", volatile=True):
    """Simulation time; the same for everything that reads it in one tick."""

    reset_on_stop: bool = In(default=True, doc="seconds since play; else since the session began, over stop and play")
    simulation_time: float = Out(unit="s")

    def compute(self) -> None:
        """Read the clock."""
        clock = self.clock
        self.simulation_time = self.or_reference(clock.time if self.reset_on_stop else clock.monotonic_time)


class IsaacReadSimulationTimeAnnotator(
    IsaacReadSimulationTime, type="isaacsim.core.nodes.IsaacReadSimulationTimeAnnotator"
):
    """Simulation time, read when it is executed."""

    exec_in = ExecIn()
    exec_out = ExecOut()


class IsaacReadSystemTime(TimeNode, type="isaacsim.core.nodes.IsaacReadSystemTime", volatile=True):
    """The wall clock when the tick began; the same for everything that reads it in one tick."""

    system_time: float = Out(unit="s", doc="since 1970")

    def compute(self) -> None:
        """Read the clock."""
        self.system_time = self.or_reference(self.clock.wall_time)


class IsaacReadSystemTimeAnnotator(IsaacReadSystemTime, type="isaacsim.core.nodes.IsaacReadSystemTimeAnnotator"):
    """The wall clock when the tick began, read when it is executed."""

    exec_in = ExecIn()
    exec_out = ExecOut()


class IsaacTimeSplitter(Node, type="isaacsim.core.nodes.IsaacTimeSplitter"):
    """A time as whole seconds, and what is beyond them in smaller units; cut to nanoseconds as stamps of messages are."""

    time: Any = In(type="double|float|half|int|int64|uint|uint64", unit="s")
    seconds: Int = Out(unit="s")
    milliseconds: UInt = Out(unit="ms", doc="beyond the seconds, whole ones")
    microseconds: UInt = Out(unit="us", doc="beyond the seconds, whole ones")
    nanoseconds: UInt = Out(unit="ns", doc="beyond the seconds")

    def compute(self) -> None:
        """Split.

        Raises:
            BadValueError: so many seconds are no int.
        """
        if not abs(self.time) < 2**31:
            raise BadValueError("time", self.time, "less than 2^31 s")
        self.seconds, self.nanoseconds = divmod(int(self.time * 10**9), 10**9)
        self.microseconds, self.milliseconds = self.nanoseconds // 10**3, self.nanoseconds // 10**6


class IsaacRealTimeFactor(ClockNode, type="isaacsim.core.nodes.IsaacRealTimeFactor", volatile=True):
    """Simulation time that passes in a second of the wall clock, between the last two ticks in which it was read."""

    rtf: Float = Out(doc="1 in real time, more when faster; 0 before there are two ticks to compare")

    last: tuple[float, float] = State(default=(math.nan, math.nan))

    def compute(self) -> None:
        """Compare both times with those of the last tick that read them."""
        now = self.clock.monotonic_time, self.clock.wall_time
        simulated, elapsed = now[0] - self.last[0], now[1] - self.last[1]
        if elapsed == 0.0:
            return
        if simulated > 0.0 and elapsed > 0.0:  # the wall clock may have been set back
            self.rtf = simulated / elapsed
        self.last = now
