"""Warns of nodes that read and write the same resource, such as a variable, in an order that no wire determines."""

from __future__ import annotations

import itertools

from graphengine.compiler.digraph import Digraph
from graphengine.compiler.planning.regions import RegionGraph


def lint_reads_and_writes(regions: RegionGraph) -> None:
    """Add a warning for each reader and writer of the same resource if neither wires nor ports determine which runs first."""
    running = set[int]().union(*regions.members)
    writers: dict[str, list[int]] = {}
    for index in sorted(running):
        for name in regions.node(index).writes:
            writers.setdefault(name, []).append(index)
    if not writers:
        return
    nodes = range(len(regions.kinds))
    data_flow = Digraph(nodes, [(data, reader) for reader in nodes for data in regions.data_sources(reader)])
    for instance in (instance for instance in regions.graph.instances if instance.reads):
        data = regions.kinds[instance.index] == "data"
        readers = running.intersection(data_flow.descendants(instance.index) if data else [instance.index])
        for name in instance.reads:
            for reader, writer in itertools.product(sorted(readers), writers.get(name, [])):
                if _in_stated_order(regions, reader, writer):
                    continue
                one, other, what = regions.node(reader), regions.node(writer), name.replace(":", " ")
                message = f"{one.id} reads and {other.id} writes {what}, but nothing determines their order"
                related = [(other.span, "written here"), *one.entry.via]
                regions.findings.add("W105", message, one.span, "order them with a Multisequence", related=related)


def _in_stated_order(regions: RegionGraph, one: int, other: int) -> bool:
    """Return whether execution wires, or the ports of a loop or sequence, determine which of two nodes runs first."""
    if regions.execution.has_path(one, other) or regions.execution.has_path(other, one):
        return True
    pairs = (pair for ports in regions.port_covers.values() for pair in itertools.permutations(ports, 2))
    return any(one in first and other in second for first, second in pairs)
