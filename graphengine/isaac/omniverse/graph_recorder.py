"""Records the graphs that a script builds, with the documented behaviour of `og.Controller.edit` but without type checks."""

from __future__ import annotations

import posixpath
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

from graphengine.format.wording import did_you_mean, listing
from graphengine.isaac.omniverse.frames import Stack, Where
from graphengine.isaac.omniverse.og_names import (
    SIDES,
    NotThereError,
    OmniGraphError,
    absolute,
    checked,
    full_name,
    split_attribute,
    type_name,
)
from graphengine.isaac.omniverse.plain_data import is_unknown, plain_data
from graphengine.isaac.omniverse.script_notes import ScriptNotes
from graphengine.isaac.recorded_graph import (
    EVALUATORS,
    POSITION,
    PipelineStage,
    RecordedGraph,
    RecordedNode,
    RecordedValue,
    RecordedWire,
)

MAX_PARTS = 100_000
"""Maximum number of nodes, wires and values that one script may create."""


@dataclass(frozen=True, slots=True)
class Place:
    """Reference to an attribute: its graph, the name of its node, and its full name, such as `inputs:x`."""

    graph: RecordedGraph
    node: str
    name: str

    @property
    def path(self) -> str:
        """Path of the attribute in USD."""
        return f"{self.graph.path}/{self.node}.{self.name}"


Compounds = dict[str, dict[str, tuple[str, str]]]
"""The promoted attributes of each compound, by compound name; each maps to (inner node, inner attribute)."""


class GraphRecorder(ScriptNotes):
    """Recorder of the graphs that a script builds; the stubs of Omniverse's modules call its methods.

    Args:
        where: returns the span of the script's current call.
        types: names of the available node types.
        assumed: whether prims, graphs and types that the script uses but did not create are assumed to exist.
        absent: paths of prims that do not exist until the script creates them, even if `assumed` is true.
        stack: returns the script's current call and the loops around it.
    """

    def __init__(
        self,
        where: Where,
        types: Collection[str] = (),
        *,
        assumed: bool = False,
        absent: Collection[str] = (),
        stack: Stack = lambda: (("", 0, 0), ()),
    ) -> None:
        super().__init__(where, stack, assumed=assumed)
        self.types, self.absent = types, absent
        self.graphs: dict[str, RecordedGraph] = {}
        self.removed: dict[str, RecordedGraph] = {}
        """Graphs that the script removed after it had simulated with them, by prim path; they are imported too."""
        self.compounds: dict[str, Compounds] = {}
        self.shared: dict[tuple[str, str, str], dict[tuple[str, str], None]] = {}
        """Further inner attributes of promoted inputs, by graph and first inner attribute; wires and values go to all of them."""
        self.parts = 0
        self.stages: dict[str, list[RecordedGraph]] = {}
        """Graphs of the USD files that could be read, by the path that the script passes when it opens the file."""
        self.opened_stages: list[str] = []
        self.granted: set[str] = set()
        """Paths of the prims that were assumed to exist when the script queried them."""
        self.namespaces: dict[str, str] = {}
        """Values of `isaac:namespace` by prim path."""
        self.opened: set[str] = set()
        """Paths of graphs that the script edits without creating nodes, so that they are assumed to exist elsewhere."""
        self.put: dict[str, str] = {}
        """Substitute prim path for each graph whose path only Omniverse knows, by the unknown path as in the script."""

    def count(self) -> None:
        """Count one more part of a graph, and report the iterations on which this part may depend.

        Raises:
            OmniGraphError: the script creates more than `MAX_PARTS` parts.
        """
        self.report_searches()
        self.parts += 1
        if self.parts > MAX_PARTS:
            raise OmniGraphError(f"the script creates more than {MAX_PARTS} nodes, wires and values")

    # Graphs

    def create_graph(self, path: str, evaluator: str = "push", stage: PipelineStage = "simulation") -> RecordedGraph:
        """Record and return a new graph; raise OmniGraphError if the path is in use or the evaluator is unknown."""
        path = self._put(path) if is_unknown(path) else absolute(path)
        if path in self.graphs:
            raise OmniGraphError(f"there is a graph at {path!r} already")
        if evaluator not in EVALUATORS:
            raise OmniGraphError(f"no evaluator {evaluator!r}; {listing(EVALUATORS)}")
        self.count()
        graph = RecordedGraph(path, evaluator, stage, span=self.where(path))
        self.graphs[path] = graph
        self.compounds[path] = {}
        self.frames.build((path, ""))
        return graph

    def _put(self, path: str) -> str:
        """Choose, report and return a prim path for a graph whose path only Omniverse knows; keep the known end of the path."""
        known = path.rpartition(">")[2].strip("/") or "ActionGraph"
        choices = (f"/World/{known}", *(f"/World/{known}_{number}" for number in range(2, len(self.graphs) + 3)))
        self.put[path.rstrip("/")] = place = next(choice for choice in choices if choice not in self.graphs)
        what = f"the prim path {path} of a graph is unknown; the graph is put at {place}"
        self.leave_out(what, path, "write the actual path after `at:` in the graph file")
        return place

    def meant(self, path: str) -> str:
        """Return a path from the script; an unknown graph path at its beginning is replaced by the substitute from `put`."""
        for unknown, place in self.put.items():
            if path == unknown or path.startswith((f"{unknown}/", f"{unknown}.")):
                return place + path[len(unknown) :]
        return path

    def graph_at(self, path: str) -> RecordedGraph | None:
        """Return the graph at a prim path; None if the path has no graph."""
        return self.graphs.get(self.meant(path.rstrip("/")))

    def graph_of(self, path: str) -> tuple[RecordedGraph, str] | None:
        """Return the graph at or above a prim path, and the rest of the path below this graph; None if there is no graph."""
        above = path = self.meant(path)
        while above:
            if above in self.graphs:
                return self.graphs[above], path[len(above) + 1 :]
            above = above.rpartition("/")[0]
        return None

    def open_stage(self, path: str) -> None:
        """Add the graphs of a USD file that the script opens; if the file was not read, note its path in `opened_stages`."""
        if path not in self.stages:
            self.opened_stages.append(path)
            self.pass_over(f"opening {path!r}")
        for graph in self.stages.get(path, ()):
            self.graphs[graph.path], self.compounds[graph.path] = graph, {}

    def exists(self, path: str) -> bool:
        """Return whether a prim exists, because the script created it or because it is assumed to exist."""
        path = path.rstrip("/")
        found = self.graph_of(path)
        if path in self.prims or found:
            return path in self.prims or (found is not None and found[1] in ("", *found[0].nodes))
        if not self.assumed or path in self.absent:
            return self.holds(path, "the prim exists")
        self.granted.add(path)
        return True

    def remove(self, path: str) -> None:
        """Remove the graph or node at a prim path, and all graphs below the path."""
        for known in [known for known in self.graphs if known == path or known.startswith(f"{path}/")]:
            graph = self.graphs.pop(known)
            if self.frames.pass_by((known, "")):
                self.removed[known] = graph
        found = self.graph_of(path)
        if found and found[1] in found[0].nodes:
            self.delete_node(*found)

    # Nodes

    def create_node(self, graph: RecordedGraph, name: str, type: str, *, exist_ok: bool = False) -> str:
        """Record a node and return its name relative to the graph."""
        name = self.name_below(graph, name)
        if self.has_node(graph, name):
            if exist_ok:
                return name
            raise OmniGraphError(f"there is a node {name!r} in {graph.path} already")
        known = checked(type, f"the type of {name}") if type else ""
        self.count()
        graph.nodes[name] = RecordedNode(name, known, span=self.where(name.rpartition("/")[2]))
        self.frames.build((graph.path, name))
        return name

    def create_compound(self, graph: RecordedGraph, name: str) -> str:
        """Record a compound and return its name relative to the graph. Its inner nodes are recorded as `Compound/Node`."""
        name = self.name_below(graph, name)
        self.count()
        self.compounds[graph.path].setdefault(name, {})
        return name

    def name_below(self, graph: RecordedGraph, path: str) -> str:
        """Return the name of a node relative to its graph; `path` is this name or the absolute path of the node."""
        path = self.meant(checked(path, "the name of a node"))
        if not path.startswith("/"):
            return posixpath.normpath(path)
        if not path.startswith(f"{graph.path}/"):
            raise OmniGraphError(f"{path!r} lies outside of the graph {graph.path!r}")
        return path[len(graph.path) + 1 :]

    def find_node(self, graph: RecordedGraph | None, path: str) -> tuple[RecordedGraph, str]:
        """Return the graph and the name of a node or compound, given its name in `graph` or its absolute path."""
        path = self.meant(path)
        found = self.graph_of(path) if path.startswith("/") else graph and (graph, path)
        if not found:
            raise NotThereError(f"no graph contains the node {path!r}")
        inside, name = found
        if not self.has_node(inside, name):
            near = did_you_mean(name, inside.nodes) or listing(inside.nodes, "nodes")
            error = NotThereError if inside.path in self.opened or self.opened_stages else OmniGraphError
            raise error(f"no node {name!r} in {inside.path}; {near}")
        return inside, name

    def has_node(self, graph: RecordedGraph, name: str) -> bool:
        """Return whether a graph has a node or a compound with this name."""
        return name in graph.nodes or name in self.compounds.get(graph.path, {})

    def delete_node(self, graph: RecordedGraph, name: str) -> None:
        """Remove a node, or a compound with its inner nodes, and all wires of the removed nodes."""
        gone = {known for known in graph.nodes if known == name or known.startswith(f"{name}/")}
        for known in gone:
            del graph.nodes[known]
        self.compounds[graph.path].pop(name, None)
        graph.wires = [wire for wire in graph.wires if wire.source not in gone and wire.target not in gone]

    # Attributes

    def attribute(self, graph: RecordedGraph | None, path: str) -> Place:
        """Return the attribute at a path such as `Node.inputs:x`; for a promoted attribute, return the inner attribute."""
        node, name = split_attribute(self.meant(checked(path, "an attribute such as 'Node.inputs:x'")))
        inside, found = self.find_node(graph, node)
        return self.inner(Place(inside, found, name))

    def inner(self, place: Place) -> Place:
        """Return the inner attribute of a promoted attribute; all other attributes are returned unchanged."""
        compounds = self.compounds.get(place.graph.path, {})
        node, name = place.node, full_name(place.name)
        while node in compounds:
            known = compounds[node]
            if name not in known:
                near = did_you_mean(name, known) or listing(known, "promoted attributes")
                raise OmniGraphError(f"compound {node!r} has no attribute {name!r}; {near}")
            node, name = known[name]
        return Place(place.graph, node, name)

    def promote(self, place: Place, compound: str, name: str) -> None:
        """Make an attribute of an inner node available as the attribute `name` of the compound; several may share a name."""
        side = place.name.partition(":")[0]
        full = name if name.startswith(SIDES) else f"{side}:{name}"
        first = self.compounds[place.graph.path][compound].setdefault(full, (place.node, place.name))
        if first != (place.node, place.name):
            self.shared.setdefault((place.graph.path, *first), {})[place.node, place.name] = None

    def _fan_out(self, place: Place) -> list[Place]:
        """Return an attribute, and the attributes that a compound promotes under the same name."""
        ends = [(place.node, place.name)]
        for node, name in ends:
            ends += [end for end in self.shared.get((place.graph.path, node, name), ()) if end not in ends]
        return [Place(place.graph, *end) for end in ends]

    def create_attribute(self, place: Place, type: Any, port_type: Any = None) -> Place:
        """Add an attribute to a node and return it; a missing prefix such as `inputs:` follows from the type or port type."""
        said = str((type[1:] if isinstance(type, tuple) else (), port_type))
        side = "outputs" if "OUTPUT" in said else "state" if "STATE" in said else "inputs"
        name = place.name if place.name.startswith(SIDES) else f"{side}:{place.name}"
        self.count()
        with self.leaving_out_unknown(f"the type of {place.node}.{name}", place.name):
            self.node(place).attributes[name] = type_name(type)
        return Place(place.graph, place.node, name)

    def node(self, place: Place) -> RecordedNode:
        """Return the node to which an attribute belongs.

        Raises:
            OmniGraphError: the node was deleted.
        """
        try:
            return place.graph.nodes[place.node]
        except KeyError:
            raise OmniGraphError(f"there is no node {place.node!r} in {place.graph.path} any more") from None

    def set_value(self, place: Place, value: Any, type: Any = "") -> None:
        """Record the value of an attribute. A value that only Omniverse knows, or that is set between frames, is left out."""
        for inner in self._fan_out(place):
            self._set_value(inner, value, type)

    def _set_value(self, place: Place, value: Any, type: Any) -> None:
        hint = f"{place.node.rpartition('/')[2]}.{place.name}"
        node = self.node(place)
        if self.frames.drive((place.graph.path, place.node), node.values, place.name, hint):
            return
        with self.leaving_out_unknown(f"the value of {place.node}.{place.name}", hint, "set it in the file"):
            data = plain_data(value)
            self.count()
            if place.name == POSITION:
                if isinstance(data, list) and len(data) == 2 and all(isinstance(part, int | float) for part in data):
                    node.position = float(data[0]), float(data[1])
                return
            known = "" if type is None or type == "" or is_unknown(type) else type_name(type)
            node.values[place.name] = RecordedValue(data, known, self.where(hint))

    def value(self, place: Place) -> Any:
        """Return the value that the script set for an attribute; None if the script has not set it."""
        if place.name.startswith("outputs:"):
            self.pass_over(f"the use of the output {place.path}")
        known = place.graph.nodes.get(place.node)
        found = known.values.get(place.name) if known else None
        return found.data if found else None

    # Wires

    def connect(self, source: Place, target: Place) -> None:
        """Add a wire between two attributes; a wire between different graphs is left out with a warning."""
        if source.graph is not target.graph:
            self.leave_out(f"the wire {source.path} -> {target.path} connects different graphs", source.name)
            return
        name = f"{source.node.rpartition('/')[2]}.{source.name}"
        for end in self._fan_out(target):
            self.count()
            self.node(source), self.node(end)
            source.graph.wires.append(RecordedWire(source.node, source.name, end.node, end.name, self.where(name)))

    def disconnect(self, source: Place, target: Place) -> None:
        """Remove the wire between two attributes, if there is one."""
        wires = {RecordedWire(source.node, source.name, end.node, end.name) for end in self._fan_out(target)}
        source.graph.wires = [known for known in source.graph.wires if known not in wires]

    def disconnect_all(self, place: Place) -> None:
        """Remove all wires of an attribute."""
        place.graph.wires = [wire for wire in place.graph.wires if (place.node, place.name) not in wire.ends]

    def upstream(self, place: Place) -> list[Place]:
        """Return the sources of the wires into an attribute."""
        ends = (wire.ends for wire in place.graph.wires)
        return [Place(place.graph, *source) for source, target in ends if target == (place.node, place.name)]

    def downstream(self, place: Place) -> list[Place]:
        """Return the targets of the wires from an attribute."""
        ends = (wire.ends for wire in place.graph.wires)
        return [Place(place.graph, *target) for source, target in ends if source == (place.node, place.name)]

    # Variables

    def create_variable(self, graph: RecordedGraph, name: str, type: Any, default: Any = None) -> None:
        """Add a variable to a graph; raise OmniGraphError if the graph already has a variable of this name."""
        name = checked(name, "the name of a variable")
        if name in graph.variables:
            raise OmniGraphError(f"there is a variable {name!r} in {graph.path} already")
        self.count()
        with self.leaving_out_unknown(f"the type of variable {name!r}", name):
            graph.variables[name] = RecordedValue(None, type_name(type), self.where(name))
            self.frames.build((graph.path, name))
            if default is not None:
                self.set_variable(graph, name, default)

    def set_variable(self, graph: RecordedGraph, name: str, value: Any) -> None:
        """Set the default value of a variable; raise OmniGraphError if the graph has no such variable."""
        if name not in graph.variables:
            raise OmniGraphError(f"no variable {name!r} in {graph.path}; {listing(graph.variables, 'variables')}")
        known = graph.variables[name]
        if self.frames.drive((graph.path, name), graph.variables, name, name):
            return
        with self.leaving_out_unknown(f"the default of variable {name!r}", name):
            graph.variables[name] = RecordedValue(plain_data(value), known.type, known.span)
