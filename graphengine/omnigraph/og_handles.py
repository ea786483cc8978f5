"""What stands for graphs, nodes, attributes and variables in `omni.graph.core`, and how scripts name them."""

from __future__ import annotations

import enum
from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.diagnostics import shown
from graphengine.omnigraph.recorded import RecordedGraph
from graphengine.omnigraph.recorder import OmniGraphError, Place, Recorder, stage_of
from graphengine.omnigraph.stand_in import StandIn
from graphengine.omnigraph.usd import Prim


class GraphPipelineStage(enum.Enum):
    """When a graph is evaluated."""

    GRAPH_PIPELINE_STAGE_SIMULATION = 10
    GRAPH_PIPELINE_STAGE_PRERENDER = 20
    GRAPH_PIPELINE_STAGE_POSTRENDER = 30
    GRAPH_PIPELINE_STAGE_ONDEMAND = 200
    GRAPH_PIPELINE_STAGE_UNKNOWN = 100


class ExecutionAttributeState(enum.IntEnum):
    """What was once written to execution outputs."""

    DISABLED = 0
    ENABLED = 1
    ENABLED_AND_PUSH = 2
    LATENT_PUSH = 3
    LATENT_FINISH = 4


class Handle:
    """What stands for something in a graph."""

    def is_valid(self) -> bool:
        """Whether it is still there."""
        return True

    isValid = valid = is_valid  # noqa: N815  both are OmniGraph's

    def __bool__(self) -> bool:
        return self.is_valid()


class Graph(Handle):
    """A graph."""

    def __init__(self, recorder: Recorder, graph: RecordedGraph) -> None:
        self.recorder, self.graph = recorder, graph

    def is_valid(self) -> bool:
        """Whether it is still there."""
        return self.recorder.graphs.get(self.graph.path) is self.graph

    def get_path_to_graph(self) -> str:
        """Its prim."""
        return self.graph.path

    def get_nodes(self) -> list[Node]:
        """Its nodes."""
        return [Node(self.recorder, self.graph, name) for name in self.graph.nodes]

    def get_node(self, path: str) -> Node | None:
        """A node by its path; None where there is none."""
        try:
            return Node(self.recorder, *self.recorder.find_node(self.graph, path))
        except OmniGraphError:
            return None

    def create_node(self, path: str, type: str, *_: Any) -> Node:
        """Make a node."""
        return Node(self.recorder, self.graph, self.recorder.create_node(self.graph, str(path), type))

    def destroy_node(self, path: str, *_: Any) -> bool:
        """Remove a node."""
        self.recorder.delete_node(*self.recorder.find_node(self.graph, path))
        return True

    def create_variable(self, name: str, type: Any) -> Variable:
        """Add a variable."""
        self.recorder.create_variable(self.graph, name, type)
        return Variable(self.recorder, self.graph, name)

    def find_variable(self, name: str) -> Variable | None:
        """A variable by its name."""
        return Variable(self.recorder, self.graph, name) if name in self.graph.variables else None

    def get_variables(self) -> list[Variable]:
        """Its variables."""
        return [Variable(self.recorder, self.graph, name) for name in self.graph.variables]

    def change_pipeline_stage(self, stage: Any) -> None:
        """Have it evaluated at another time."""
        self.graph.pipeline_stage = stage_of(stage)

    def get_pipeline_stage(self) -> Any:
        """When it is evaluated."""
        return self.graph.pipeline_stage

    def evaluate(self, *_: Any) -> bool:
        """Nothing: what a graph does is no part of it."""
        return True

    def set_disabled(self, disabled: bool) -> None:
        """A graph's file has no such thing."""
        if disabled:
            self.recorder.leave_out(f"the graph {self.graph.path} is disabled; its file is not", "set_disabled")

    def plain_data(self) -> str:
        """Its prim."""
        return self.graph.path

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Graph) and other.graph is self.graph

    def __hash__(self) -> int:
        return hash(self.graph.path)

    def __getattr__(self, name: str) -> Any:
        return _unknown(self.recorder, "og.Graph", name)


class Node(Handle):
    """A node, or a compound."""

    def __init__(self, recorder: Recorder, graph: RecordedGraph, name: str) -> None:
        self.recorder, self.graph, self.name = recorder, graph, name

    def is_valid(self) -> bool:
        """Whether it is still there."""
        return self.name in self.graph.nodes or self.name in self.recorder.compounds[self.graph.path]

    def get_prim_path(self) -> str:
        """Its prim."""
        return f"{self.graph.path}/{self.name}"

    def get_type_name(self) -> str:
        """Its type."""
        known = self.graph.nodes.get(self.name)
        return known.type if known else "omni.graph.nodes.CompoundSubgraph"

    def get_graph(self) -> Graph:
        """The graph that it is in."""
        return Graph(self.recorder, self.graph)

    def get_attribute(self, name: str) -> Attribute:
        """One of its attributes by full name."""
        return Attribute(self.recorder, self.recorder.inner(Place(self.graph, self.name, str(name))))

    def get_attribute_exists(self, name: str) -> bool:
        """Whether it may have such an attribute: types are not known here."""
        return str(name).startswith(("inputs:", "outputs:", "state:"))

    def create_attribute(self, name: str, type: Any, *_: Any, **__: Any) -> bool:
        """Add an attribute."""
        self.recorder.create_attribute(Place(self.graph, self.name, name), type)
        return True

    def plain_data(self) -> str:
        """Its prim."""
        return self.get_prim_path()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Node) and (other.graph, other.name) == (self.graph, self.name)

    def __hash__(self) -> int:
        return hash(self.get_prim_path())

    def __getattr__(self, name: str) -> Any:
        return _unknown(self.recorder, "og.Node", name)


class Attribute(Handle):
    """An attribute of a node."""

    def __init__(self, recorder: Recorder, place: Place) -> None:
        self.recorder, self.place = recorder, place

    def get(self, *_: Any, **__: Any) -> Any:
        """What it was set to."""
        return self.recorder.value(self.place)

    def set(self, value: Any, *_: Any, **__: Any) -> bool:
        """Set it."""
        self.recorder.set_value(self.place, value)
        return True

    def get_name(self) -> str:
        """Its full name."""
        return self.place.name

    def get_path(self) -> str:
        """As USD writes it."""
        return self.place.path

    def get_node(self) -> Node:
        """The node that has it."""
        return Node(self.recorder, self.place.graph, self.place.node)

    def connect(self, other: Attribute, *_: Any) -> bool:
        """Wire it to another one."""
        self.recorder.connect(self.place, other.place)
        return True

    def disconnect(self, other: Attribute, *_: Any) -> bool:
        """Remove that wire."""
        self.recorder.disconnect(self.place, other.place)
        return True

    def get_upstream_connections(self) -> list[Attribute]:
        """What is wired to it."""
        return [Attribute(self.recorder, place) for place in self.recorder.upstream(self.place)]

    def get_downstream_connections(self) -> list[Attribute]:
        """What it is wired to."""
        return [Attribute(self.recorder, place) for place in self.recorder.downstream(self.place)]

    def set_resolved_type(self, *_: Any) -> None:
        """Nothing: wires and values tell the type."""

    def plain_data(self) -> str:
        """As USD writes it."""
        return self.place.path

    def __getattr__(self, name: str) -> Any:
        return _unknown(self.recorder, "og.Attribute", name)


class Variable(Handle):
    """A variable of a graph."""

    def __init__(self, recorder: Recorder, graph: RecordedGraph, name: str) -> None:
        self.recorder, self.graph, self.name = recorder, graph, name

    def get(self, *_: Any) -> Any:
        """Its default."""
        return self.graph.variables[self.name].data

    def set(self, _: Any, value: Any, *__: Any) -> bool:
        """Set its default; a context comes first."""
        self.recorder.set_variable(self.graph, self.name, value)
        return True

    def __getattr__(self, name: str) -> Any:
        return _unknown(self.recorder, "og.IVariable", name)


def _unknown(recorder: Recorder, owner: str, name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    return StandIn(f"{owner}.{name}", recorder)


def edited_graph(recorder: Recorder, graph_id: Any) -> RecordedGraph:
    """The graph that an edit is for; made where there is none yet."""
    if isinstance(graph_id, Graph):
        return graph_id.graph
    if isinstance(graph_id, Mapping):
        if "graph_path" not in graph_id:
            raise OmniGraphError("no graph_path for the graph")
        stage = graph_id.get("pipeline_stage", GraphPipelineStage.GRAPH_PIPELINE_STAGE_SIMULATION)
        evaluator = graph_id.get("evaluator_name", "push")
        return recorder.create_graph(str(graph_id["graph_path"]), evaluator, stage_of(stage))
    if isinstance(graph_id, str | Prim):
        path = graph_id if isinstance(graph_id, str) else graph_id.path
        found = recorder.graphs.get(str(path).rstrip("/"))
        return found if found is not None else recorder.create_graph(str(path))
    raise OmniGraphError(f"expected the path of a graph, or {{'graph_path': …}}, got {shown(graph_id)}")


def graph_at(recorder: Recorder, graph_id: Any) -> Graph | None:
    """A graph by its path; None where there is none."""
    if isinstance(graph_id, Graph):
        return graph_id
    found = recorder.graphs.get(str(graph_id).rstrip("/"))
    return Graph(recorder, found) if found is not None else None


def graph_above(recorder: Recorder, path: str) -> RecordedGraph:
    """The graph that a path leads into.

    Raises:
        OmniGraphError: there is none.
    """
    found = recorder.graph_of(path)
    if found is None:
        raise OmniGraphError(f"no graph holds {path!r}")
    return found[0]


def node_at(recorder: Recorder, node_id: Any, graph_id: Any, known: Mapping[str, Any]) -> Node:
    """A node by its path, by its name in a graph or among those known, or by `(name, graph)`.

    Raises:
        OmniGraphError: there is none.
    """
    if isinstance(node_id, tuple | list) and len(node_id) == 2:
        node_id, graph_id = node_id
    if isinstance(node_id, Node):
        return node_id
    if isinstance(node_id, Prim):
        node_id = str(node_id.path)
    if not isinstance(node_id, str):
        raise OmniGraphError(f"expected the path of a node, got {shown(node_id)}")
    if isinstance(known.get(node_id), Node) and graph_id is None:
        return known[node_id]  # type: ignore[no-any-return]
    graph = graph_at(recorder, graph_id) if graph_id is not None else None
    return Node(recorder, *recorder.find_node(graph.graph if graph else None, str(node_id)))


def is_unknown(spec: Any) -> bool:
    """Whether it names an attribute by what only Omniverse knows."""
    return isinstance(spec, StandIn) or (isinstance(spec, str) and "<unknown: " in spec)


def place_at(recorder: Recorder, spec: Any, node_id: Any, graph_id: Any, known: Mapping[str, Any]) -> Place:
    """The attribute that a path, a handle, or a name with a node means."""
    if isinstance(spec, Attribute):
        return spec.place
    if isinstance(spec, Sequence) and not isinstance(spec, str) and len(spec) in (2, 3):
        spec, node_id, *rest = spec
        graph_id = rest[0] if rest else graph_id
    if not isinstance(spec, str):
        raise OmniGraphError(f"expected an attribute such as 'Node.inputs:x', got {shown(spec)}")
    if node_id is not None:
        node = node_at(recorder, node_id, graph_id, known)
        return recorder.inner(Place(node.graph, node.name, str(spec)))
    node_name, _, name = str(spec).rpartition(".")
    if isinstance(known.get(node_name), Node):
        node = known[node_name]
        return recorder.inner(Place(node.graph, node.name, name))
    graph = graph_at(recorder, graph_id) if graph_id is not None else None
    return recorder.attribute(graph.graph if graph else None, str(spec))
