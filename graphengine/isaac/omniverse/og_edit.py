"""Executes the command dictionary of one `og.Controller.edit` call in the order that OmniGraph documents."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import islice
from typing import Any

from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder, Place
from graphengine.isaac.omniverse.og_handles import OgGraph, OgNode
from graphengine.isaac.omniverse.og_lookup import place_at
from graphengine.isaac.omniverse.og_names import MAX_NAME, NotThereError, OmniGraphError, items, split_attribute
from graphengine.isaac.omniverse.usd import UsdPrim
from graphengine.isaac.recorded_graph import VARIABLE, RecordedGraph

MAX_LOST = 1000
"""Maximum number of commands that the error of a failed edit lists as not executed."""
OPENED = "a USD file that the script opens may contain it; import that file too"


class Keys:
    """Stub of `og.Controller.Keys`: the keys of the command dictionary of an edit."""

    DELETE_NODES = "delete_nodes"
    CREATE_VARIABLES = "create_variables"
    CREATE_NODES = "create_nodes"
    CREATE_PRIMS = "create_prims"
    EXPOSE_PRIMS = "expose_prims"
    CREATE_ATTRIBUTES = "create_attributes"
    CONNECT = "connect"
    DISCONNECT = "disconnect"
    DISCONNECT_ALL = "disconnect_all"
    PROMOTE_ATTRIBUTES = "promote_attributes"
    SET_VALUES = "set_values"


ORDER = tuple(value for name, value in vars(Keys).items() if name.isupper())
"""The keys of edit commands in OmniGraph's order of execution, which does not depend on their order in the script."""


def steps(commands: Any) -> Iterator[tuple[str, Any]]:
    """Return the commands of an edit as pairs (key, item), in OmniGraph's order of execution."""
    if not isinstance(commands, Mapping):
        raise OmniGraphError(f"expected a dictionary of edit commands, got {shown(commands)}")
    return ((key, item) for key in ORDER if key in commands for item in items(commands[key]))


def name_lost(error: OmniGraphError, commands: Any, done: int) -> None:
    """Add a note to an error that lists the commands that were not executed: those after the first `done` commands."""
    lost = islice(steps(commands), done, done + MAX_LOST + 1)
    names = [f"{key} {str(item[0] if isinstance(item, tuple) else item)[:MAX_NAME]}" for key, item in lost]
    error.add_note(", ".join(names[:MAX_LOST]) + " …" * (len(names) > MAX_LOST))


class Edit:
    """Executes the commands of one call of `og.Controller.edit` and of the compounds in it."""

    def __init__(self, recorder: GraphRecorder, graph: RecordedGraph, names: dict[str, Any], exist_ok: bool) -> None:
        self.recorder, self.graph, self.names, self.exist_ok = recorder, graph, names, exist_ok
        self.made: list[Any] = []
        self.prims: list[Any] = []

    def run(self, commands: Mapping[Any, Any], compound: str) -> None:
        """Execute the commands in OmniGraph's order. `compound` names the compound to edit; if empty, the graph is edited."""
        done, pending = 0, steps(commands)
        try:
            for key in commands:
                if key not in ORDER:
                    raise OmniGraphError(f"unknown key {shown(key)}; {did_you_mean(str(key), ORDER) or listing(ORDER)}")
            for key, item in pending:
                self._one(key, item, compound)
                done += 1
        except OmniGraphError as error:
            name_lost(error, commands, done)
            raise

    def _one(self, key: str, item: Any, compound: str) -> None:
        try:
            getattr(self, f"_{key}")(item, compound)
        except NotThereError as error:
            if not self.recorder.assumed:
                raise
            hint = next((part for part in item if isinstance(part, str)), "") if isinstance(item, tuple) else str(item)
            self.recorder.leave_out(f"{key}: {error}", hint, OPENED)
        except (TypeError, ValueError, AttributeError) as error:
            raise OmniGraphError(f"{key}: {shown(item)} has the wrong form: {error}") from None

    def _place(self, spec: Any, compound: str) -> Place:
        if isinstance(spec, str) and not spec.startswith("/"):
            node, name = split_attribute(spec)
            found = self.names.get(node)
            if isinstance(found, OgNode) and not self.recorder.has_node(self.graph, self._node_name(node, compound)):
                return found.get_attribute(name).place
            if compound:
                return self.recorder.attribute(self.graph, f"{compound}/{spec}")
        return place_at(self.recorder, spec, None, OgGraph(self.recorder, self.graph), {})

    def _node_name(self, name: Any, compound: str) -> str:
        return f"{compound}/{name}" if compound and not str(name).startswith("/") else str(name)

    def _delete_nodes(self, item: Any, compound: str) -> None:
        if isinstance(item, OgNode):
            self.recorder.delete_node(item.graph, item.name)
        else:
            self.recorder.delete_node(*self.recorder.find_node(self.graph, self._node_name(item, compound)))

    def _create_variables(self, item: Any, compound: str) -> None:
        if compound:
            self.recorder.leave_out(
                f"variables of the compound {compound!r} become variables of its graph", str(item[0])
            )
        self.recorder.create_variable(self.graph, *item)

    def _create_nodes(self, item: Any, compound: str) -> None:
        name, kind = item
        if not isinstance(name, str):
            raise OmniGraphError(f"expected the name of a node, got {shown(name)}")
        if isinstance(kind, Mapping):
            inner = self.recorder.create_compound(self.graph, self._node_name(name, compound))
            self._keep(name, inner)
            self.run(kind, inner)
            return
        full = self._node_name(name, compound)
        self._keep(name, self.recorder.create_node(self.graph, full, str(kind), exist_ok=self.exist_ok))

    def _keep(self, given: str, name: str) -> None:
        node = OgNode(self.recorder, self.graph, name)
        self.made.append(node)
        self.names[given] = self.names[node.get_prim_path()] = node

    def _create_prims(self, item: Any, compound: str) -> None:
        path = item[0] if isinstance(item, tuple) else item
        full = str(path) if str(path).startswith("/") else f"{self.graph.path}/{path}"
        self.recorder.leave_out(f"the prim {full!r} is not created", str(path), "a graph file cannot create prims")
        self.recorder.prims.add(full)
        self.prims.append(UsdPrim(full, self.recorder))
        self.names[str(path)] = self.prims[-1]

    def _expose_prims(self, item: Any, compound: str) -> None:
        self.recorder.leave_out(f"the prim {shown(item[1])} is not exposed as a node", str(item[2]))

    def _create_attributes(self, item: Any, compound: str) -> None:
        spec, kind = item
        self.recorder.create_attribute(self._place(spec, compound), kind)

    def _connect(self, item: Any, compound: str) -> None:
        source, target = item
        ends: list[Place] = []
        for spec in (source, target):
            if isinstance(spec, str) and spec.startswith("/") and not self.recorder.graph_of(spec.partition(".")[0]):
                self.recorder.leave_out(f"the wire {source} -> {target} is left out: {spec} belongs to no graph", spec)
                return
            ends.append(self._place(spec, compound))
        self.recorder.connect(*ends)

    def _disconnect(self, item: Any, compound: str) -> None:
        source, target = item
        self.recorder.disconnect(self._place(source, compound), self._place(target, compound))

    def _disconnect_all(self, item: Any, compound: str) -> None:
        spec = item[0] if isinstance(item, tuple) and len(item) == 1 else item
        self.recorder.disconnect_all(self._place(spec, compound))

    def _promote_attributes(self, item: Any, compound: str) -> None:
        if not compound:
            raise OmniGraphError("promote_attributes: only a compound has promoted attributes")
        spec, name = item
        self.recorder.promote(self._place(spec, compound), compound, name)

    def _set_values(self, item: Any, compound: str) -> None:
        spec, value, *kind = item
        name = spec if isinstance(spec, str) else ""
        if VARIABLE in name:
            self.recorder.set_variable(self.graph, name.rpartition(VARIABLE)[2], value)
        else:
            self.recorder.set_value(self._place(spec, compound), value, kind[0] if kind else "")
