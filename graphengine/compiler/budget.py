"""Size limits of one graph with all subgraphs expanded."""

from __future__ import annotations

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.document import MAX_VALUES
from graphengine.format.spec import GraphSpec

MAX_PARTS = 20_000
"""Maximum number of parts of a graph: the sum of its nodes, wires, variables and uses of subgraphs."""

Via = tuple[tuple[Span, str], ...]


class OverBudgetError(Exception):
    """A graph exceeds a size limit; the error was already added to the findings."""


class Budget:
    """Counts nodes, wires, variables, subgraph uses and values of a graph while its subgraphs are expanded."""

    def __init__(self, span: Span, findings: Findings) -> None:
        self.findings = findings
        self.parts = dict.fromkeys(("uses of subgraphs", "nodes", "wires", "variables"), 0)
        self.values = 0
        """Number of values in the graph file and its subgraph files; each use of a subgraph adds the values of its file."""
        self.text = 0
        """Total size of the values that replaced parameters: characters of text, or bytes of arrays."""
        self.at(span, ())

    def at(self, span: Span, via: Via) -> None:
        """Set the position for findings.

        Args:
            span: position of the node whose subgraph is being expanded.
            via: positions of the subgraph uses around that node, from the outermost inwards, each with a note.
        """
        self.span, self.via = span, via

    def take_values(self, count: int) -> None:
        """Add the number of values in a file to the count.

        Raises:
            OverBudgetError: the graph has too many values.
        """
        self.values += count
        if self.values > MAX_VALUES:
            self._refuse(f"more than {MAX_VALUES} values in one graph, counting each subgraph at every use")

    def take_parts(self, spec: GraphSpec) -> None:
        """Count the nodes, wires, variables and subgraph uses of a file.

        Raises:
            OverBudgetError: the graph has more than `MAX_PARTS` parts.
        """
        uses = sum(1 for node in spec.nodes.values() if node.subgraph)
        more = (uses, len(spec.nodes) - uses, len(spec.connections), len(spec.variables))
        for kind, count in zip(self.parts, more, strict=True):
            self.parts[kind] += count
        self._check_parts()

    def take_wire(self) -> None:
        """Count one more wire, for each inner port but the first to which an input of a subgraph leads.

        Raises:
            OverBudgetError: the graph has more than `MAX_PARTS` parts.
        """
        self.parts["wires"] += 1
        self._check_parts()

    def _check_parts(self) -> None:
        if sum(self.parts.values()) > MAX_PARTS:
            counted = ", ".join(f"{count} {kind}" for kind, count in self.parts.items() if count)
            self._refuse(f"more than {MAX_PARTS} nodes, wires, variables and uses of subgraphs in one graph: {counted}")

    def _refuse(self, message: str) -> None:
        advice = "split it into several graphs, or use fewer subgraphs"
        self.findings.add("G105", message, self.span, advice, related=self.via)
        raise OverBudgetError
