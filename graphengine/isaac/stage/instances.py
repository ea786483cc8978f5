"""Creates the instances of a graph: one copy for each prim that refers to the graph with `omniGraphs`."""

from __future__ import annotations

from dataclasses import replace

from graphengine.format.diagnostics import Findings
from graphengine.isaac.recorded_graph import VARIABLE, RecordedGraph, RecordedValue
from graphengine.isaac.stage.stage_contents import StagePrim

_TARGET = "_OMNI_GRAPH_TARGET"
"""Placeholder of OmniGraph: in an instance, a path that ends with it stands for the prim that refers to the graph."""


def instances(graph: RecordedGraph, prim: StagePrim, users: list[StagePrim], findings: Findings) -> list[RecordedGraph]:
    """Return the graph itself or, if it is instanced, one copy of the graph below each prim that refers to it.

    Args:
        graph: recorded graph.
        prim: prim of the graph, whose attribute `evaluationMode` decides.
        users: prims that refer to the graph.
        findings: receives a note on the instances, or a warning if the graph must be instanced but no prim refers to it.
    """
    mode = prim.text("evaluationMode")
    if mode == "Standalone" or (mode != "Instanced" and not users):
        return [graph]
    if not users:
        what = f"{prim.path} is left out: it is evaluated only for prims that refer to it, and no prim does"
        findings.add("W302", what, graph.span)
        return []
    paths = ", ".join(user.path for user in users)
    findings.add("N301", f"{prim.path} becomes one graph below each prim that refers to it: {paths}", graph.span)
    return [_instance(graph, f"{user.path}/{prim.name}", user) for user in users]


def _instance(graph: RecordedGraph, path: str, user: StagePrim) -> RecordedGraph:
    """Return a copy of the graph with the path `path` and the variable values that its instance, the prim `user`, sets."""
    variables = {}
    for name, variable in graph.variables.items():
        own = user.attributes.get(VARIABLE + name)
        variables[name] = variable if own is None or own.value is None else RecordedValue(own.value, variable.type)
    nodes = {}
    for name, node in graph.nodes.items():
        values = {port: replace(value, data=_aimed(value.data, user.path)) for port, value in node.values.items()}
        nodes[name] = replace(node, values=values)
    return replace(graph, path=path, nodes=nodes, variables=variables)


def _aimed(data: object, target: str) -> object:
    """Return a value with each path that ends with `_TARGET` replaced by the path `target`."""
    if isinstance(data, list):
        return [_aimed(item, target) for item in data]
    return target if isinstance(data, str) and data.rpartition("/")[2] == _TARGET else data
