"""Finds the nodes and resources on which each data node depends; they determine when it must be computed again."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator

from graphengine.compiler.digraph import reached
from graphengine.compiler.graph import Graph, Wire
from graphengine.compiler.plan import Copy
from graphengine.compiler.planning.wiring import WiredGraph
from graphengine.format.diagnostics import Findings


class DependencyGraph(WiredGraph):
    """A wired graph with the dependencies of its data nodes.

    Attributes:
        flagged: data nodes for which a flag at run time says whether they are stale; the set grows while calls are written.
        shared: data nodes that several nodes need, and all data nodes that these data nodes read; all are in `flagged`.
        placed: data nodes that the calls compute; the set grows while calls are written.
        gates: as in `Plan.gates`.
    """

    def __init__(self, graph: Graph, findings: Findings) -> None:
        super().__init__(graph, findings)
        self.flagged: set[int] = set()
        self.gates: dict[int, tuple[int, ...]] = {}
        self.shared: set[int] = set()
        self.placed: set[int] = set()
        self._find_dependencies()

    def _find_dependencies(self) -> None:
        self.shows: dict[int, set[int]] = {}
        """For each data node: the nodes of other kinds whose outputs reach the data node, directly or through data nodes."""
        self.depends: dict[int, set[int]] = {}
        """For each data node: the nodes in `shows`, and the nodes that write a resource on which the value depends."""
        self.dependents: dict[int, list[int]] = {}
        """For each node that is not a data node: the data nodes that depend on it."""
        self.volatile: set[int] = set()
        writers: dict[str, set[int]] = {}
        for instance in self.graph.instances:
            for key in instance.writes:
                writers.setdefault(key, set()).add(instance.index)
        for index in self.data_rank:
            instance = self.node(index)
            shows: set[int] = set()
            written: set[int] = set()
            if instance.cls.volatile:
                self.volatile.add(index)
                written.update(*(writers.get(key, ()) for key in instance.reads))
            for source in self._sources_of_value(index):
                shows |= self.shows[source] if self.kinds[source] == "data" else {source}
                written |= self.depends.get(source, set())
                if source in self.volatile:
                    self.volatile.add(index)
            self.shows[index], self.depends[index] = shows, shows | written
            for source in sorted(self.depends[index]):
                self.dependents.setdefault(source, []).append(index)
        self.constant = {d for d in self.data_rank if not self.depends[d] and d not in self.volatile}

    def _sources_of_value(self, index: int) -> Iterator[int]:
        """Yield the nodes whose outputs are wired to inputs of a node."""
        return (wire.source for wire in self.data_in.get(index, []) if not self.reads_input(wire))

    def upstream(self, readers: Iterable[int], known: Container[int] = ()) -> list[int]:
        """Return the data nodes on which `readers` depend, directly or through data nodes; each follows the nodes that it reads.

        Data nodes in `known`, and data nodes that only these read, are left out.
        """

        def sources(*nodes: int) -> list[int]:
            found = (source for node in nodes for source in self._sources_of_value(node))
            return [source for source in found if source in self.data_rank and source not in known]

        return sorted(reached(sources(*readers), sources), key=lambda data: self.data_rank[data])

    def data_sources(self, index: int) -> list[int]:
        """Return the data nodes, except constant ones, whose outputs are wired to a node."""
        return [i for i in self._sources_of_value(index) if i in self.data_rank and i not in self.constant]

    def share_upstream(self) -> None:
        """Add the data nodes that shared data nodes read to `shared`, and all shared data nodes to `flagged`."""
        self.shared |= {*self.upstream(self.shared, self.shared)} - self.constant
        self.flagged |= self.shared

    def marks(self, index: int) -> tuple[int, ...]:
        """Return the data nodes in `flagged` that become stale when a node is computed."""
        return tuple(data for data in self.dependents.get(index, ()) if data in self.flagged)

    def copies(self, index: int, *, constant: bool | None = False) -> tuple[Copy, ...]:
        """Return the copies of values along the wires into a node.

        Args:
            index: index of the node.
            constant: True: only values that cannot change while the graph runs; False: only the other values; None: all values.
        """
        copies = []
        for wire in self.data_in.get(index, []):
            fixed = self.reads_input(wire) or wire.source in self.constant
            if constant is None or fixed == constant:
                setup = self.graph.target(wire)[1].setup and not fixed
                copies.append(Copy(wire.source, wire.source_field, index, wire.target_field, wire.converter, setup))
        return tuple(copies)

    def report_previous(self, wire: Wire, source: int, why: str, remedy: str) -> None:
        """Add a warning that a wire carries a value of the previous pass.

        Args:
            wire: the wire.
            source: index of the node that computes the value.
            why: reason why the value is old; a clause that follows "because".
            remedy: what to do if this is not intended; a clause that follows "otherwise".
        """
        message = f"{wire.entry.target} reads the value that {self.node(source).id} had before this pass, because {why}"
        either = f"if this is intended, ignore the warning; otherwise {remedy}"
        self.findings.add("W104", message, wire.span, either, related=wire.entry.via)
