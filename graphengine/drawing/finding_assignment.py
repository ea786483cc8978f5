"""Assigns findings to the nodes and wires of a graph."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

from graphengine.compiler.budget import Via
from graphengine.compiler.graph import Graph
from graphengine.compiler.subgraph_expansion import NodeEntry, WireEntry
from graphengine.format.diagnostics import Finding, Findings
from graphengine.format.document import Value

CIRCLES = ("G209", "G210")
"""Codes of findings about cycles of wires."""


class _EndNode(NamedTuple):
    """The node at one end of a wire; `via` lists the uses of the subgraphs around the wire."""

    node: str
    via: Via


T = TypeVar("T", NodeEntry, WireEntry, _EndNode)


@dataclass(slots=True)
class AssignedFindings:
    """The findings of each node and of the whole graph.

    Attributes:
        nodes: a dict from node ids to findings.
        circular: wires of cycles.
        graph: findings in the graph's files that belong to no node.
    """

    nodes: dict[str, list[Finding]] = field(default_factory=dict)
    circular: list[WireEntry] = field(default_factory=list)
    graph: list[Finding] = field(default_factory=list)


def assign_findings(graph: Graph, findings: Findings) -> AssignedFindings:
    """Return the findings of a graph, assigned to nodes.

    A finding on a cycle belongs to the nodes of the cycle; another finding to the node, or to the ends of the wire, at its span.
    """
    assigned = AssignedFindings()
    regions = [(entry, *_region(entry)) for entry in graph.flat.nodes]
    paths = {entry.document.source.path for entry in graph.flat.nodes} | {graph.flat.loaded.document.source.path}
    ends = _ends(graph)
    for finding in findings.sorted():
        span = finding.span
        if span is not None and span.through:
            span, _ = span.through[-1]  # the node that uses the parameter
        if finding.severity == "note" or span is None or span.source.path not in paths:
            continue
        circle = _circle(finding, graph) if finding.code in CIRCLES else ()
        assigned.circular += circle
        path, at = span.source.path, (span.line, span.column)
        within = [one for one, low, high in regions if one.document.source.path == path and low <= at <= high]
        owners = [wire.target.node for wire in circle] or [entry.id for entry in _told_of(finding, within)]
        owners = owners or [end.node for end in _told_of(finding, ends.get((str(span), span.length), ()))]
        for owner in dict.fromkeys(owners):
            assigned.nodes.setdefault(owner, []).append(finding)
        if not owners:
            assigned.graph.append(finding)
    return assigned


def _told_of(finding: Finding, items: Sequence[T]) -> Sequence[T]:
    """Return the nodes or wires to which a finding applies.

    If the finding names one of several uses of a subgraph, only nodes or wires in this use are returned.
    """
    named = set(finding.related)
    return [item for item in items if named.issuperset(item.via)] or items


def _circle(finding: Finding, graph: Graph) -> Sequence[WireEntry]:
    """Return the wires of the cycle that a finding reports."""
    places = {(str(span), span.length) for span, _ in finding.related}
    return _told_of(finding, [wire for wire in graph.flat.wires if (str(wire.span), wire.span.length) in places])


def _ends(graph: Graph) -> dict[tuple[str, int], list[_EndNode]]:
    """Return a dict from spans of wire ends to their nodes; the span of a whole wire gives the target node."""
    names = {entry.id for entry in graph.flat.nodes}
    places: dict[tuple[str, int], list[_EndNode]] = {}
    for wire in graph.flat.wires:
        known = [_EndNode(end.node, wire.via) for end in (wire.source, wire.target) if end.node in names]
        for span, ends in ((wire.source.span, known[:1]), (wire.target.span, known[-1:]), (wire.span, known[-1:])):
            places.setdefault((str(span), span.length), []).extend(ends)
    return places


def _region(entry: NodeEntry) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the positions (line, column) of the beginning of a node and of its last key or value in the file."""
    key = entry.key_span()
    last = (key.line, key.column)
    found = entry.document.find(*entry.location)
    pending = [found] if found is not None else []
    while pending:
        value = pending.pop()
        last = max([last, (value.span.line, value.span.column), *((k.line, k.column) for k in value.keys.values())])
        pending += _children(value)
    return (key.line, key.column), last


def _children(value: Value) -> Iterable[Value]:
    if isinstance(value.data, dict):
        return value.data.values()
    return value.data if isinstance(value.data, list) else ()
