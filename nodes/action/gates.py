"""What lets execution through, and when (`omni.graph.action`).

Each computes once for every activation. A toggle or reset that fires together with an execution acts before it.
"""

from __future__ import annotations

from typing import ClassVar

from graphengine.node import Context, ExecIn, ExecOut, Fire, In, Int, Int64, Node, Numbered, Out, State, UInt64


class Gate(Node, type="omni.graph.action.Gate", gated=True, counts=True):
    """Lets what enters through while it is open."""

    enter = ExecIn()
    toggle = ExecIn(control=True, doc="opens a closed gate, closes an open one")
    start_closed: bool = In(default=False, doc="how the gate is before it is first toggled")
    exit_out = ExecOut(name="exit")

    toggled: bool = State(default=False)

    def compute(self) -> Fire:
        """Toggle, then let through."""
        if self.toggle % 2:
            self.toggled = not self.toggled
        return self.exit_out if self.enter and self.toggled == self.start_closed else None


class Multigate(Node, type="omni.graph.action.Multigate", gated=True, counts=True):
    """Fires one of its outputs at each execution, the next one each time, and after the last the first again.

    Where no wire begins at an output below the last, nothing fires when it is its turn.
    """

    numbered: ClassVar[Numbered] = {"output": ExecOut}

    exec_in = ExecIn()
    reset_in = ExecIn(name="reset", control=True, doc="the next execution fires output0; fires nothing itself")
    output0 = ExecOut(doc="the first; output1 and so on are there when a wire begins at them")

    next: int = State(default=0)
    turns: tuple[int | None, ...] = State(default=())

    def compute(self) -> Fire:
        """Reset, then fire the next."""
        if self.reset_in:
            self.next = 0
        if not self.exec_in:
            return None
        if not self.turns:
            outputs = {int(name.removeprefix("output")): getattr(self, name) for name in self.series["output"]}
            self.turns = tuple(outputs.get(number) for number in range(max(outputs) + 1))
        fired = self.turns[self.next]
        self.next = (self.next + 1) % len(self.turns)
        return fired


class FlipFlop(Node, type="omni.graph.action.FlipFlop", counts=True):
    """Fires a at the first execution since play and at every other one, b at those between."""

    exec_in = ExecIn()
    a = ExecOut()
    b = ExecOut()
    is_a: bool = Out(doc="whether a fired last")

    def compute(self) -> Fire:
        """Take turns."""
        self.is_a = not self.is_a
        return self.a if self.is_a else self.b


class Once(Node, type="omni.graph.action.Once", counts=True):
    """Fires once at its first execution since play, and after at all others."""

    exec_in = ExecIn()
    reset_in = ExecIn(name="reset", control=True, doc="the next execution is a first one; fires nothing itself")
    once = ExecOut()
    after = ExecOut()

    done: bool = State(default=False)

    def compute(self) -> Fire:
        """Reset, then tell the first from the others."""
        if self.reset_in:
            self.done = False
        if not self.exec_in:
            return None
        fired = self.after if self.done else self.once
        self.done = True
        return fired


class Counter(Node, type="omni.graph.action.Counter", counts=True):
    """Counts its executions since play, or since it was reset; a reset fires as well."""

    exec_in = ExecIn()
    reset_in = ExecIn(name="reset", control=True, doc="counts from 0 again")
    count: Int = Out()
    exec_out = ExecOut()

    def compute(self) -> None:
        """Reset, then count."""
        if self.reset_in:
            self.count = 0
        if self.exec_in:
            self.count += 1


class Rendezvous(Node, gated=True, counts=True):
    """A node that fires when it was executed as often as wires lead to it; what it waits for may begin anew."""

    exec_in = ExecIn()
    exec_out = ExecOut()

    wires: int = State(default=1)
    arrived: int = State(default=0)

    def setup(self, context: Context) -> None:
        """Count the wires."""
        self.wires = context.wires_into("exec_in")

    def arrive(self, *, anew: bool) -> Fire:
        """Count one execution more, or the first that is waited for anew."""
        self.arrived = 1 if anew else self.arrived + 1
        if self.arrived < self.wires:
            return None
        self.arrived = 0
        return self.exec_out


class SyncGate(Rendezvous, type="omni.graph.action.SyncGate"):
    """Fires when it was executed with one value as often as wires lead to it; another value begins anew.

    It begins anew once it has fired, too: in the reference it fires at each further execution with the same value.
    """

    sync_value_in: UInt64 = In(default=0, name="syncValue")
    sync_value_out: UInt64 = Out(name="syncValue", doc="the value that is being waited for")

    def compute(self) -> Fire:
        """Count what arrives."""
        other = self.sync_value_in != self.sync_value_out
        self.sync_value_out = self.sync_value_in
        return self.arrive(anew=other)


class RationalTimeSyncGate(Rendezvous, type="omni.graph.action.RationalTimeSyncGate"):
    """Fires when it was executed with one time as often as wires lead to it; another time begins anew."""

    numerator_in: Int64 = In(default=0, name="rationalTimeNumerator", doc="of the time in seconds")
    denominator_in: UInt64 = In(default=0, name="rationalTimeDenominator", doc="of the time in seconds")
    numerator_out: Int64 = Out(name="rationalTimeNumerator", doc="of the time that is being waited for")
    denominator_out: UInt64 = Out(name="rationalTimeDenominator", doc="of the time that is being waited for")

    def compute(self) -> Fire:
        """Count what arrives; 1/2 and 2/4 are one time, 1/0 and 2/0 are two."""
        crosswise = self.numerator_in * self.denominator_out == self.numerator_out * self.denominator_in
        both = self.denominator_in and self.denominator_out
        same = crosswise if both else self.numerator_in == self.numerator_out
        self.numerator_out, self.denominator_out = self.numerator_in, self.denominator_in
        return self.arrive(anew=not same)
