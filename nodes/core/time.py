"""Simulation time, and one-shots (`isaacsim.core.nodes`)."""

from __future__ import annotations

from graphengine.context import Clock, Context
from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Out, State
from graphengine.types import (
    UInt64,
)


class IsaacReadSimulationTime(Node, type="isaacsim.core.nodes.IsaacReadSimulationTime", volatile=True):
    """Simulation time; the same for everything that reads it in one tick."""

    reset_on_stop: bool = In(default=True, doc="seconds since play; else since the session began, over stop and play")
    reference_time_numerator: int = In(default=0, doc="if set, the time is this fraction")
    reference_time_denominator: UInt64 = In(default=0, doc="denominator of the reference time")
    simulation_time: float = Out(unit="s")

    clock: Clock = State()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock

    def compute(self) -> None:
        """Read the clock, or divide the reference time."""
        if self.reference_time_denominator > 0:
            self.simulation_time = self.reference_time_numerator / self.reference_time_denominator
        elif self.reset_on_stop:
            self.simulation_time = self.clock.time
        else:
            self.simulation_time = self.clock.monotonic_time


class OgnIsaacRunOneSimulationFrame(Node, type="isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame", gated=True):
    """Fires the first time it runs after play, and then no more."""

    exec_in = ExecIn()
    step = ExecOut(doc="fires once after play")

    done: bool = State(default=False)

    def compute(self) -> Fire:
        """Fire once."""
        if self.done:
            return None
        self.done = True
        return self.step
