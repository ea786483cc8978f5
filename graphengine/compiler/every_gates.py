"""Implements the key `every` of a node with gates: nodes that the compiler inserts and that pass on only some of the executions.

A gate sits before each execution input of the node, except control inputs; for an event, after each execution output. The file
does not contain the gates, but they are planned, executed and reset like all nodes.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

from graphengine.compiler.graph import Graph, Instance, Wire
from graphengine.compiler.subgraph_expansion import WireEnd, WireEntry
from graphengine.format.diagnostics import Findings
from graphengine.format.spec import MAX_HZ, NodeSpec
from graphengine.node.clock import Clock
from graphengine.node.context.context import Context
from graphengine.node.node_class import Node
from graphengine.node.port import Bound, ExecIn, ExecOut, Fire, In, State
from graphengine.node.types import UInt


class EveryGate(Node):
    """Base class of the gates, which fire their output at some of the executions of their input."""

    exec_in = ExecIn()
    exec_out = ExecOut()

    def rate(self, executions: float) -> float | None:
        """Return the firings of the gate per second; None if it does not fire at a constant rate.

        Args:
            executions: executions of the gate per second.
        """
        return None

    def __str__(self) -> str:
        return "once"


class EveryTicks(EveryGate, type="graphengine.EveryTicks", gated=True, counts=True):
    """Fires at every `ticks`-th execution since play, as IsaacSimulationGate does."""

    ticks: UInt = In(default=1, ge=1)

    executions: int = State(default=0)

    def compute(self) -> Fire:
        """Count the execution; fire at every `ticks`-th execution."""
        self.executions += 1
        return self.exec_out if self.executions % self.ticks == 0 else None

    def rate(self, executions: float) -> float | None:
        """Return `executions` / `ticks`."""
        return executions / self.ticks

    def __str__(self) -> str:
        return f"every {self.ticks} ticks"


class EveryHz(EveryGate, type="graphengine.EveryHz", gated=True, counts=True):
    """Fires at the first execution at or after each multiple of 1 / `hz` seconds of simulation time.

    These times are computed in integers, like the sampling times of sensors: at 60 ticks per second, 10 Hz gives the ticks
    1, 6, 12, 18, …
    """

    hz: float = In(default=1.0, gt=0, le=MAX_HZ, setup=True)

    clock: Clock = Bound()
    numerator: int = Bound()
    denominator: int = Bound()
    due: int = State(default=0)

    def setup(self, context: Context) -> None:
        """Store the clock and the number of periods per tick; after a change of `hz`, the gate fires within one new period."""
        self.clock = context.clock
        periods = Fraction(*context.clock.period) * Fraction(repr(self.hz))
        self.numerator, self.denominator = periods.numerator, periods.denominator
        self.due = min(self.due, self._begun() + 1)

    def _begun(self) -> int:
        """Return the number of the period of 1 / `hz` s that contains the current time; period 0 begins at simulation time 0."""
        return self.clock.frame * self.numerator // self.denominator

    def compute(self) -> Fire:
        """Fire if a new period has begun since the last firing."""
        begun = self._begun()
        if begun < self.due:
            return None
        self.due = begun + 1
        return self.exec_out

    def rate(self, executions: float) -> float | None:
        """Return `hz`, or `executions` if this is lower."""
        return min(self.hz, executions)

    def __str__(self) -> str:
        return f"every {self.hz:g} Hz"


class EveryOnce(EveryGate, type="graphengine.EveryOnce", gated=True, counts=True):
    """Fires at its first execution since play and never again, as OgnIsaacRunOneSimulationFrame does."""

    done: bool = State(default=False)

    def compute(self) -> Fire:
        """Fire at the first execution only."""
        if self.done:
            return None
        self.done = True
        return self.exec_out


def add_gates(graph: Graph, findings: Findings) -> list[Instance]:
    """Insert the gates for `every` into a graph, connect them and return them; the other wires keep their relative order."""
    pins = {pin: name for instance in graph.instances for pin, name in _gated_pins(graph, instance, findings).items()}
    if not pins:
        return []
    gates: dict[tuple[int, str], Instance] = {}
    wires: list[Wire] = []
    for wire in sorted([*graph.exec_wires, *graph.data_wires], key=lambda wire: wire.order):
        source, target = (wire.source, wire.source_field), (wire.target, wire.target_field)
        if source in pins:
            if source not in gates:
                gate = gates[source] = _make_gate(graph, source, pins[source])
                wires.append(_link(graph, source, (gate.index, "exec_in")))
            wire = replace(wire, source=gates[source].index, source_field="exec_out")
        first = target in pins and target not in gates
        if first:
            gates[target] = _make_gate(graph, target, pins[target])
        if target in pins:
            wire = replace(wire, target=gates[target].index, target_field="exec_in")
        wires.append(wire)
        if first:
            wires.append(_link(graph, (gates[target].index, "exec_out"), target))
    numbered = [replace(wire, order=order) for order, wire in enumerate(wires)]
    graph.exec_wires = [wire for wire in numbered if graph.source(wire)[1].is_exec]
    graph.data_wires = [wire for wire in numbered if not graph.source(wire)[1].is_exec]
    return list(gates.values())


def rate(graph: Graph, index: int, passes: float) -> float | None:
    """Return how often a node is executed per second; None if that depends on the run.

    Args:
        graph: planned graph of the node.
        index: index of the node.
        passes: passes of the graph per second.
    """
    gates = graph.plan.gates.get(index)
    often: float | None = passes if gates is not None else None
    for gate in gates or ():
        node = graph.instances[gate].make_node()
        often = node.rate(often) if often is not None and isinstance(node, EveryGate) else None
    return often


def _gated_pins(graph: Graph, instance: Instance, findings: Findings) -> dict[tuple[int, str], str]:
    """Return a dict from (node index, field) of each port of a node that needs a gate to the name of the gate.

    The dict is empty for a node without `every`, and after an error, which is added to `findings`.
    """
    entry = instance.entry
    if entry.spec.every is None:
        return {}
    execution = [port for port in instance.cls.fields.values() if port.is_exec]
    if not execution or graph.flat.spec.evaluator == "push":
        what = f"{instance.cls.__name__} is a data node, which is computed when another node reads it"
        remedy = "write `every` at the node that reads it"
        if execution:
            what, remedy = "in a push graph, every node is computed in every pass", "use `evaluator: execution`"
        message = f"{instance.id}: `every` cannot be used here: {what}"
        findings.add("G109", message, entry.key_span("every"), remedy, related=entry.via)
        return {}
    inputs = [port for port in execution if port.side == "inputs" and not port.control]
    gated = inputs or [port for port in execution if port.side == "outputs"]
    return {
        (instance.index, port.field): f"{instance.id}.every" if len(gated) == 1 else f"{instance.id}.every_{port.name}"
        for port in gated
    }


def _make_gate(graph: Graph, pin: tuple[int, str], name: str) -> Instance:
    owner = graph.instances[pin[0]]
    every = owner.entry.spec.every
    assert every is not None
    cls: type[EveryGate] = EveryOnce
    literals: dict[str, Any] = {}
    if every.ticks is not None:
        cls, literals = EveryTicks, {"ticks": every.ticks}
    elif every.hz is not None:
        cls, literals = EveryHz, {"hz": every.hz}
    entry = replace(owner.entry, id=name, spec=NodeSpec(type=cls.type_name), location=(*owner.entry.location, "every"))
    gate = Instance(len(graph.instances), name, cls, entry, literals, part_of=owner.id)
    graph.instances.append(gate)
    return gate


def _link(graph: Graph, source: tuple[int, str], target: tuple[int, str]) -> Wire:
    """Return a wire between a gate and the execution port behind it; the file position of the wire is that of `every`."""
    one, other = graph.instances[source[0]], graph.instances[target[0]]
    gate = one.entry if one.part_of else other.entry
    span = gate.key_span()
    begins = WireEnd(one.id, one.cls.fields[source[1]].name, "", span)
    ends = WireEnd(other.id, other.cls.fields[target[1]].name, "", span)
    return Wire(*source, *target, "", WireEntry(begins, ends, span, gate.via), -1)
