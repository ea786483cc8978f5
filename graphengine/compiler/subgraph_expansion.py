"""Expands the subgraphs of a graph file to one flat list of nodes and wires."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from graphengine.compiler.budget import Budget, OverBudgetError, Via
from graphengine.compiler.filled_document import FilledDocument, Use
from graphengine.compiler.library import GraphLibrary
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.document import Document, Location
from graphengine.format.files import NotFoundError
from graphengine.format.spec import GraphSpec, NodeSpec, VariableSpec
from graphengine.format.spec_reader import Loaded
from graphengine.format.wording import listing

MAX_SUBGRAPH_DEPTH = 16
"""Maximum nesting depth of subgraphs."""

Side = Literal["inputs", "outputs"]

_END = re.compile(
    r"(?P<node>[A-Za-z_][A-Za-z0-9_]*)\.(?:(?P<side>inputs|outputs|state):)?(?P<port>[A-Za-z_][A-Za-z0-9_:]*)\Z"
)


@dataclass(frozen=True, slots=True)
class Given:
    """A value that a file sets for an input of a subgraph, with the positions of the value and its key."""

    value: Any
    span: Span
    key_span: Span


@dataclass(frozen=True, slots=True)
class NodeEntry:
    """A node of the flat graph; the id of a node `Node` in a subgraph `Instance` is `Instance/Node`."""

    id: str
    spec: NodeSpec
    document: Document
    location: Location
    via: Via = ()
    """Position of each use of a subgraph around the node, from the outermost inwards, with a note; empty outside of subgraphs."""
    given: Mapping[str, Given] = field(default_factory=dict)
    """Values that the use of the subgraph sets for inputs of this node, by port name."""

    def span(self, *location: str | int) -> Span:
        """Return the position of a value of the node: in the file of the node, or where the use of its subgraph sets the value.

        The location starts at the node, as in `("inputs", "wheelRadius")`.
        """
        given = self._given(location)
        return given.span if given else self.document.span(*self.location, *location)

    def key_span(self, *location: str | int) -> Span:
        """Return the position of a key of the node: in the file of the node, or where the use of its subgraph sets the value."""
        given = self._given(location)
        return given.key_span if given else self.document.key_span(*self.location, *location)

    def is_written(self, *location: str | int) -> bool:
        """Return whether the value at a location of the node is written in a file.

        The result is false for `$(name)` if the engine sets the parameter, as it sets `robot`.
        """
        document, location = self.document, (*self.location, *location)
        return not isinstance(document, FilledDocument) or document.origin(*location) is not None

    def _given(self, location: tuple[str | int, ...]) -> Given | None:
        return self.given.get(str(location[1])) if location[:1] == ("inputs",) and len(location) > 1 else None


@dataclass(frozen=True, slots=True)
class WireEnd:
    """One end of a wire: id of a node, name of a port, and the side of the port; the side is empty if the file omits it."""

    node: str
    port: str
    side: str
    span: Span
    via: Via = ()
    """Position of the wire's end in each graph around the node, from the outermost inwards, if the wire enters subgraphs."""

    def __str__(self) -> str:
        return f"{self.node}.{self.port}"


@dataclass(frozen=True, slots=True)
class WireEntry:
    """A wire of the flat graph, with its position in the file."""

    source: WireEnd
    target: WireEnd
    span: Span
    via: Via = ()


@dataclass(frozen=True, slots=True)
class VariableEntry:
    """A variable of the flat graph; each use of a subgraph has its own variables, named `Instance/variable`."""

    spec: VariableSpec
    document: Document
    name: str
    """Name of the variable in its file, without the prefix of the subgraph."""


@dataclass(slots=True)
class FlatGraph:
    """A graph file after parameters were replaced and subgraphs expanded; the input of `resolve`."""

    loaded: Loaded[GraphSpec]
    nodes: list[NodeEntry] = field(default_factory=list)
    wires: list[WireEntry] = field(default_factory=list)
    variables: dict[str, VariableEntry] = field(default_factory=dict)
    unopened: list[str] = field(default_factory=list)
    """Ids of the nodes whose subgraph file has an error or cannot be found; wires to them cause no further errors."""
    unread: int = 0
    """Number of connections that are malformed or that name an unknown port of a subgraph."""
    declared: list[tuple[Side, WireEnd]] = field(default_factory=list)
    """Ports that the file declares for its use as a subgraph, as side and inner port; empty if another file uses the graph."""

    @property
    def spec(self) -> GraphSpec:
        """Spec of the graph file itself; its nodes that use subgraphs are not expanded."""
        return self.loaded.spec


def load_graph(
    path: Path, bindings: Mapping[str, Any], library: GraphLibrary, findings: Findings, use: Use | None = None
) -> FlatGraph | None:
    """Read a graph file, replace its parameters and expand its subgraphs.

    Args:
        path: path of the file.
        bindings: values of the file's parameters, by name.
        library: cache from which graph files are read.
        findings: receives the errors.
        use: place where another file uses the graph, for errors in `bindings`; None for a file that the user gave.

    Returns:
        The flat graph; None after an error in the file itself, or if the graph exceeds a size limit. After an error in a
        subgraph, the flat graph without this subgraph.
    """
    document = library.read(path, findings)
    if document is None:
        return None
    budget = Budget(document.key_span("graph"), findings)
    try:
        loaded = library.load(path, bindings, findings, use, budget)
        if loaded is None:
            return None
        flat = FlatGraph(loaded)
        expansion = _Expansion(flat, library, budget, findings)
        subgraphs = expansion.add(loaded, "", (), (path.resolve(),), {})
        flat.declared = list(expansion.find_declared(loaded, subgraphs)) if use is None else []
    except OverBudgetError:
        return None
    return flat


@dataclass(frozen=True, slots=True)
class _Subgraph:
    """An expanded subgraph: its file, and the expanded subgraphs in it by node name."""

    loaded: Loaded[GraphSpec]
    inner: dict[str, _Subgraph]


_GivenByNode = Mapping[str, Mapping[str, Given]]


@dataclass(slots=True)
class _Expansion:
    """Adds the nodes, wires and variables of a graph file and its subgraphs to a flat graph."""

    flat: FlatGraph
    library: GraphLibrary
    budget: Budget
    findings: Findings

    def add(
        self, loaded: Loaded[GraphSpec], prefix: str, via: Via, stack: tuple[Path, ...], given: _GivenByNode
    ) -> dict[str, _Subgraph]:
        """Add the variables, nodes and wires of a file to the flat graph, and expand its subgraphs.

        Args:
            loaded: the file.
            prefix: prefix of the ids of its nodes, such as `Instance/`; empty for the outermost file.
            via: position of each subgraph use around the file, from the outermost inwards, with a note.
            stack: resolved paths of the files around this one, and of this one.
            given: values that the use of the file sets for inputs of its nodes, by node name and port name.

        Returns:
            The expanded subgraphs, by node name; subgraphs with errors are left out.

        Raises:
            OverBudgetError: the graph exceeds a size limit.
        """
        self.budget.take_parts(loaded.spec)
        subgraphs: dict[str, _Subgraph] = {}
        for name, variable in loaded.spec.variables.items():
            self.flat.variables[prefix + name] = VariableEntry(variable, loaded.document, name)
        for name, spec in loaded.spec.nodes.items():
            from_outside = given.get(name, {})
            spec = _with_values(spec, from_outside) if from_outside else spec
            entry = NodeEntry(prefix + name, spec, loaded.document, ("nodes", name), via, from_outside)
            if not spec.subgraph:
                self.flat.nodes.append(entry)
                continue
            self.budget.at(entry.key_span(), via)
            subgraph = self._add_subgraph(entry, loaded.folder, stack)
            if subgraph is None:
                self.flat.unopened.append(entry.id)
            else:
                subgraphs[name] = subgraph
        for number, text in enumerate(loaded.spec.connections):
            span = loaded.document.span("connections", number)
            ends = self._parse_wire(loaded.document, number, text)
            sources = [source for end in ends[:1] for source in self._lead_through(end, subgraphs, "outputs")]
            targets = [target for end in ends[1:] for target in self._lead_through(end, subgraphs, "inputs")]
            self.flat.unread += not sources or not targets
            wires = ((_prefixed(prefix, source), _prefixed(prefix, target)) for source in sources for target in targets)
            self.flat.wires.extend(WireEntry(*wire, span, via) for wire in wires)
        return subgraphs

    def find_declared(
        self, loaded: Loaded[GraphSpec], subgraphs: Mapping[str, _Subgraph]
    ) -> Iterator[tuple[Side, WireEnd]]:
        """Yield side and inner port of each port that a file declares for its use as a subgraph."""
        sides: tuple[Side, ...] = ("inputs", "outputs")
        for side in sides:
            for port in _declared_ports(loaded, side):
                for end in self._declared(loaded, side, port, "", loaded.document.span(side, port)):
                    yield from ((side, inside) for inside in self._lead_through(end, subgraphs, side))

    def _add_subgraph(self, entry: NodeEntry, folder: Path, stack: tuple[Path, ...]) -> _Subgraph | None:
        """Expand the subgraph file that a node uses; return None after an error, which is added to the findings.

        Args:
            entry: node that uses the subgraph.
            folder: folder of the file that contains the node.
            stack: resolved paths of the files around the subgraph, to detect a subgraph that contains itself.
        """
        span = entry.span("subgraph")
        try:
            path, resolved = self.library.find(entry.spec.subgraph, folder)
        except NotFoundError as error:
            self.findings.add("G214", f"subgraph: {error.message}", span, *error.help)
            return None
        if resolved in stack:
            loop = " -> ".join(p.name for p in (*stack[stack.index(resolved) :], path))
            self.findings.add("G214", f"the subgraph contains itself: {loop}", span)
            return None
        if len(stack) > MAX_SUBGRAPH_DEPTH:
            self.findings.add("G214", f"subgraphs are nested more than {MAX_SUBGRAPH_DEPTH} levels deep", span)
            return None
        given = entry.spec.parameters
        written = {name for name in given if entry.is_written("parameters", name)}
        use = Use(span, entry, ("parameters",), written, f"{entry.id}/")
        inner = self.library.load(path, given, self.findings, use, self.budget)
        if inner is None:
            return None
        via = (*entry.via, (entry.key_span(), f"in subgraph {entry.id}"))
        handed_on = self._hand_on(entry, inner)
        return _Subgraph(inner, self.add(inner, f"{entry.id}/", via, (*stack, resolved), handed_on))

    def _hand_on(self, entry: NodeEntry, inner: Loaded[GraphSpec]) -> _GivenByNode:
        """Return the values that the use of a subgraph sets for its inputs, as `given` of `add` for the subgraph's file.

        Args:
            entry: node that uses the subgraph.
            inner: file of the subgraph.
        """
        handed_on: dict[str, dict[str, Given]] = {}
        for name, value in entry.spec.inputs.items():
            given = Given(value, entry.span("inputs", name), entry.key_span("inputs", name))
            for end in self._declared(inner, "inputs", name.removeprefix("inputs:"), entry.id, given.key_span):
                handed_on.setdefault(end.node, {})[end.port] = given
        return handed_on

    def _parse_wire(self, document: Document, number: int, text: str) -> list[WireEnd]:
        """Return the two ends of a connection such as `A.x -> B.y`; none after an error, which is added to the findings.

        Args:
            document: file that contains the connection.
            number: index of the connection in the list `connections`.
            text: the connection.
        """
        value = document.find("connections", number)
        assert value is not None
        legal = "write `Node.port -> Other.port`, as in `OnPlaybackTick.tick -> SubscribeTwist.execIn`"
        source, *targets = re.split(r"\s*->\s*", text)
        if len(targets) != 1:
            arrows = f"a connection has one arrow, this one has {len(targets) or 'none'}"
            self.findings.add("G202", arrows, value.span, legal)
            return []
        parts = [(source, value.span), (targets[0], value.span)]
        if value.plain and value.span.length == len(text):
            offsets = (0, text.rindex(targets[0]))
            parts = [(part, span.part(at, len(part))) for (part, span), at in zip(parts, offsets, strict=True)]
        return self._read_ends(parts, legal)

    def _read_ends(self, texts: Iterable[tuple[str, Span]], legal: str = "") -> list[WireEnd]:
        """Parse ends of wires, `Node.port` or `Node.side:port`. If a text has neither form, add a finding and return no ends.

        Args:
            texts: texts of the ends, with their positions.
            legal: help line of the finding.
        """
        ends = list[WireEnd]()
        for text, span in texts:
            match = _END.match(text)
            if match is None:
                self.findings.add("G202", f"{text!r} does not have the form `Node.port`", span, legal)
                return []
            ends.append(WireEnd(match["node"], match["port"], match["side"] or "", span))
        return ends

    def _declared(self, inner: Loaded[GraphSpec], side: Side, port: str, subgraph: str, span: Span) -> list[WireEnd]:
        """Return the inner ports that a declared port of a subgraph exposes; after an error, add a finding and return no ports.

        Args:
            inner: file of the subgraph.
            side: side of the declared port.
            port: name of the declared port.
            subgraph: name of the node that uses the subgraph, for messages.
            span: position of the reference to the port.
        """
        declared = _declared_ports(inner, side)
        if port not in declared:
            near = self.findings.guess(port, declared) or listing(declared, side)
            self.findings.add("G204", f"subgraph {subgraph!r} has no {side[:-1]} {port!r}", span, near)
            return []
        texts = enumerate(declared[port] or ("",))
        return self._read_ends((text, inner.document.span(side, port, number)) for number, text in texts)

    def _lead_through(self, end: WireEnd, subgraphs: Mapping[str, _Subgraph], side: Side) -> Iterator[WireEnd]:
        """Follow one end of a wire into nested subgraphs; yield the ports of ordinary nodes there. Yield none after an error.

        Args:
            end: end of the wire, in a graph.
            subgraphs: expanded subgraphs of this graph, by node name.
            side: `outputs` if the wire begins at this end, `inputs` if it ends here.

        Raises:
            OverBudgetError: the graph exceeds a size limit.
        """
        subgraph = subgraphs.get(end.node)
        if subgraph is None:
            yield end
            return
        for number, declared in enumerate(self._declared(subgraph.loaded, side, end.port, end.node, end.span)):
            if number:
                self.budget.take_wire()
            for inside in self._lead_through(declared, subgraph.inner, side):
                via = ((end.span, f"in subgraph {end.node}"), *inside.via)
                yield replace(inside, node=f"{end.node}/{inside.node}", via=via)


def _with_values(spec: NodeSpec, given: Mapping[str, Given]) -> NodeSpec:
    """Return the spec of a node with the input values that the use of its subgraph sets; they override the values in the node."""
    own = {port: value for port, value in spec.inputs.items() if port.removeprefix("inputs:") not in given}
    return spec.model_copy(update={"inputs": own | {port: one.value for port, one in given.items()}})


def _declared_ports(loaded: Loaded[GraphSpec], side: Side) -> Mapping[str, tuple[str, ...]]:
    """Return a dict from names of the ports that a file declares on one side to their inner ports, such as `Node.port`."""
    return loaded.spec.inputs if side == "inputs" else {name: (port,) for name, port in loaded.spec.outputs.items()}


def _prefixed(prefix: str, end: WireEnd) -> WireEnd:
    return replace(end, node=prefix + end.node)
