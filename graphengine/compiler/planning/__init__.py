"""From a resolved graph to a plan: wires, dependencies, regions, calls, one after the other."""

from __future__ import annotations

from collections.abc import Iterable

from graphengine.compiler.graph import Graph
from graphengine.compiler.plan import Plan, Refresh
from graphengine.compiler.planning.calls import RegionWriter
from graphengine.compiler.planning.dependencies import DependencyGraph
from graphengine.compiler.planning.lints import lint_reads_and_writes
from graphengine.compiler.planning.push import PushGraph
from graphengine.compiler.planning.regions import RegionGraph
from graphengine.format.diagnostics import Findings

__all__ = ["make_plan"]


def make_plan(graph: Graph, findings: Findings) -> Plan | None:
    """The plan of a resolved graph; None when a cycle keeps it from running.

    Args:
        graph: instances and wires.
        findings: where mistakes go.
    """
    if graph.flat.spec.evaluator == "push":
        pushed = PushGraph(graph, findings)
        return _ordered(pushed, pushed.plan(), pushed.order) if pushed.acyclic else None
    regions = RegionGraph(graph, findings)
    if not regions.acyclic:
        return None
    lint_reads_and_writes(regions)
    plan = Plan(graph, gates=regions.gates)
    count = -1
    while count != len(regions.flagged):  # a data node that needs a flag changes what other steps must do
        count = len(regions.flagged)
        plan.regions = [RegionWriter(regions, index).write() for index in range(len(regions.members))]
    plan.flagged = tuple(sorted(regions.flagged))
    plan.latent_marks = {i: regions.marks(i) for i, kind in enumerate(regions.kinds) if kind == "latent"}
    return _ordered(regions, plan, _executed(regions))


def _executed(regions: RegionGraph) -> Iterable[int]:
    """Every node that can run but data nodes, in schedule order."""
    executed: dict[int, None] = {}
    pending = regions.members[0][::-1]
    while pending:
        index = pending.pop()
        if index not in executed:
            executed[index] = None
            below = [regions.pin_region.get((index, port), -1) for port in regions.exec_outputs(index)]
            pending += [n for region in reversed(below) if region >= 0 for n in reversed(regions.members[region])]
    return executed


def _ordered(graph: DependencyGraph, plan: Plan, executed: Iterable[int]) -> Plan:
    """A plan that knows the order of setup, and what is constant."""
    order: dict[int, None] = {}
    for index in executed:
        needs = graph.upstream(index)
        order |= dict.fromkeys([*needs, *_read_off(graph, [*needs, index]), index])
    constants = sorted(graph.constant & order.keys(), key=lambda data: graph.data_rank[data])
    plan.constants = [Refresh(data, graph.copies(data, constant=None)) for data in constants]
    plan.order = list(dict.fromkeys([*constants, *order]))
    plan.constant_copies = [copy for i in plan.order for copy in graph.copies(i, constant=True)]
    for wire in (wire for index in order for wire in graph.data_in.get(index, [])):
        if graph.node(wire.target).cls.fields[wire.target_field].setup and wire.source in graph.data_rank:
            plan.early |= {*graph.data_needs(wire.source), wire.source} - graph.constant
    return plan


def _read_off(graph: DependencyGraph, readers: Iterable[int]) -> list[int]:
    """Data nodes whose unwired inputs a wire begins at; they need not be computed for it."""
    wires = [wire for reader in readers for wire in graph.data_in.get(reader, [])]
    return [wire.source for wire in wires if graph.reads_input(wire) and wire.source in graph.data_rank]
