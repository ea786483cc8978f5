"""Directed graphs whose nodes are integers, with sorting and search for cycles.

networkx is imported only for a graph that has cycles, because the import takes as long as planning a typical graph.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import networkx as nx


def reached(starts: Iterable[int], onwards: Callable[[int], Iterable[int]]) -> dict[int, None]:
    """Return the nodes that can be reached from `starts`, and `starts` themselves, depth first.

    Args:
        starts: nodes from which the search starts, in this order.
        onwards: function that returns the nodes to which a node leads; they are searched in this order.
    """
    found: dict[int, None] = {}
    pending = list(starts)[::-1]
    while pending:
        node = pending.pop()
        if node not in found:
            found[node] = None
            pending += list(onwards(node))[::-1]
    return found


class Digraph:
    """A directed graph without parallel edges; nodes and edges keep the order in which they were added."""

    def __init__(self, nodes: Iterable[int], edges: Iterable[tuple[int, int]] = ()) -> None:
        self.successors: dict[int, dict[int, None]] = {node: {} for node in nodes}
        for source, target in edges:
            self.add_edge(source, target)

    def add_edge(self, source: int, target: int) -> None:
        """Add an edge from `source` to `target`, which are nodes of the graph; an existing edge stays single."""
        self.successors[source][target] = None

    def add_where_acyclic(self, edges: Sequence[tuple[int, int]]) -> set[tuple[int, int]]:
        """Add edges to an acyclic graph one by one; skip each edge that would close a cycle, and return the skipped edges."""
        tentative = Digraph(self.successors, [*self.edges(), *edges])
        component = {node: number for number, part in enumerate(tentative.components()) for node in part}
        refused: set[tuple[int, int]] = set()
        for source, target in edges:
            if self.has_edge(source, target):
                continue
            if component[source] == component[target] and self.has_path(target, source):
                refused.add((source, target))
            else:
                self.add_edge(source, target)
        return refused

    def edges(self) -> list[tuple[int, int]]:
        """Return all edges as (source, target), grouped by source."""
        return [(source, target) for source, targets in self.successors.items() for target in targets]

    def has_edge(self, source: int, target: int) -> bool:
        """Return whether an edge leads from `source` to `target`."""
        return target in self.successors[source]

    def descendants(self, start: int) -> set[int]:
        """Return all nodes that can be reached from `start`, without `start` itself."""
        return set(reached([start], self.successors.__getitem__)) - {start}

    def has_path(self, source: int, target: int) -> bool:
        """Return whether `target` can be reached from `source`; true if both are the same node."""
        return source == target or target in self.descendants(source)

    def sort(self, key: Callable[[int], Any] | None = None) -> list[int]:
        """Return the nodes in topological order; nodes in a cycle, and nodes downstream of a cycle, are left out.

        Args:
            key: sort key. A node is ready when all its predecessors are in the list; of all ready nodes, the one with the
                smallest key comes next. None: nodes come in the order in which they become ready.
        """
        waiting = Counter(target for _, target in self.edges())
        free = [(key(node) if key else i, node) for i, node in enumerate(self.successors) if not waiting[node]]
        heapq.heapify(free)
        order: list[int] = []
        count = len(self.successors)
        while free:
            _, node = heapq.heappop(free)
            order.append(node)
            for target in self.successors[node]:
                waiting[target] -= 1
                if not waiting[target]:
                    count += 1
                    heapq.heappush(free, (key(target) if key else count, target))
        return order

    def components(self) -> list[set[int]]:
        """Return the strongly connected components; each node outside all cycles forms a component alone."""
        order = self.sort()
        if len(order) == len(self.successors):
            return [{node} for node in order]
        import networkx as nx

        return list(nx.strongly_connected_components(self._as_networkx()))

    def find_cycle(self, component: set[int], start: int) -> list[tuple[int, int]]:
        """Return the edges of a cycle within a strongly connected component; the search starts at the node `start`."""
        import networkx as nx

        return [(edge[0], edge[1]) for edge in nx.find_cycle(self._as_networkx().subgraph(component), start)]

    def _as_networkx(self) -> nx.DiGraph[int]:
        import networkx as nx

        graph: nx.DiGraph[int] = nx.DiGraph()
        graph.add_nodes_from(self.successors)
        graph.add_edges_from(self.edges())
        return graph
