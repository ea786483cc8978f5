"""Handles of graphs, nodes, attributes and variables, as in `omni.graph.core`."""

from __future__ import annotations

import enum
from collections.abc import Callable
from typing import Any

from graphengine.isaac.omniverse.graph_recorder import GraphRecorder, Place
from graphengine.isaac.omniverse.og_names import SIDES, OmniGraphError, stage_of
from graphengine.isaac.omniverse.stubs import StubObject, member
from graphengine.isaac.recorded_graph import RecordedGraph


class GraphPipelineStage(enum.Enum):
    """Stub of `og.GraphPipelineStage`, with the values of OmniGraph."""

    GRAPH_PIPELINE_STAGE_SIMULATION = 10
    GRAPH_PIPELINE_STAGE_PRERENDER = 20
    GRAPH_PIPELINE_STAGE_POSTRENDER = 30
    GRAPH_PIPELINE_STAGE_ONDEMAND = 200
    GRAPH_PIPELINE_STAGE_UNKNOWN = 100


ExecutionAttributeState = enum.IntEnum(
    "ExecutionAttributeState", "DISABLED ENABLED ENABLED_AND_PUSH LATENT_PUSH LATENT_FINISH", start=0
)
"""Stub of `og.ExecutionAttributeState`: values that old scripts write to execution outputs."""


class OgHandle:
    """Base class of the handles; two handles of one class are equal if their objects have the same path."""

    recorder: GraphRecorder
    plain_data: Callable[[], str]
    """Returns the path of the object."""

    def is_valid(self) -> bool:
        """Return whether the object still exists."""
        return True

    isValid = valid = is_valid  # noqa: N815  both are OmniGraph's

    def __bool__(self) -> bool:
        return self.is_valid()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, type(self)) and other.plain_data() == self.plain_data()

    def __hash__(self) -> int:
        return hash(self.plain_data())

    def __getattr__(self, name: str) -> Any:
        return member(f"og.{type(self).__name__.removeprefix('Og')}", name, self.recorder)


class OgGraph(OgHandle):
    """Stub of `og.Graph`: a recorded graph."""

    def __init__(self, recorder: GraphRecorder, graph: RecordedGraph) -> None:
        self.recorder, self.graph = recorder, graph

    def is_valid(self) -> bool:
        """Return whether the graph still exists."""
        return self.recorder.graphs.get(self.graph.path) is self.graph

    def get_path_to_graph(self) -> str:
        """Return the prim path of the graph."""
        return self.graph.path

    def get_nodes(self) -> list[OgNode]:
        """Return handles of all nodes in the graph."""
        return [OgNode(self.recorder, self.graph, name) for name in self.graph.nodes]

    def get_node(self, path: str) -> OgNode | None:
        """Return the node with a name or path; None if the graph has no such node."""
        try:
            return OgNode(self.recorder, *self.recorder.find_node(self.graph, path))
        except OmniGraphError:
            return None

    def create_node(self, path: str, type: str, *_: Any) -> OgNode:
        """Add a node of a given type to the graph; return its handle."""
        return OgNode(self.recorder, self.graph, self.recorder.create_node(self.graph, str(path), type))

    def destroy_node(self, path: str, *_: Any) -> bool:
        """Remove a node and its wires; return True."""
        self.recorder.delete_node(*self.recorder.find_node(self.graph, path))
        return True

    def create_variable(self, name: str, type: Any) -> OgVariable:
        """Add a variable to the graph; return its handle."""
        self.recorder.create_variable(self.graph, name, type)
        return OgVariable(self.recorder, self.graph, name)

    def find_variable(self, name: str) -> OgVariable | None:
        """Return the variable with this name; None if the graph has no such variable."""
        return OgVariable(self.recorder, self.graph, name) if name in self.graph.variables else None

    def get_variables(self) -> list[OgVariable]:
        """Return handles of all variables of the graph."""
        return [OgVariable(self.recorder, self.graph, name) for name in self.graph.variables]

    def change_pipeline_stage(self, stage: Any) -> None:
        """Set the graph's pipeline stage."""
        self.graph.pipeline_stage = stage_of(stage)

    def get_pipeline_stage(self) -> GraphPipelineStage:
        """Return the graph's pipeline stage."""
        return GraphPipelineStage[f"GRAPH_PIPELINE_STAGE_{self.graph.pipeline_stage.replace('_', '').upper()}"]

    def evaluate(self, *_: Any) -> bool:
        """Return True; the graph is recorded, not executed."""
        return True

    def set_disabled(self, disabled: bool) -> None:
        """If `disabled` is true, warn that a graph file cannot disable its graph."""
        if disabled:
            self.recorder.leave_out(
                f"the graph {self.graph.path} is disabled; a file cannot express that", "set_disabled"
            )

    plain_data = get_path_to_graph


class OgNode(OgHandle):
    """Stub of `og.Node`: a node or a compound."""

    def __init__(self, recorder: GraphRecorder, graph: RecordedGraph, name: str) -> None:
        self.recorder, self.graph, self.name = recorder, graph, name

    def is_valid(self) -> bool:
        """Return whether the node still exists."""
        return self.recorder.has_node(self.graph, self.name)

    def get_prim_path(self) -> str:
        """Return the prim path of the node."""
        return f"{self.graph.path}/{self.name}"

    def get_type_name(self) -> str:
        """Return the name of the node type."""
        known = self.graph.nodes.get(self.name)
        return known.type if known else "omni.graph.nodes.CompoundSubgraph"

    def get_graph(self) -> OgGraph:
        """Return the graph that contains the node."""
        return OgGraph(self.recorder, self.graph)

    def get_attribute(self, name: str) -> OgAttribute:
        """Return the attribute with a full name, such as `inputs:x`; for a promoted attribute, return the inner attribute."""
        return OgAttribute(self.recorder, self.recorder.inner(Place(self.graph, self.name, str(name))))

    def get_attribute_exists(self, name: str) -> bool:
        """Return whether the name begins with `inputs:`, `outputs:` or `state:`; the node type is not checked."""
        return str(name).startswith(SIDES)

    def create_attribute(self, name: str, type: Any, port_type: Any = None, *_: Any, **__: Any) -> bool:
        """Add an attribute to the node; return True."""
        self.recorder.create_attribute(Place(self.graph, self.name, name), type, port_type)
        return True

    plain_data = get_prim_path


class OgAttribute(OgHandle):
    """Stub of `og.Attribute`: an attribute of a node."""

    def __init__(self, recorder: GraphRecorder, place: Place) -> None:
        self.recorder, self.place = recorder, place

    def get(self, *_: Any, **__: Any) -> Any:
        """Return the value that the script set; otherwise a stub, because only Omniverse knows the default value."""
        value = self.recorder.value(self.place)
        return StubObject(f"the default of {self.place.path}", self.recorder) if value is None else value

    def set(self, value: Any, *_: Any, **__: Any) -> bool:
        """Set the value of the attribute; return True."""
        self.recorder.set_value(self.place, value)
        return True

    def get_name(self) -> str:
        """Return the full name of the attribute, such as `inputs:x`."""
        return self.place.name

    def get_path(self) -> str:
        """Return the USD path of the attribute."""
        return self.place.path

    def get_node(self) -> OgNode:
        """Return the node of the attribute."""
        return OgNode(self.recorder, self.place.graph, self.place.node)

    def connect(self, other: OgAttribute, *_: Any) -> bool:
        """Add a wire from this attribute to another one; return True."""
        self.recorder.connect(self.place, other.place)
        return True

    def disconnect(self, other: OgAttribute, *_: Any) -> bool:
        """Remove the wire from this attribute to another one; return True."""
        self.recorder.disconnect(self.place, other.place)
        return True

    def get_upstream_connections(self) -> list[OgAttribute]:
        """Return the attributes from which a wire leads to this attribute."""
        return [OgAttribute(self.recorder, place) for place in self.recorder.upstream(self.place)]

    def get_upstream_connection_count(self) -> int:
        """Return the number of wires into this attribute."""
        return len(self.get_upstream_connections())

    def get_downstream_connection_count(self) -> int:
        """Return the number of wires from this attribute."""
        return len(self.get_downstream_connections())

    def is_connected(self, other: OgAttribute) -> bool:
        """Return whether a wire leads from this attribute to `other`."""
        return other.place in self.recorder.downstream(self.place)

    def get_downstream_connections(self) -> list[OgAttribute]:
        """Return the attributes to which a wire leads from this attribute."""
        return [OgAttribute(self.recorder, place) for place in self.recorder.downstream(self.place)]

    def set_resolved_type(self, *_: Any) -> None:
        """Do nothing; graphengine derives the types of union ports from wires and values."""

    plain_data = get_path


class OgVariable(OgHandle):
    """Stub of `og.IVariable`: a variable of a graph."""

    def __init__(self, recorder: GraphRecorder, graph: RecordedGraph, name: str) -> None:
        self.recorder, self.graph, self.name = recorder, graph, name

    def get(self, *_: Any) -> Any:
        """Return the default value of the variable."""
        return self.graph.variables[self.name].data

    def set(self, _: Any, value: Any, *__: Any) -> bool:
        """Set the default value of the variable and return True; the context argument is ignored."""
        self.recorder.set_variable(self.graph, self.name, value)
        return True

    def __getattr__(self, name: str) -> Any:
        return member("og.IVariable", name, self.recorder)


HANDLES = (OgGraph, OgNode, OgAttribute, GraphPipelineStage, ExecutionAttributeState)
"""Handle classes that become members of the stub of `omni.graph.core`."""
