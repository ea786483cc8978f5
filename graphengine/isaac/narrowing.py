"""Inserts ToFloat nodes into wires from double to float; OmniGraph converts such values implicitly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from graphengine.format.diagnostics import Findings
from graphengine.isaac.recorded_graph import RecordedGraph, RecordedNode
from graphengine.node import PortType
from graphengine.node.node_class import Node

CONVERTER = "omni.graph.nodes.ToFloat"


def narrow(graph: RecordedGraph, classes: Mapping[str, type[Node] | None], findings: Findings) -> list[RecordedNode]:
    """Insert a ToFloat node behind each double output that is wired to float inputs; return the new nodes.

    Args:
        graph: graph that receives the nodes and wires.
        classes: node classes by node name in the graph; None for an unavailable type.
        findings: receives a note on each new node.
    """
    added: dict[tuple[str, str], RecordedNode] = {}
    for index, wire in enumerate(graph.wires):
        source, target = (_type(classes, *end) for end in wire.ends)
        if source is None or target != replace(source, base="float") or source.base != "double":
            continue
        end = wire.ends[0]
        if end not in added:
            name = f"{wire.source}_{wire.source_port.rpartition(':')[2]}_as_float"
            while name in graph.nodes:
                name += "_"
            added[end] = graph.nodes[name] = RecordedNode(name, CONVERTER, span=wire.span)
            graph.wires.append(replace(wire, target=name, target_port="inputs:value"))
            what = f"{wire.source}.{wire.source_port} is a double, but {wire.target}.{wire.target_port} takes a float"
            findings.add("N301", what, wire.span, f"the node {name} of type ToFloat is inserted to convert the value")
        graph.wires[index] = replace(wire, source=added[end].name, source_port="outputs:converted")
    return list(added.values())


def _type(classes: Mapping[str, type[Node] | None], node: str, key: str) -> PortType | None:
    """Return the type of the port `key` of a node; None for a union port, and for an unknown node or port."""
    cls = classes.get(node)
    port = cls.ports.get(key) if cls is not None else None
    return port.type if port is not None and isinstance(port.type, PortType) else None
