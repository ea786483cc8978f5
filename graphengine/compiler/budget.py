"""Size limits of one graph with all subgraphs expanded."""

from __future__ import annotations

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.document import MAX_VALUES
from graphengine.format.spec import GraphSpec

MAX_PARTS = 20_000
"""Maximum number of uses of subgraphs, nodes, wires and variables in a graph, together."""

Via = tuple[tuple[Span, str], ...]


class OverBudgetError(Exception):
    """A graph exceeds a size limit, for which a finding was added."""


class Budget:
    """Counts nodes, wires, variables, subgraph uses and values of a graph while its subgraphs are expanded."""

    def __init__(self, span: Span, findings: Findings) -> None:
        self.findings = findings
        self.parts = dict.fromkeys(("uses of subgraphs", "nodes", "wires", "variables"), 0)
        self.values = 0
        """Number of values in the files; a file counts at each use."""
        self.text = 0
        """Number of bytes that replaced parameters."""
        self.at(span, ())

    def at(self, span: Span, via: Via) -> None:
        """Set the location that findings report: the use of a subgraph, and the uses that enclose it."""
        self.span, self.via = span, via

    def take_values(self, count: int) -> None:
        """Count the values of a file.

        Raises:
            OverBudgetError: the graph has too many values.
        """
        self.values += count
        if self.values > MAX_VALUES:
            self._refuse(f"more than {MAX_VALUES} values in one graph, counting each subgraph at every use")

    def take_parts(self, spec: GraphSpec) -> None:
        """Count the nodes, wires, variables and subgraph uses that a file adds to the graph.

        Raises:
            OverBudgetError: the graph has more than `MAX_PARTS` of them.
        """
        uses = sum(1 for node in spec.nodes.values() if node.subgraph)
        more = (uses, len(spec.nodes) - uses, len(spec.connections), len(spec.variables))
        for kind, count in zip(self.parts, more, strict=True):
            self.parts[kind] += count
        if sum(self.parts.values()) > MAX_PARTS:
            counted = ", ".join(f"{count} {kind}" for kind, count in self.parts.items() if count)
            self._refuse(f"more than {MAX_PARTS} parts in one graph: {counted} so far")

    def _refuse(self, message: str) -> None:
        advice = "split it into several graphs, or use fewer subgraphs"
        self.findings.add("G105", message, self.span, advice, related=self.via)
        raise OverBudgetError
