"""Finds the graphs, nodes and attributes that calls of OmniGraph specify by paths, names, handles, or tuples of these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.format.wording import shown
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder, Place
from graphengine.isaac.omniverse.og_handles import GraphPipelineStage, OgAttribute, OgGraph, OgNode
from graphengine.isaac.omniverse.og_names import OmniGraphError, split_attribute, stage_of
from graphengine.isaac.omniverse.plain_data import is_unknown
from graphengine.isaac.omniverse.usd import UsdPrim
from graphengine.isaac.recorded_graph import RecordedGraph


def edited_graph(recorder: GraphRecorder, graph_id: Any) -> RecordedGraph:
    """Return the graph for a handle, a path, a prim, or a mapping with `graph_path`.

    A mapping always creates a new graph, and a path creates the graph if it does not exist.

    Raises:
        OmniGraphError: the graph cannot be created, or `graph_id` has another type.
    """
    if isinstance(graph_id, OgGraph):
        return graph_id.graph
    if isinstance(graph_id, Mapping):
        if "graph_path" not in graph_id:
            raise OmniGraphError("the mapping that describes a graph needs a 'graph_path'")
        stage = graph_id.get("pipeline_stage", GraphPipelineStage.GRAPH_PIPELINE_STAGE_SIMULATION)
        evaluator = graph_id.get("evaluator_name", "push")
        return recorder.create_graph(str(graph_id["graph_path"]), evaluator, stage_of(stage))
    if isinstance(graph_id, str | UsdPrim):
        path = str(graph_id if isinstance(graph_id, str) else graph_id.path)
        return recorder.graph_at(path) or recorder.create_graph(path)
    raise OmniGraphError(f"expected the path of a graph, or {{'graph_path': …}}, got {shown(graph_id)}")


def graph_at(recorder: GraphRecorder, graph_id: Any) -> OgGraph | None:
    """Return the graph for a path or handle; None if the path has no graph."""
    if isinstance(graph_id, OgGraph):
        return graph_id
    found = recorder.graph_at(str(graph_id))
    return OgGraph(recorder, found) if found is not None else None


def graph_above(recorder: GraphRecorder, path: str) -> RecordedGraph:
    """Return the graph at or above a prim path.

    Raises:
        OmniGraphError: no graph contains the path.
    """
    found = recorder.graph_of(path)
    if found is None:
        raise OmniGraphError(f"no graph contains {path!r}")
    return found[0]


def node_at(recorder: GraphRecorder, node_id: Any, graph_id: Any, known: Mapping[str, Any]) -> OgNode:
    """Return the node for a path, a name in `graph_id` or among the `known` nodes, a handle, a prim, or `(name, graph)`.

    Raises:
        OmniGraphError: the node does not exist, or `node_id` has another type.
    """
    if isinstance(node_id, tuple | list) and len(node_id) == 2:
        node_id, graph_id = node_id
    if isinstance(node_id, OgNode):
        return node_id
    if isinstance(node_id, UsdPrim):
        node_id = str(node_id.path)
    if not isinstance(node_id, str):
        raise OmniGraphError(f"expected the path of a node, got {shown(node_id)}")
    if isinstance(known.get(node_id), OgNode) and graph_id is None:
        return known[node_id]  # type: ignore[no-any-return]
    graph = graph_at(recorder, graph_id) if graph_id is not None else None
    return OgNode(recorder, *recorder.find_node(graph.graph if graph else None, str(node_id)))


def is_hidden(recorder: GraphRecorder, spec: Any) -> bool:
    """Return whether the path or object that specifies a graph, node or attribute is a value that only Omniverse knows."""
    return is_unknown(recorder.meant(spec) if isinstance(spec, str) else spec)


def place_at(recorder: GraphRecorder, spec: Any, node_id: Any, graph_id: Any, known: Mapping[str, Any]) -> Place:
    """Return the attribute for a path, a handle, a name with a node, or a tuple `(name, node)` or `(name, node, graph)`."""
    if isinstance(spec, OgAttribute):
        return spec.place
    if isinstance(spec, Sequence) and not isinstance(spec, str) and len(spec) in (2, 3):
        spec, node_id, *rest = spec
        graph_id = rest[0] if rest else graph_id
    if not isinstance(spec, str):
        raise OmniGraphError(f"expected an attribute such as 'Node.inputs:x', got {shown(spec)}")
    if node_id is not None:
        return node_at(recorder, node_id, graph_id, known).get_attribute(spec).place
    node_name, name = split_attribute(spec)
    if isinstance(node := known.get(node_name), OgNode):
        return node.get_attribute(name).place
    graph = graph_at(recorder, graph_id) if graph_id is not None else None
    return recorder.attribute(graph.graph if graph else None, str(spec))
