"""Nodes that let executions through or hold them back (`omni.graph.action`).

A node computes once for each activation of its execution inputs. If `toggle` or `reset` fires together with the other execution
input of a node, the toggle or reset is applied first.
"""

from __future__ import annotations

from typing import ClassVar

from graphengine.node import Context, ExecIn, ExecOut, Fire, In, Int, Int64, Node, Numbered, Out, State, UInt64


class Gate(Node, type="omni.graph.action.Gate", gated=True, counts=True):
    """Fires `exit` for each execution of `enter` while the gate is open."""

    enter = ExecIn()
    toggle = ExecIn(control=True, doc="opens the gate if it is closed, closes it if it is open")
    start_closed: bool = In(default=False, doc="true: the gate is closed when the simulation starts to play")
    exit_out = ExecOut(name="exit")

    toggled: bool = State(default=False)

    def compute(self) -> Fire:
        """Apply the toggles, then fire if `enter` was executed and the gate is open."""
        if self.toggle % 2:
            self.toggled = not self.toggled
        return self.exit_out if self.enter and self.toggled == self.start_closed else None


class Multigate(Node, type="omni.graph.action.Multigate", gated=True, counts=True):
    """Fires one of `output0`, `output1`, … per execution, in turn; after the last output, it starts again.

    Unwired outputs before the last wired output have their turns too; in the turn of an unwired output, nothing fires.
    """

    numbered: ClassVar[Numbered] = {"output": ExecOut}

    exec_in = ExecIn()
    reset_in = ExecIn(name="reset", control=True, doc="makes the next execution fire `output0`")
    output0 = ExecOut(doc="first output; a wire from `output1`, `output2`, … adds that output")

    next: int = State(default=0)
    turns: tuple[int | None, ...] = State(default=())

    def compute(self) -> Fire:
        """Apply a reset, then return the output whose turn it is."""
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
    """Fires `a` and `b` alternately; the first execution after play fires `a`."""

    exec_in = ExecIn()
    a = ExecOut()
    b = ExecOut()
    is_a: bool = Out(doc="true if the last execution fired `a`, false if it fired `b`")

    def compute(self) -> Fire:
        """Return `a` in the first, third, … execution since play, `b` in all others."""
        self.is_a = not self.is_a
        return self.a if self.is_a else self.b


class Once(Node, type="omni.graph.action.Once", counts=True):
    """Fires `once` at the first execution since play or the last reset, and `after` at all later executions."""

    exec_in = ExecIn()
    reset_in = ExecIn(name="reset", control=True, doc="makes the next execution count as the first")
    once = ExecOut()
    after = ExecOut()

    done: bool = State(default=False)

    def compute(self) -> Fire:
        """Apply a reset, then return `once` or `after`."""
        if self.reset_in:
            self.done = False
        if not self.exec_in:
            return None
        fired = self.after if self.done else self.once
        self.done = True
        return fired


class Counter(Node, type="omni.graph.action.Counter", counts=True):
    """Counts the executions of `execIn` since play or the last reset. Fires `execOut` at executions and at resets."""

    exec_in = ExecIn()
    reset_in = ExecIn(name="reset", control=True, doc="sets the count to 0")
    count: Int = Out()
    exec_out = ExecOut()

    def compute(self) -> None:
        """Apply a reset, then count the execution of `execIn`, if any."""
        if self.reset_in:
            self.count = 0
        if self.exec_in:
            self.count += 1


class Rendezvous(Node, gated=True, counts=True):
    """Base of nodes that count executions and fire when the count equals the number of wires into `execIn`."""

    exec_in = ExecIn()
    exec_out = ExecOut()

    wires: int = State(default=1)
    arrived: int = State(default=0)

    def setup(self, context: Context) -> None:
        """Store the number of wires into `execIn`."""
        self.wires = context.wires_into("exec_in")

    def arrive(self, *, anew: bool) -> Fire:
        """Count one execution; return `execOut` if the count has reached the number of wires into `execIn`, otherwise None.

        Args:
            anew: true to discard the previous count, so that this execution counts as the first.
        """
        self.arrived = 1 if anew else self.arrived + 1
        if self.arrived < self.wires:
            return None
        self.arrived = 0
        return self.exec_out


class SyncGate(Rendezvous, type="omni.graph.action.SyncGate"):
    """Counts executions with the same `syncValue`, and fires when the count equals the number of wires into `execIn`.

    The count restarts when `syncValue` changes and when the node has fired. OmniGraph's SyncGate does not restart the count
    after firing; it fires at each further execution with the same value.
    """

    sync_value_in: UInt64 = In(default=0, name="syncValue")
    sync_value_out: UInt64 = Out(name="syncValue", doc="value of the input `syncValue` at the last execution")

    def compute(self) -> Fire:
        """Count this execution, and fire if the count has reached the number of wires of the execution input."""
        other = self.sync_value_in != self.sync_value_out
        self.sync_value_out = self.sync_value_in
        return self.arrive(anew=other)


class RationalTimeSyncGate(Rendezvous, type="omni.graph.action.RationalTimeSyncGate"):
    """Counts executions with the same rational time, and fires when the count equals the number of wires into `execIn`.

    The count restarts when the time changes and when the node has fired.
    """

    numerator_in: Int64 = In(default=0, name="rationalTimeNumerator", doc="numerator of the time in seconds")
    denominator_in: UInt64 = In(default=0, name="rationalTimeDenominator", doc="denominator of the time in seconds")
    numerator_out: Int64 = Out(name="rationalTimeNumerator", doc="numerator at the last execution")
    denominator_out: UInt64 = Out(name="rationalTimeDenominator", doc="denominator at the last execution")

    def compute(self) -> Fire:
        """Count this execution, and fire if the count has reached the number of wires of the execution input.

        1/2 and 2/4 are the same time. If a denominator is 0, times with the same numerator are the same.
        """
        crosswise = self.numerator_in * self.denominator_out == self.numerator_out * self.denominator_in
        both = self.denominator_in and self.denominator_out
        same = crosswise if both else self.numerator_in == self.numerator_out
        self.numerator_out, self.denominator_out = self.numerator_in, self.denominator_in
        return self.arrive(anew=not same)
