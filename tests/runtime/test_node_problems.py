"""The problems of nodes that a session counts."""

from __future__ import annotations

from graphengine.node.dropped_values import DroppedValues
from graphengine.runtime.node_problems import NodeProblems


def test_problems_of_nodes_in_removed_graphs_are_removed() -> None:
    problems = NodeProblems(DroppedValues({"/first/g/A": 2, "/second/g/A": 1}))
    problems.add("/first/g/B", "broken")
    problems.add("/second/g/B", "broken")
    problems.keep(["/first/g", "/first/gg"])
    assert list(problems.all()) == ["/first/g/B", "/first/g/A"]
