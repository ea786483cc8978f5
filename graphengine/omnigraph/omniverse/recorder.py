"""What graph-building calls do to graphs, as `og.Controller.edit` documents them; without OmniGraph, without checks of types."""

from __future__ import annotations

import posixpath
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

from graphengine.diagnostics import Findings, Span, did_you_mean, listing
from graphengine.omnigraph.omniverse.plain_data import UnknownError, is_unknown, plain_data
from graphengine.omnigraph.omniverse.spellings import (
    SIDES,
    NotThereError,
    OmniGraphError,
    absolute,
    checked,
    full_name,
    split_attribute,
    type_name,
)
from graphengine.omnigraph.recorded import (
    EVALUATORS,
    POSITION,
    PipelineStage,
    RecordedGraph,
    RecordedNode,
    RecordedValue,
    RecordedWire,
)

MAX_PARTS = 200_000
"""Nodes, wires and values that one script may make; our own limit of nodes in a graph is a tenth of it."""


MAX_REFUSED = 100


@dataclass(frozen=True, slots=True)
class Place:
    """An attribute: of a node of a graph, by its full name."""

    graph: RecordedGraph
    node: str
    name: str

    @property
    def path(self) -> str:
        """As USD writes it."""
        return f"{self.graph.path}/{self.node}.{self.name}"


Compounds = dict[str, dict[str, tuple[str, str]]]
"""Compounds of a graph by name, and what each of their promoted attributes stands for: inner node and attribute."""


class Recorder:
    """The graphs that a script built so far.

    Args:
        where: place in the script of the call that is made; of a text in that call where one is given.
        types: names of the node types that there are.
        assumed: whether prims, graphs and types that a script asks for, and did not make, are taken to be there.
    """

    def __init__(
        self, where: Callable[[str], Span | None], types: Collection[str] = (), *, assumed: bool = False
    ) -> None:
        self.where, self.types, self.assumed = where, types, assumed
        self.graphs: dict[str, RecordedGraph] = {}
        self.findings = Findings()
        self.compounds: dict[str, Compounds] = {}
        self.parts = 0
        self.told: set[str] = set()
        self.prims: set[str] = set()
        """Paths of other prims that the script made."""
        self.namespaces: dict[str, str] = {}
        """`isaac:namespace` by prim."""
        self.refused: list[tuple[Exception, str, Span | None]] = []
        """Calls that OmniGraph refuses too, and where they are."""
        self.said: deque[str] = deque(maxlen=3)
        """Lines that the script printed last."""
        self.idle_calls = 0
        """Calls that did nothing to graphs."""
        self.opened: set[str] = set()
        """Graphs that the script edits as if they were there already."""
        self.put: dict[str, str] = {}
        """Where graphs were put whose place only Omniverse knows, by their paths as the script has them."""

    def leave_out(self, message: str, hint: str = "", *help: str) -> None:
        """Tell of something that the graphs will lack."""
        self.findings.add("W302", message, self.where(hint), *help)

    def leave_out_once(self, message: str) -> None:
        """Tell of something that the graphs will lack, if it is not told yet."""
        if message not in self.told:
            self.told.add(message)
            self.leave_out(message)

    def pass_over(self, what: str, *help: str) -> None:
        """Tell once of something that a script does and that has nothing to do with graphs."""
        if what not in self.told and len(self.told) < 1000:
            self.told.add(what)
            self.findings.add("N302", f"{what} belongs to no graph and is left out", self.where(""), *help)

    def refuse(self, error: Exception) -> None:
        """Keep an error that a call raises; the script may catch it."""
        if len(self.refused) < MAX_REFUSED and error not in (known for known, _, _ in self.refused):
            self.refused.append((error, str(error), self.where("")))

    def count(self) -> None:
        """Bound what is made."""
        self.parts += 1
        if self.parts > MAX_PARTS:
            raise OmniGraphError(f"more than {MAX_PARTS} nodes, wires and values")

    # Graphs

    def create_graph(self, path: str, evaluator: str = "push", stage: PipelineStage = "simulation") -> RecordedGraph:
        """A graph that there was not yet."""
        path = self._put(path) if is_unknown(path) else absolute(path)
        if path in self.graphs:
            raise OmniGraphError(f"there is a graph at {path!r} already")
        if evaluator not in EVALUATORS:
            raise OmniGraphError(f"no evaluator {evaluator!r}; {listing(EVALUATORS)}")
        self.count()
        graph = RecordedGraph(path, evaluator, stage, span=self.where(path))
        self.graphs[path] = graph
        self.compounds[path] = {}
        return graph

    def _put(self, path: str) -> str:
        """A place for a graph whose own only Omniverse knows, of which the end may be known."""
        known = path.rpartition(">")[2].strip("/") or "ActionGraph"
        choices = (f"/World/{known}", *(f"/World/{known}_{number}" for number in range(2, len(self.graphs) + 3)))
        self.put[path.rstrip("/")] = place = next(choice for choice in choices if choice not in self.graphs)
        self.leave_out(f"the place {path} of a graph cannot be told; it is put at {place}", path, "say it behind `at:`")
        return place

    def meant(self, path: str) -> str:
        """A path as the script has it, with the places of graphs that were put somewhere."""
        for unknown, place in self.put.items():
            if path == unknown or path.startswith((f"{unknown}/", f"{unknown}.")):
                return place + path[len(unknown) :]
        return path

    def graph_at(self, path: str) -> RecordedGraph | None:
        """The graph at a path; None where there is none."""
        return self.graphs.get(self.meant(path.rstrip("/")))

    def graph_of(self, path: str) -> tuple[RecordedGraph, str] | None:
        """The graph whose prim is at a path or above it, and the rest of the path; None where there is none."""
        path = self.meant(path)
        for end in _ends(path):
            if path[:end] in self.graphs:
                return self.graphs[path[:end]], path[end + 1 :]
        return None

    def remove(self, path: str) -> None:
        """Remove the prim at a path: a graph, a node, or graphs below it."""
        for known in [known for known in self.graphs if known == path or known.startswith(f"{path}/")]:
            del self.graphs[known]
        found = self.graph_of(path)
        if found and found[1] in found[0].nodes:
            self.delete_node(*found)

    # Nodes

    def create_node(self, graph: RecordedGraph, name: str, type: str, *, allow_exists: bool = False) -> str:
        """A node; its name below the graph."""
        name = self.name_below(graph, name)
        if name in graph.nodes or name in self.compounds[graph.path]:
            if allow_exists:
                return name
            raise OmniGraphError(f"there is a node {name!r} in {graph.path} already")
        known = checked(type, f"the type of {name}") if type else ""
        self.count()
        graph.nodes[name] = RecordedNode(name, known, span=self.where(name.rpartition("/")[2]))
        return name

    def create_compound(self, graph: RecordedGraph, name: str) -> str:
        """A compound; its nodes become those of the graph."""
        name = self.name_below(graph, name)
        self.count()
        self.compounds[graph.path].setdefault(name, {})
        return name

    def name_below(self, graph: RecordedGraph, path: str) -> str:
        """A node's name below its graph, of a name or of an absolute path."""
        path = self.meant(checked(path, "the name of a node"))
        if not path.startswith("/"):
            return posixpath.normpath(path)
        if not path.startswith(f"{graph.path}/"):
            raise OmniGraphError(f"{path!r} lies outside of the graph {graph.path!r}")
        return path[len(graph.path) + 1 :]

    def find_node(self, graph: RecordedGraph | None, path: str) -> tuple[RecordedGraph, str]:
        """A node or compound by its name in a graph, or by its absolute path."""
        path = self.meant(path)
        found = self.graph_of(path) if path.startswith("/") else graph and (graph, path)
        if not found:
            raise NotThereError(f"no graph holds the node {path!r}")
        inside, name = found
        compounds = self.compounds.get(inside.path, {})
        if name not in inside.nodes and name not in compounds:
            near = did_you_mean(name, inside.nodes) or listing(inside.nodes, "nodes")
            error = NotThereError if inside.path in self.opened else OmniGraphError
            raise error(f"no node {name!r} in {inside.path}; {near}")
        return inside, name

    def delete_node(self, graph: RecordedGraph, name: str) -> None:
        """Remove a node, or a compound, with its wires."""
        gone = {known for known in graph.nodes if known == name or known.startswith(f"{name}/")}
        for known in gone:
            del graph.nodes[known]
        self.compounds[graph.path].pop(name, None)
        graph.wires = [wire for wire in graph.wires if wire.source not in gone and wire.target not in gone]

    # Attributes

    def attribute(self, graph: RecordedGraph | None, path: str) -> Place:
        """The attribute that a path such as `Node.inputs:x` means; of a compound, the inner one that it stands for."""
        node, name = split_attribute(self.meant(checked(path, "an attribute such as 'Node.inputs:x'")))
        inside, found = self.find_node(graph, node)
        return self.inner(Place(inside, found, name))

    def inner(self, place: Place) -> Place:
        """Through the compounds to the attribute of a node."""
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
        """Give a compound an attribute that stands for one of its nodes'."""
        side = place.name.partition(":")[0]
        full = name if name.startswith(SIDES) else f"{side}:{name}"
        self.compounds[place.graph.path][compound][full] = (place.node, place.name)

    def create_attribute(self, place: Place, type: Any, port_type: Any = None) -> Place:
        """Add an attribute to a node, on the side that its name says, or else its type or port type."""
        said = str((type[1:] if isinstance(type, tuple) else (), port_type))
        side = "outputs" if "OUTPUT" in said else "state" if "STATE" in said else "inputs"
        name = place.name if place.name.startswith(SIDES) else f"{side}:{place.name}"
        self.count()
        try:
            self.node(place).attributes[name] = type_name(type)
        except UnknownError as error:
            self.leave_out(f"the type of {place.node}.{name} cannot be told: {error}", place.name)
        return Place(place.graph, place.node, name)

    def node(self, place: Place) -> RecordedNode:
        """The node of an attribute.

        Raises:
            OmniGraphError: it was deleted.
        """
        try:
            return place.graph.nodes[place.node]
        except KeyError:
            raise OmniGraphError(f"there is no node {place.node!r} in {place.graph.path} any more") from None

    def set_value(self, place: Place, value: Any, type: Any = "") -> None:
        """Set an attribute."""
        hint = f"{place.node.rpartition('/')[2]}.{place.name}"
        try:
            data = plain_data(value)
        except UnknownError as error:
            self.leave_out(
                f"the value of {place.node}.{place.name} cannot be told: {error}", hint, "set it in the file"
            )
            return
        self.count()
        node = self.node(place)
        if place.name == POSITION:
            if isinstance(data, list) and len(data) == 2 and all(isinstance(part, int | float) for part in data):
                node.position = float(data[0]), float(data[1])
            return
        known = "" if type is None or type == "" or is_unknown(type) else type_name(type)
        node.values[place.name] = RecordedValue(data, known, self.where(hint))

    def value(self, place: Place) -> Any:
        """What an attribute was set to; None where it was not."""
        known = place.graph.nodes.get(place.node)
        found = known.values.get(place.name) if known else None
        return found.data if found else None

    # Wires

    def connect(self, source: Place, target: Place) -> None:
        """Add a wire."""
        if source.graph is not target.graph:
            self.leave_out(f"the wire {source.path} -> {target.path} leads from one graph into another", source.name)
            return
        self.count()
        self.node(source), self.node(target)
        name = f"{source.node.rpartition('/')[2]}.{source.name}"
        wire = RecordedWire(source.node, source.name, target.node, target.name, self.where(name))
        source.graph.wires.append(wire)

    def disconnect(self, source: Place, target: Place) -> None:
        """Remove a wire."""
        wire = RecordedWire(source.node, source.name, target.node, target.name)
        source.graph.wires = [known for known in source.graph.wires if known != wire]

    def disconnect_all(self, place: Place) -> None:
        """Remove all wires of an attribute."""
        end = (place.node, place.name)
        place.graph.wires = [
            wire
            for wire in place.graph.wires
            if end not in ((wire.source, wire.source_port), (wire.target, wire.target_port))
        ]

    def upstream(self, place: Place) -> list[Place]:
        """Attributes that are wired to one."""
        wires = place.graph.wires
        ends = [(w.source, w.source_port) for w in wires if (w.target, w.target_port) == (place.node, place.name)]
        return [Place(place.graph, *end) for end in ends]

    def downstream(self, place: Place) -> list[Place]:
        """Attributes that one is wired to."""
        wires = place.graph.wires
        ends = [(w.target, w.target_port) for w in wires if (w.source, w.source_port) == (place.node, place.name)]
        return [Place(place.graph, *end) for end in ends]

    # Variables

    def create_variable(self, graph: RecordedGraph, name: str, type: Any, default: Any = None) -> None:
        """Add a variable to a graph."""
        name = checked(name, "the name of a variable")
        if name in graph.variables:
            raise OmniGraphError(f"there is a variable {name!r} in {graph.path} already")
        self.count()
        try:
            graph.variables[name] = RecordedValue(None, type_name(type), self.where(name))
        except UnknownError as error:
            self.leave_out(f"the type of variable {name!r} cannot be told: {error}", name)
            return
        if default is not None:
            self.set_variable(graph, name, default)

    def set_variable(self, graph: RecordedGraph, name: str, value: Any) -> None:
        """Set the default of a variable."""
        if name not in graph.variables:
            raise OmniGraphError(f"no variable {name!r} in {graph.path}; {listing(graph.variables, 'variables')}")
        try:
            graph.variables[name].data = plain_data(value)
        except UnknownError as error:
            self.leave_out(f"the default of variable {name!r} cannot be told: {error}", name)


def _ends(path: str) -> list[int]:
    return [len(path), *(i for i in range(len(path) - 1, 0, -1) if path[i] == "/")]
