"""Plans the execution of a resolved graph, in four steps: `wiring`, `dependencies`, `regions` and `region_calls`."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

from graphengine.compiler.digraph import reached
from graphengine.compiler.graph import Graph
from graphengine.compiler.plan import Plan, Refresh, Region
from graphengine.compiler.planning.dependencies import DependencyGraph
from graphengine.compiler.planning.lints import lint_reads_and_writes
from graphengine.compiler.planning.push import PushGraph
from graphengine.compiler.planning.region_calls import RegionWriter
from graphengine.compiler.planning.regions import RegionGraph
from graphengine.format.diagnostics import Findings
from graphengine.node.node_class import UNKNOWN_PRIM

__all__ = ["make_plan", "shape", "share_plans"]


def share_plans(graphs: Iterable[Graph], findings: Findings) -> list[Graph]:
    """Set the plan of each graph; graphs of one file that differ only in literals share a plan.

    Returns:
        The graphs that have a plan. Graphs that cannot be planned, because of a cycle for example, are left out; the errors are
        added to `findings`.
    """
    known: dict[object, Plan | None] = {}
    planned: list[Graph] = []
    for graph in graphs:
        key = shape(graph)
        if key not in known:
            known[key] = make_plan(graph, findings)
        plan = known[key]
        if plan is not None:
            graph.plan = plan
            planned.append(graph)
    return planned


def shape(graph: Graph) -> object:
    """Return a hashable key of the facts on which a plan depends: file, evaluator, node classes, wires and shared resources.

    Graphs with equal keys share a plan; literals are not part of the key.
    """
    numbers: dict[str, object] = {UNKNOWN_PRIM: UNKNOWN_PRIM}

    def accesses(keys: Iterable[str]) -> tuple[object, ...]:
        return tuple(numbers.setdefault(key, len(numbers)) for key in keys)

    return (
        str(graph.flat.loaded.document.source.path),
        graph.flat.spec.evaluator,
        tuple((one.id, one.cls, accesses(one.reads), accesses(one.writes)) for one in graph.instances),
        tuple((*wire.ends, wire.converter, wire.order) for wire in (*graph.data_wires, *graph.exec_wires)),
    )


def make_plan(graph: Graph, findings: Findings) -> Plan | None:
    """Return the plan of a resolved graph; None after an error, such as a cycle.

    Args:
        graph: graph to plan.
        findings: receives errors and warnings.
    """
    if graph.flat.spec.evaluator == "push":
        pushed = PushGraph(graph, findings)
        return _plan(pushed, [pushed.region()], pushed.order) if pushed.acyclic else None
    regions = RegionGraph(graph, findings)
    if not regions.acyclic:
        return None
    lint_reads_and_writes(regions)
    written, count = list[Region](), -1
    # A new flagged or shared node changes what other steps must do.
    while count != (count := len(regions.flagged) + len(regions.shared)):
        regions.placed.clear()
        written = [RegionWriter(regions, index).write() for index in range(len(regions.members))]
        regions.share_upstream()
    return _plan(regions, written, _executed(regions))


def _executed(regions: RegionGraph) -> Collection[int]:
    """Return all nodes that a pass can run, except data nodes, in the order of execution."""

    def below(index: int) -> list[int]:
        ports = regions.exec_ports(index, "outputs")
        started = [regions.pin_region.get((index, port.field), -1) for port in ports]
        return [node for region in started if region >= 0 for node in regions.members[region]]

    return reached(regions.members[0], below)


def _plan(graph: DependencyGraph, regions: Sequence[Region], executed: Collection[int]) -> Plan:
    """Return the plan with the given regions, and compute the order of setup and the data nodes that setup needs.

    Args:
        graph: graph with its dependencies.
        regions: regions with their calls.
        executed: all nodes that can run, in the order of execution; in an execution graph, without data nodes.
    """
    order: dict[int, None] = {}
    needed: set[int] = set()
    for index in executed:
        needs = graph.upstream([index], needed)
        needed.update(needs)
        order |= dict.fromkeys([*needs, *_read_off(graph, [*needs, index]), index])
    constants = sorted(graph.constant & order.keys(), key=lambda data: graph.data_rank[data])
    ordered = tuple(dict.fromkeys([*constants, *order]))
    wires = [wire for index in order for wire in graph.data_in.get(index, [])]
    early = {w.source for w in wires if graph.graph.target(w)[1].setup and w.source in graph.data_rank}
    changing = sorted(needed - graph.constant - set(executed), key=lambda data: graph.data_rank[data])
    return Plan(
        Path(graph.graph.flat.loaded.document.source.path),
        tuple(instance.id for instance in graph.graph.instances),
        tuple(regions),
        graph.gates,
        data={data: Refresh(data, graph.copies(data), shared=data in graph.shared) for data in changing},
        flagged=tuple(sorted(graph.flagged)),
        latent_marks={index: graph.marks(index) for index, kind in enumerate(graph.kinds) if kind == "latent"},
        constants=tuple(Refresh(data, graph.copies(data, constant=None)) for data in constants),
        constant_copies=tuple(copy for index in ordered for copy in graph.copies(index, constant=True)),
        order=ordered,
        early=frozenset({*graph.upstream(early), *early} - graph.constant),
    )


def _read_off(graph: DependencyGraph, readers: Iterable[int]) -> list[int]:
    """Return the data nodes from whose unwired inputs wires lead to the given readers.

    A wire that begins at an input carries its value without a computation of the node.
    """
    wires = [wire for reader in readers for wire in graph.data_in.get(reader, [])]
    return [wire.source for wire in wires if graph.reads_input(wire) and wire.source in graph.data_rank]
