"""The stub of `omni.graph.core`, whose controllers record what is done to graphs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graphengine.format.wording import shown
from graphengine.isaac.omniverse.asyncio_stub import Task
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder, Place
from graphengine.isaac.omniverse.og_edit import Edit, Keys, name_lost
from graphengine.isaac.omniverse.og_handles import (
    ExecutionAttributeState,
    GraphPipelineStage,
    OgAttribute,
    OgGraph,
    OgNode,
    OgVariable,
)
from graphengine.isaac.omniverse.og_lookup import edited_graph, graph_above, graph_at, is_hidden, node_at, place_at
from graphengine.isaac.omniverse.og_members import Open, either
from graphengine.isaac.omniverse.og_names import OmniGraphError
from graphengine.isaac.omniverse.og_types import (
    AttributePortType,
    AttributeRole,
    AttributeType,
    BaseDataType,
    NodeType,
    Type,
)
from graphengine.isaac.omniverse.plain_data import unknown
from graphengine.isaac.omniverse.stubs import ELSEWHERE, OWN, StubObject, draw


class Controller(metaclass=Open):
    """`og.Controller`, for one recorder, which a subclass has; an instance remembers the nodes that it made by their names."""

    Keys = Keys
    recorder: GraphRecorder

    def __init__(self, attribute: Any = None, **named: Any) -> None:
        self.attribute_id = attribute if attribute is not None else named.get("attribute")
        self.known: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(type(self), name)

    # Each takes the class, then the instance or None.

    @either
    def edit(
        cls: Any,
        self: Any,
        graph_id: Any = None,
        edit_commands: Mapping[Any, Any] | None = None,
        *,
        path_to_object_map: dict[str, Any] | None = None,
        allow_exists_node: bool = False,
        **_: Any,
    ) -> tuple[Any, Any, Any, dict[str, Any]]:
        """Find or make a graph, and do all that the commands say in the documented order."""
        recorder: GraphRecorder = cls.recorder
        if isinstance(graph_id, StubObject):
            recorder.leave_out(f"an edit of {graph_id} is left out: only Omniverse knows that graph")
            return graph_id, graph_id, graph_id, {}
        known, commands = len(recorder.graphs), edit_commands or {}
        try:
            graph = edited_graph(recorder, graph_id)
        except OmniGraphError as error:
            name_lost(error, commands, 0)
            raise
        if len(recorder.graphs) > known and not isinstance(graph_id, Mapping) and Keys.CREATE_NODES not in commands:
            recorder.opened.add(graph.path)
        names = path_to_object_map if path_to_object_map is not None else self.known if self else {}
        edit = Edit(recorder, graph, names, allow_exists_node)
        edit.run(commands, "")
        return OgGraph(recorder, graph), edit.made, edit.prims, names

    @either
    def create_graph(cls: Any, self: Any, graph_id: Any, *_: Any, **__: Any) -> OgGraph:
        """Make a graph."""
        return OgGraph(cls.recorder, edited_graph(cls.recorder, graph_id))

    @either
    def graph(cls: Any, self: Any, graph_id: Any) -> OgGraph | None:
        """A graph by its path."""
        return graph_at(cls.recorder, graph_id)

    @either
    def node(cls: Any, self: Any, node_id: Any = None, graph_id: Any = None, **named: Any) -> OgNode:
        """A node by its path, by its name and graph, or by `(name, graph)`."""
        return node_at(cls.recorder, node_id if node_id is not None else named.get("path"), graph_id, _known(self))

    @either
    def attribute(cls: Any, self: Any, attribute_id: Any, node_id: Any = None, graph_id: Any = None) -> Any:
        """An attribute by its path, by its name and node, or by `(name, node)`."""
        if is_hidden(cls.recorder, attribute_id):
            return _leave_attribute(cls.recorder, attribute_id)
        return OgAttribute(cls.recorder, _place(cls, self, attribute_id, node_id, graph_id))

    @either
    def variable(cls: Any, self: Any, variable_id: Any, graph_id: Any = None) -> OgVariable:
        """A variable by its name and graph; one itself too."""
        if isinstance(variable_id, OgVariable):
            return variable_id
        name, graph = variable_id if isinstance(variable_id, tuple) else (variable_id, graph_id)
        found = graph_at(cls.recorder, graph)
        if found is None or name not in found.graph.variables:
            raise OmniGraphError(f"no variable {shown(name)} in {shown(graph)}")
        return OgVariable(cls.recorder, found.graph, name)

    @either
    def create_node(
        cls: Any, self: Any, node_id: Any, node_type_id: Any, allow_exists: bool = False, **_: Any
    ) -> OgNode:
        """Make a node at a path, or with a name in a graph: `(name, graph)`."""
        recorder = cls.recorder
        name, graph_id = node_id if isinstance(node_id, tuple) else (node_id, None)
        inside = edited_graph(recorder, graph_id) if graph_id is not None else graph_above(recorder, str(name))
        return OgNode(recorder, inside, recorder.create_node(inside, str(name), node_type_id, exist_ok=allow_exists))

    @either
    def delete_node(cls: Any, self: Any, node_id: Any, *_: Any, **__: Any) -> None:
        """Remove a node."""
        node = node_at(cls.recorder, node_id, None, _known(self))
        cls.recorder.delete_node(node.graph, node.name)

    @either
    def create_variable(cls: Any, self: Any, graph_id: Any, name: str, type: Any, *_: Any, **__: Any) -> OgVariable:
        """Add a variable to a graph."""
        return OgGraph(cls.recorder, edited_graph(cls.recorder, graph_id)).create_variable(name, type)

    @either
    def set_variable_default_value(cls: Any, self: Any, variable_id: Any, value: Any) -> None:
        """Set the default of a variable."""
        cls.variable(variable_id).set(None, value)

    @either
    def get_variable_default_value(cls: Any, self: Any, variable_id: Any) -> Any:
        """The default of a variable."""
        return cls.variable(variable_id).get()

    @either
    def node_type(cls: Any, self: Any, type_id: Any) -> NodeType:
        """A type of nodes by its name, or that of a node."""
        name = type_id.get_type_name() if isinstance(type_id, OgNode) else str(type_id)
        if name not in cls.recorder.types and not cls.recorder.assumed:
            raise OmniGraphError(f"there is no node type {name!r}")
        return NodeType(name)

    @either
    def create_attribute(
        cls: Any,
        self: Any,
        node_id: Any,
        attr_name: str,
        attr_type: Any,
        attr_port: Any = None,
        attr_default: Any = None,
        *_: Any,
        **__: Any,
    ) -> OgAttribute:
        """Add an attribute to a node."""
        node = node_at(cls.recorder, node_id, None, _known(self))
        place = cls.recorder.create_attribute(Place(node.graph, node.name, attr_name), attr_type, attr_port)
        if attr_default is not None:
            cls.recorder.set_value(place, attr_default)
        return OgAttribute(cls.recorder, place)

    @either
    def connect(cls: Any, self: Any, src_spec: Any, dst_spec: Any, *_: Any, **__: Any) -> None:
        """Wire two attributes."""
        cls.recorder.connect(_place(cls, self, src_spec), _place(cls, self, dst_spec))

    @either
    def disconnect(cls: Any, self: Any, src_spec: Any, dst_spec: Any, *_: Any, **__: Any) -> None:
        """Remove a wire."""
        cls.recorder.disconnect(_place(cls, self, src_spec), _place(cls, self, dst_spec))

    @either
    def disconnect_all(cls: Any, self: Any, attribute_spec: Any, *_: Any, **__: Any) -> None:
        """Remove the wires of an attribute."""
        cls.recorder.disconnect_all(_place(cls, self, attribute_spec))

    @either
    def get(cls: Any, self: Any, attribute: Any = None, *_: Any, **named: Any) -> Any:
        """What an attribute was set to."""
        spec = attribute if attribute is not None else named.get("attribute_id", self and self.attribute_id)
        if isinstance(spec, OgVariable):
            return spec.get()
        if is_hidden(cls.recorder, spec):
            return _leave_attribute(cls.recorder, spec)
        return OgAttribute(cls.recorder, _place(cls, self, spec, named.get("node"), named.get("graph"))).get()

    @either
    def set(cls: Any, self: Any, *arguments: Any, **named: Any) -> None:
        """Set an attribute: of the instance, or the first argument."""
        given = list(arguments)
        spec = named.get("attribute", named.get("attribute_id", self and self.attribute_id))
        spec = given.pop(0) if spec is None and given else spec
        if "value" in named:
            given = [named["value"]]
        if spec is None or not given:
            raise OmniGraphError("set: which attribute, and to which value?")
        if is_hidden(cls.recorder, spec):
            _leave_attribute(cls.recorder, spec)
        elif isinstance(spec, OgVariable):
            spec.set(None, given[-1])
        else:
            place = _place(cls, self, spec, named.get("node"), named.get("graph"))
            cls.recorder.set_value(place, given[0], named.get("type", ""))

    @either
    def evaluate(cls: Any, self: Any, *_: Any, **__: Any) -> Task:
        """Nothing: what a graph does is no part of it."""
        draw(cls.recorder)
        return Task(None, cls.recorder)

    @either
    def evaluate_sync(cls: Any, self: Any, *_: Any, **__: Any) -> None:
        """Nothing: what a graph does is no part of it."""
        draw(cls.recorder)


def _leave_attribute(recorder: GraphRecorder, spec: Any) -> StubObject:
    """Tell of an attribute of a graph that Omniverse makes itself, as its renderer does; once, where it is told already."""
    if str(spec) not in map(unknown, (ELSEWHERE, OWN)):
        recorder.leave_out(f"what is set at {str(spec)[:200]}: only Omniverse knows that node")
    return StubObject(OWN, recorder)


def _known(controller: Any) -> Mapping[str, Any]:
    return controller.known if controller is not None else {}


def _place(cls: Any, controller: Any, spec: Any, node_id: Any = None, graph_id: Any = None) -> Place:
    return place_at(cls.recorder, spec, node_id, graph_id, _known(controller))


_CONTROLLERS = ("Controller", "GraphController", "NodeController", "ObjectLookup", "DataView", "AttributeValueHelper")
_HANDLES = (OgGraph, OgNode, OgAttribute, GraphPipelineStage, ExecutionAttributeState)
_TYPES = (Type, BaseDataType, AttributeRole, AttributePortType, AttributeType)


def members(recorder: GraphRecorder) -> dict[str, Any]:
    """What `omni.graph.core` holds for a recorder."""
    controller = Open("Controller", (Controller,), {"recorder": recorder})
    return {
        **dict.fromkeys(_CONTROLLERS, controller),
        **{kind.__name__.removeprefix("Og"): kind for kind in (*_HANDLES, *_TYPES, OmniGraphError)},
        "get_registered_nodes": lambda: sorted(recorder.types),
        "get_node_type": NodeType,
        "get_graph_by_path": lambda path: graph_at(recorder, path),
        "get_all_graphs": lambda: [OgGraph(recorder, graph) for graph in recorder.graphs.values()],
        "get_node_by_path": lambda path: node_at(recorder, str(path), None, {}),
    }
