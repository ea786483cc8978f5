"""Indexes the wires of a resolved graph by node, and reports cycles of data nodes and of execution wires."""

from __future__ import annotations

from dataclasses import replace

from graphengine.compiler.digraph import Digraph
from graphengine.compiler.graph import Graph, Instance, Wire
from graphengine.format.diagnostics import Findings
from graphengine.node.port import Port, Side


class WiredGraph:
    """A graph with its wires indexed by node.

    Attributes:
        graph: the resolved graph.
        findings: receives errors and warnings.
        kinds: kind of each node, such as `data` or `event`, by index.
        acyclic: whether the graph can be planned: it has no illegal cycle.
    """

    def __init__(self, graph: Graph, findings: Findings) -> None:
        self.graph = graph
        self.findings = findings
        self.kinds = [instance.cls.kind() for instance in graph.instances]
        self.data_in: dict[int, list[Wire]] = {}
        """Data wires into each node, by index of the node.

        A wire that begins at a wired input is replaced by a wire from the source of that input's value.
        """
        self.exec_out: dict[int, list[Wire]] = {}
        self.exec_in: dict[int, list[Wire]] = {}
        self.execution = Digraph(range(len(self.kinds)))
        """Graph with an edge from each node to each node that it can fire in the same pass."""
        self.pending_control: set[int] = set()
        """`order` of each wire into a control input that closes a cycle; its firing acts in the next activation of the target."""
        self.data_rank: dict[int, int] = {}
        """Rank of each data node, by index: higher than the ranks of all data nodes that it reads."""
        self.counting: set[int] = set()
        """Nodes whose class counts activations (`counts`) and that can be fired several times in one run of a region."""
        self._index_wires()
        self.acyclic = all([self._check_data_cycles(), self._check_exec_cycles()])  # a list: both checks run
        if self.acyclic:
            self._find_counting()

    def node(self, index: int) -> Instance:
        """Return the instance with an index."""
        return self.graph.instances[index]

    def _index_wires(self) -> None:
        wire_into = {(wire.target, wire.target_field): wire for wire in self.graph.data_wires}
        for wire in self.graph.data_wires:
            origin, converter, seen = wire, wire.converter, {wire.order}
            while self.reads_input(origin):
                upstream = wire_into.get((origin.source, origin.source_field))
                if upstream is None or upstream.order in seen:
                    break
                seen.add(upstream.order)
                origin, converter = upstream, converter or upstream.converter
            effective = replace(wire, source=origin.source, source_field=origin.source_field, converter=converter)
            self.data_in.setdefault(wire.target, []).append(effective)
        for wire in self.graph.exec_wires:
            self.exec_out.setdefault(wire.source, []).append(wire)
            self.exec_in.setdefault(wire.target, []).append(wire)

    def reads_input(self, wire: Wire) -> bool:
        """Return whether a wire begins at an input instead of an output. If the wire is in `data_in`, this input is unwired."""
        return self.graph.source(wire)[1].side == "inputs"

    def _check_data_cycles(self) -> bool:
        pure = [i for i, kind in enumerate(self.kinds) if kind == "data"]
        into = (wire for index in pure for wire in self.data_in.get(index, []))
        wires = [wire for wire in into if self.kinds[wire.source] == "data" and not self.reads_input(wire)]
        graph = Digraph(pure, [(wire.source, wire.target) for wire in wires])
        if self._report_cycles("G209", "data nodes form a cycle", "a node that has an execution input", graph, wires):
            return False
        self.data_rank = _ranks(graph)
        return True

    def _check_exec_cycles(self) -> bool:
        """Return whether the execution wires form no illegal cycle; report illegal cycles.

        A wire into a control input may close a cycle; its firing then acts in the next activation of the target.
        """
        graph = self.execution
        wires, control = list[Wire](), list[Wire]()
        for wire in (wire for wire in self.graph.exec_wires if self.kinds[wire.source] != "latent"):
            (control if self.graph.target(wire)[1].control else wires).append(wire)
        for wire in wires:
            graph.add_edge(wire.source, wire.target)
        breakers = "a Delay node, or a control input such as `reset`"
        if self._report_cycles("G210", "execution wires form a cycle", breakers, graph, wires):
            return False
        rank = _ranks(graph)
        for wire in control:
            backward = rank[wire.source] >= rank[wire.target]
            if backward and graph.has_path(wire.target, wire.source):
                self.pending_control.add(wire.order)
                continue
            graph.add_edge(wire.source, wire.target)
            if backward:
                rank = _ranks(graph)
        return True

    def _report_cycles(self, code: str, what: str, breakers: str, graph: Digraph, wires: list[Wire]) -> bool:
        """Add an error for one cycle in each strongly connected component; return whether there is a cycle.

        Args:
            code: code of the findings.
            what: first half of the message, before the list of nodes.
            breakers: nodes or inputs with which a user can break the cycle.
            graph: graph in which cycles are searched.
            wires: wires that form the edges of the graph.
        """
        between = {(wire.source, wire.target): wire for wire in reversed(wires)}
        found = False
        for component in sorted(graph.components(), key=min):
            first = min(component)
            if len(component) > 1 or graph.has_edge(first, first):
                loop, found = [between[edge] for edge in graph.find_cycle(component, first)], True
                path = " -> ".join(self.node(wire.source).id for wire in (*loop, loop[0]))
                related = [*((wire.span, str(wire)) for wire in loop), *loop[0].entry.via]
                remedy = f"break the cycle with {breakers}"
                self.findings.add(code, f"{what}: {path}", loop[0].span, remedy, related=related)
        return found

    def forward(self, wire: Wire) -> bool:
        """Return whether an execution wire fires its target in the same run of its region.

        Wires from latent nodes fire in a later pass, and control wires that close a cycle act in the next activation.
        """
        return wire.order not in self.pending_control and self.kinds[wire.source] != "latent"

    def _find_counting(self) -> None:
        for index in self.execution.sort():
            if self.node(index).cls.counts and self.fired_often(index):
                self.counting.add(index)

    def fired_often(self, index: int) -> bool:
        """Return whether a node can be fired more than once in one run of a region."""
        wires = self.exec_in.get(index, [])
        return len(wires) > 1 or any(wire.source in self.counting for wire in wires)

    def exec_ports(self, index: int, side: Side) -> list[Port]:
        """Return the execution ports of a node on one side, `inputs` or `outputs`."""
        return [port for port in self.node(index).cls.fields.values() if port.is_exec and port.side == side]


def _ranks(graph: Digraph) -> dict[int, int]:
    """Return the position of each node of an acyclic graph in a topological order."""
    return {index: rank for rank, index in enumerate(graph.sort())}
