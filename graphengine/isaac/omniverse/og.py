"""Stub of `omni.graph.core`: its controllers record the graph edits of a script."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from inspect import isfunction
from typing import Any

from graphengine.format.wording import shown
from graphengine.isaac.omniverse.asyncio_stub import Task
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder, Place
from graphengine.isaac.omniverse.og_edit import OPENED, Edit, Keys, name_lost
from graphengine.isaac.omniverse.og_handles import HANDLES, OgAttribute, OgGraph, OgNode, OgVariable
from graphengine.isaac.omniverse.og_lookup import edited_graph, graph_above, graph_at, is_hidden, node_at, place_at
from graphengine.isaac.omniverse.og_names import NotThereError, OmniGraphError
from graphengine.isaac.omniverse.og_types import TYPES, NodeType
from graphengine.isaac.omniverse.plain_data import unknown
from graphengine.isaac.omniverse.stubs import ELSEWHERE, OWN, StubObject, member


class _Either:
    """A method of a controller that can be called on the class and on instances, like all public methods of `Controller`."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def __get__(self, instance: Controller | None, owner: type[Controller]) -> Callable[..., Any]:
        if instance is None:
            instance = object.__new__(owner)
            Controller.__init__(instance)  # a script's subclass may require arguments
        return functools.partial(self.call, instance)

    def call(self, controller: Controller, /, *arguments: Any, **named: Any) -> Any:
        """Call the method. If it raises NotThereError and objects are assumed to exist, warn and return a stub instead."""
        try:
            return self.function(controller, *arguments, **named)
        except NotThereError as error:
            if not controller.recorder.assumed:
                raise
            controller.recorder.leave_out(str(error), "", OPENED)
            return StubObject(ELSEWHERE, controller.recorder)


class Open(type):
    """Metaclass of `Controller` that returns a stub for each class attribute that the controller lacks."""

    recorder: GraphRecorder

    def __getattr__(cls, name: str) -> Any:
        return member("omni.graph.core.Controller", name, cls.recorder)


class Controller(metaclass=Open):
    """Stub of `og.Controller`. `members` derives a class for each recorder; an instance keeps the nodes that it created."""

    Keys = Keys
    recorder: GraphRecorder

    def __init__(self, attribute: Any = None, **named: Any) -> None:
        self.attribute_id = attribute if attribute is not None else named.get("attribute")
        self.known: dict[str, Any] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(type(self), name)

    def edit(
        self,
        graph_id: Any = None,
        edit_commands: Mapping[Any, Any] | None = None,
        *,
        path_to_object_map: dict[str, Any] | None = None,
        allow_exists_node: bool = False,
        **_: Any,
    ) -> tuple[Any, Any, Any, dict[str, Any]]:
        """Execute edit commands on a graph. `edited_graph` finds or creates the graph for `graph_id`.

        The edit of a graph that only Omniverse knows is left out, with a warning.

        Returns:
            The graph, the created nodes, the created prims, and a dict from names to objects.
        """
        recorder = self.recorder
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
        names = path_to_object_map if path_to_object_map is not None else self.known
        edit = Edit(recorder, graph, names, allow_exists_node)
        edit.run(commands, "")
        return OgGraph(recorder, graph), edit.made, edit.prims, names

    def create_graph(self, graph_id: Any, *_: Any, **__: Any) -> OgGraph:
        """Return the graph for a handle or path, or a new graph for a mapping with `graph_path` or for an unused path."""
        return OgGraph(self.recorder, edited_graph(self.recorder, graph_id))

    def graph(self, graph_id: Any) -> OgGraph | None:
        """Return the graph at a path; None if the path has no graph."""
        return graph_at(self.recorder, graph_id)

    def node(self, node_id: Any = None, graph_id: Any = None, **named: Any) -> OgNode:
        """Return the node for a path, a name and a graph, or a tuple `(name, graph)`."""
        return node_at(self.recorder, node_id if node_id is not None else named.get("path"), graph_id, self.known)

    def attribute(self, attribute_id: Any, node_id: Any = None, graph_id: Any = None) -> Any:
        """Return the attribute for a path, a name and a node, or a tuple `(name, node)`; a stub for an unknown node."""
        if is_hidden(self.recorder, attribute_id):
            return self._leave_attribute(attribute_id)
        return OgAttribute(self.recorder, self._place(attribute_id, node_id, graph_id))

    def variable(self, variable_id: Any, graph_id: Any = None) -> OgVariable:
        """Return the variable for a name and a graph, or a tuple `(name, graph)`; a variable handle is returned unchanged."""
        if isinstance(variable_id, OgVariable):
            return variable_id
        name, graph = variable_id if isinstance(variable_id, tuple) else (variable_id, graph_id)
        found = graph_at(self.recorder, graph)
        if found is None or name not in found.graph.variables:
            raise OmniGraphError(f"no variable {shown(name)} in {shown(graph)}")
        return OgVariable(self.recorder, found.graph, name)

    def create_node(self, node_id: Any, node_type_id: Any, allow_exists: bool = False, **_: Any) -> OgNode:
        """Create a node and return its handle; `node_id` is a prim path or a tuple `(name, graph)`."""
        recorder = self.recorder
        name, graph_id = node_id if isinstance(node_id, tuple) else (node_id, None)
        inside = edited_graph(recorder, graph_id) if graph_id is not None else graph_above(recorder, str(name))
        return OgNode(recorder, inside, recorder.create_node(inside, str(name), node_type_id, exist_ok=allow_exists))

    def delete_node(self, node_id: Any, *_: Any, **__: Any) -> None:
        """Remove a node and its wires."""
        node = node_at(self.recorder, node_id, None, self.known)
        self.recorder.delete_node(node.graph, node.name)

    def create_variable(self, graph_id: Any, name: str, type: Any, *_: Any, **__: Any) -> OgVariable:
        """Add a variable to a graph and return its handle."""
        return OgGraph(self.recorder, edited_graph(self.recorder, graph_id)).create_variable(name, type)

    def set_variable_default_value(self, variable_id: Any, value: Any) -> None:
        """Set the default value of a variable."""
        self.variable(variable_id).set(None, value)

    def get_variable_default_value(self, variable_id: Any) -> Any:
        """Return the default value of a variable."""
        return self.variable(variable_id).get()

    def node_type(self, type_id: Any) -> NodeType:
        """Return the node type for a name or a node; raise OmniGraphError if the type is not available."""
        name = type_id.get_type_name() if isinstance(type_id, OgNode) else str(type_id)
        if name not in self.recorder.types and not self.recorder.assumed:
            raise OmniGraphError(f"there is no node type {name!r}")
        return NodeType(name)

    def create_attribute(
        self,
        node_id: Any,
        attr_name: str,
        attr_type: Any,
        attr_port: Any = None,
        attr_default: Any = None,
        *_: Any,
        **__: Any,
    ) -> OgAttribute:
        """Add an attribute to a node, set its default value, and return its handle."""
        node = node_at(self.recorder, node_id, None, self.known)
        place = self.recorder.create_attribute(Place(node.graph, node.name, attr_name), attr_type, attr_port)
        if attr_default is not None:
            self.recorder.set_value(place, attr_default)
        return OgAttribute(self.recorder, place)

    def connect(self, src_spec: Any, dst_spec: Any, *_: Any, **__: Any) -> None:
        """Add a wire from one attribute to another."""
        self.recorder.connect(self._place(src_spec), self._place(dst_spec))

    def disconnect(self, src_spec: Any, dst_spec: Any, *_: Any, **__: Any) -> None:
        """Remove the wire from one attribute to another."""
        self.recorder.disconnect(self._place(src_spec), self._place(dst_spec))

    def disconnect_all(self, attribute_spec: Any, *_: Any, **__: Any) -> None:
        """Remove all wires of an attribute."""
        self.recorder.disconnect_all(self._place(attribute_spec))

    def get(self, attribute: Any = None, *_: Any, **named: Any) -> Any:
        """Return the value that the script set for an attribute or variable; a stub if only Omniverse knows the value."""
        spec = attribute if attribute is not None else named.get("attribute_id", self.attribute_id)
        if isinstance(spec, OgVariable):
            return spec.get()
        if is_hidden(self.recorder, spec):
            return self._leave_attribute(spec)
        return OgAttribute(self.recorder, self._place(spec, named.get("node"), named.get("graph"))).get()

    def set(self, *arguments: Any, **named: Any) -> None:
        """Set the value of the attribute or variable given by keyword, by the constructor, or by the first argument."""
        given = list(arguments)
        spec = named.get("attribute", named.get("attribute_id", self.attribute_id))
        spec = given.pop(0) if spec is None and given else spec
        if "value" in named:
            given = [named["value"]]
        if spec is None or not given:
            raise OmniGraphError("set() needs an attribute and a value")
        if is_hidden(self.recorder, spec):
            self._leave_attribute(spec)
        elif isinstance(spec, OgVariable):
            spec.set(None, given[-1])
        else:
            place = self._place(spec, named.get("node"), named.get("graph"))
            self.recorder.set_value(place, given[0], named.get("type", ""))

    def evaluate(self, *_: Any, **__: Any) -> Task:
        """Count a rendered frame and return a finished task; the graph is not executed."""
        self.recorder.draw()
        return Task(None, self.recorder)

    def evaluate_sync(self, *_: Any, **__: Any) -> None:
        """Count a rendered frame; the graph is not executed."""
        self.recorder.draw()

    def _leave_attribute(self, spec: Any) -> StubObject:
        """Warn that access to an attribute is left out, because only Omniverse knows its node; return a stub."""
        if str(spec) not in map(unknown, (ELSEWHERE, OWN)):
            self.recorder.leave_out(
                f"the access to the attribute {str(spec)[:200]} is left out: only Omniverse knows its node"
            )
        return StubObject(OWN, self.recorder)

    def _place(self, spec: Any, node_id: Any = None, graph_id: Any = None) -> Place:
        return place_at(self.recorder, spec, node_id, graph_id, self.known)


for _name, _function in [*vars(Controller).items()]:
    if isfunction(_function) and not _name.startswith("_"):
        setattr(Controller, _name, _Either(_function))
_CONTROLLERS = ("Controller", "GraphController", "NodeController", "ObjectLookup", "DataView", "AttributeValueHelper")


def members(recorder: GraphRecorder) -> dict[str, Any]:
    """Return the members of the stub of `omni.graph.core` by name; they record graph edits in `recorder`."""
    controller = Open("Controller", (Controller,), {"recorder": recorder})
    return {
        **dict.fromkeys(_CONTROLLERS, controller),
        **{kind.__name__.removeprefix("Og"): kind for kind in (*HANDLES, *TYPES, OmniGraphError)},
        "get_registered_nodes": lambda: sorted(recorder.types),
        "get_node_type": NodeType,
        "get_graph_by_path": lambda path: graph_at(recorder, path),
        "get_all_graphs": lambda: [OgGraph(recorder, graph) for graph in recorder.graphs.values()],
        "get_node_by_path": lambda path: node_at(recorder, str(path), None, {}),
    }
