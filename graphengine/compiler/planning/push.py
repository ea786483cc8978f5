"""Plans a push graph, in which every node runs in every pass; data and execution wires determine only the order.

Execution outputs have no effect, and wires from latent nodes do not determine the order. Execution inputs count as fired in
every pass, except control inputs (such as toggle, reset and break). A loop or sequence runs through all its yields, and a latent
node starts again in every pass.
"""

from __future__ import annotations

from graphengine.compiler.digraph import Digraph
from graphengine.compiler.graph import Graph
from graphengine.compiler.plan import Call, Region
from graphengine.compiler.planning.dependencies import DependencyGraph
from graphengine.format.diagnostics import Findings


class PushGraph(DependencyGraph):
    """A graph in which every node runs in every pass.

    Attributes:
        order: all nodes in the order of execution, each after the nodes whose outputs are wired to it.
    """

    def __init__(self, graph: Graph, findings: Findings) -> None:
        super().__init__(graph, findings)
        self.order: list[int] = []
        if self.acyclic:
            self._order_nodes()

    def _order_nodes(self) -> None:
        """Set `order`; a wire that would close a cycle carries the value of the previous pass, and causes a warning."""
        wires = [wire for into in self.data_in.values() for wire in into if not self.reads_input(wire)]
        pure = self.data_rank.keys()
        plain = [(wire.source, wire.target) for wire in wires if {wire.source, wire.target} <= pure]
        order = Digraph(self.execution.successors, [*self.execution.edges(), *plain])
        others = [wire for wire in sorted(wires, key=lambda wire: wire.order) if not {wire.source, wire.target} <= pure]
        refused = order.add_where_acyclic([(wire.source, wire.target) for wire in others])
        for wire in others:
            if (wire.source, wire.target) in refused and wire.source != wire.target:
                why = f"other wires order {self.node(wire.target).id} before {self.node(wire.source).id}"
                self.report_previous(wire, wire.source, why, "remove one of the wires")
        self.order = order.sort(key=int)
        self.gates = dict.fromkeys(self.order, ())

    def region(self) -> Region:
        """Return the only region of the graph, which calls each node that is not constant."""
        changing = [index for index in self.order if index not in self.constant]
        return Region(0, "pass", (), (), tuple(map(self._call, changing)))

    def _call(self, index: int) -> Call:
        gated = self.node(index).cls.gated
        return Call(index, self.kinds[index], "", (), self.copies(index), gated, (), (), ())
