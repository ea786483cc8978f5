"""Directed graphs, compared with networkx on drawn ones."""

from __future__ import annotations

import random

import networkx as nx
import pytest

from graphengine.compiler.digraph import Digraph


@pytest.mark.parametrize("seed", range(30))
def test_orders_paths_and_components_are_those_of_networkx(seed: int) -> None:
    draw = random.Random(seed)
    nodes = draw.sample(range(20), 12)
    edges = [(draw.choice(nodes), draw.choice(nodes)) for _ in range(draw.randrange(30))]
    if seed % 2:
        edges = [(one, other) for one, other in edges if nodes.index(one) < nodes.index(other)]
    mine = Digraph(nodes, edges)
    theirs: nx.DiGraph[int] = nx.DiGraph()
    theirs.add_nodes_from(nodes)
    theirs.add_edges_from(edges)
    assert {frozenset(part) for part in mine.components()} == set(
        map(frozenset, nx.strongly_connected_components(theirs))
    )
    for node in nodes:
        assert mine.descendants(node) == nx.descendants(theirs, node)
        assert [mine.has_path(node, end) for end in nodes] == [nx.has_path(theirs, node, end) for end in nodes]
    if nx.is_directed_acyclic_graph(theirs):
        assert mine.sort() == list(nx.topological_sort(theirs))
        assert mine.sort(key=int) == list(nx.lexicographical_topological_sort(theirs))
        return
    circular = {node for part in nx.simple_cycles(theirs) for node in part}
    assert set(mine.sort()) == set(nodes) - circular.union(*(nx.descendants(theirs, node) for node in circular))
