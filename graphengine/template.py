"""Graph files with their parameters filled in and their subgraphs put in place: one flat list of nodes and wires."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from graphengine import document as documents
from graphengine import types
from graphengine.diagnostics import MAX_ERRORS, Findings, Span, did_you_mean, listing, shown
from graphengine.document import MAX_BYTES, Document, Location, Value
from graphengine.files import Files, NotFoundError
from graphengine.spec import FORMAT, GraphSpec, NodeSpec
from graphengine.spec_reader import Loaded, validate

MAX_NODES = 20_000
MAX_SUBGRAPH_DEPTH = 16

UNKNOWN: Any = type("Unknown", (), {"__repr__": lambda _: "UNKNOWN"})()
"""Value of an input that cannot be known because of a mistake which was told already."""

_PARAMETER = re.compile(r"\$\$|\$\(([^$()]*)\)")
_END = re.compile(
    r"(?P<node>[A-Za-z_][A-Za-z0-9_]*)\.(?:(?P<side>inputs|outputs|state):)?(?P<port>[A-Za-z_][A-Za-z0-9_:]*)\Z"
)


@dataclass(frozen=True, slots=True)
class NodeEntry:
    """A node of the flat graph; inside a subgraph its id is `Instance/Node`."""

    id: str
    spec: NodeSpec
    document: Document
    location: Location
    via: tuple[tuple[Span, str], ...] = ()
    """Where the subgraphs it came through were used."""

    def span(self, *location: str | int) -> Span:
        """Place of something below the node in its own file."""
        return self.document.span(*self.location, *location)

    def key_span(self, *location: str | int) -> Span:
        """Place of a key below the node."""
        return self.document.key_span(*self.location, *location)


@dataclass(frozen=True, slots=True)
class WireEnd:
    """One end of a wire: a node's id and a port, with the side if the file gave it."""

    node: str
    port: str
    side: str
    span: Span
    via: tuple[tuple[Span, str], ...] = ()
    """Where a port that a subgraph declares was wired."""

    def __str__(self) -> str:
        return f"{self.node}.{self.port}"


@dataclass(frozen=True, slots=True)
class WireEntry:
    """A wire of the flat graph."""

    source: WireEnd
    target: WireEnd
    span: Span
    via: tuple[tuple[Span, str], ...] = ()


@dataclass(slots=True)
class FlatGraph:
    """A graph file after parameters and subgraphs: what resolve works on."""

    loaded: Loaded[GraphSpec]
    nodes: list[NodeEntry] = field(default_factory=list)
    wires: list[WireEntry] = field(default_factory=list)
    unopened: list[str] = field(default_factory=list)
    """Ids of subgraphs that could not be opened; wires to them are no second mistake."""

    @property
    def spec(self) -> GraphSpec:
        """The outermost file."""
        return self.loaded.spec


@dataclass(frozen=True, slots=True)
class Use:
    """Where a file uses a graph, and where it gives values for the graph's parameters."""

    span: Span
    keys: Mapping[str, Span] = field(default_factory=dict)
    values: Mapping[str, Span] = field(default_factory=dict)


def load_graph(
    path: Path,
    bindings: Mapping[str, Any],
    files: Files,
    findings: Findings,
    shown_as: str | None = None,
    use: Use | None = None,
) -> FlatGraph | None:
    """Read a graph file, fill in its parameters and expand its subgraphs.

    Args:
        path: the file.
        bindings: values for its parameters.
        files: where the files of subgraphs are looked for.
        findings: where mistakes go.
        shown_as: the path that messages name.
        use: what put the graph where it is; mistakes in `bindings` are told there.
    """
    loaded = _load(path, bindings, findings, shown_as or str(path), use)
    if loaded is None:
        return None
    flat = FlatGraph(loaded)
    _expand(flat, loaded, "", (), (path.resolve(),), files, findings)
    return flat


def _load(
    path: Path, bindings: Mapping[str, Any], findings: Findings, shown_as: str, use: Use | None
) -> Loaded[GraphSpec] | None:
    document = documents.load(path, findings, shown_as)
    if document is None:
        return None
    data = document.data
    if not isinstance(data, dict) or data.get("format", FORMAT) == FORMAT:  # another may mean other things by the rest
        values = _parameter_values(document, bindings, findings, use)
        data = _Filler(values, findings).fill(document.root)
    spec = validate(GraphSpec, document, data, findings)
    return Loaded(spec, document) if spec is not None else None


def _parameter_values(
    document: Document, bindings: Mapping[str, Any], findings: Findings, use: Use | None
) -> dict[str, Any]:
    """Declared parameters with the values given for them, else their defaults; UNKNOWN after a mistake."""
    declared = document.find("parameters")
    names = declared.data if declared is not None and isinstance(declared.data, dict) else {}
    for name in bindings:
        if name not in names:
            where = use.keys.get(name, use.span) if use else document.span("graph")
            near = did_you_mean(name, names) or listing(names, "parameters")
            findings.add("G111", f"the graph has no parameter {name!r}", where, near)
    values: dict[str, Any] = {}
    for name, value in names.items():
        data = value.to_data()
        values[name] = UNKNOWN
        if not isinstance(data, dict) or not isinstance(data.get("type"), str):
            continue
        try:
            port_type = types.parse(data["type"])
        except ValueError as error:
            findings.add("G211", str(error), document.span("parameters", name, "type"))
            continue
        if name not in bindings and data.get("default") is None:
            findings.add(
                "G107",
                f"parameter {name!r} of graph {document.source.path} has no default and was given no value",
                use.span if use else document.key_span("parameters", name),
                "write a default, or give a value where the graph is used",
            )
            continue
        given = bindings.get(name, data.get("default"))
        try:
            coerced = types.coerce(given, port_type) if isinstance(port_type, types.PortType) else given
        except (TypeError, ValueError) as error:
            where = document.span("parameters", name, "default")
            if use and name in bindings:
                where = use.values.get(name, use.span)
            findings.add("G211", f"parameter {name!r} is a {port_type}: {error}, got {shown(given)}", where)
            continue
        values[name] = coerced[0] if port_type == types.TARGET and len(coerced) == 1 else coerced
    return values


class _Filler:
    """Puts the values of parameters in the place of `$(name)`, and counts what that amounts to."""

    def __init__(self, values: Mapping[str, Any], findings: Findings) -> None:
        self.values = values
        self.texts = {name: str(value) for name, value in values.items() if value is not UNKNOWN}
        self.findings = findings
        self.size = 0
        self.unknown = 0

    def fill(self, value: Value, location: Location = ()) -> Any:
        """Plain data with `$(name)` replaced; keys, types and the parameters themselves are left alone.

        What cannot be known is UNKNOWN as an input of a node; elsewhere its key is left out.
        """
        if isinstance(value.data, dict):
            return self._mapping(value.data, location)
        if isinstance(value.data, list):
            items = [self.fill(item, (*location, i)) for i, item in enumerate(value.data)]
            return UNKNOWN if _holds_unknown(items) else items
        if not isinstance(value.data, str) or "$" not in value.data:
            return value.data
        return self._text(value)

    def _mapping(self, data: Mapping[str, Value], location: Location) -> Any:
        filled = {
            key: item.to_data() if _is_literal((*location, key), item) else self.fill(item, (*location, key))
            for key, item in data.items()
        }
        if location[:1] == ("nodes",) and location[2:3] == ("inputs",):
            return UNKNOWN if len(location) > 3 and _holds_unknown(filled.values()) else filled
        return {key: item for key, item in filled.items() if item is not UNKNOWN}

    def _text(self, value: Value) -> Any:
        before, known = self.size, True
        whole = _PARAMETER.fullmatch(value.data)
        if whole and whole[1] in self.texts:
            found = self.values[whole[1]]
            self.size += getattr(found, "nbytes", len(self.texts[whole[1]]))
            filled = list(found) if isinstance(found, tuple) else found
        else:

            def replacement(match: re.Match[str]) -> str:
                nonlocal known
                if match[0] == "$$":
                    return "$"
                if match[1] not in self.values:
                    self._tell_unknown(match, value)
                text = self.texts.get(match[1])
                known = known and text is not None
                self.size += len(text or "")
                return text or "" if self.size <= MAX_BYTES else ""

            filled = _PARAMETER.sub(replacement, value.data)
        if before <= MAX_BYTES < self.size:
            what = f"more than {MAX_BYTES // 1_000_000} MB when the parameters are filled in"
            self.findings.add("G105", what, value.span, "split the file, or repeat less")
        return filled if known and self.size <= MAX_BYTES else UNKNOWN

    def _tell_unknown(self, match: re.Match[str], value: Value) -> None:
        self.unknown += 1
        if self.unknown <= MAX_ERRORS:
            span = value.span.part(match.start(), len(match[0])) if value.plain else value.span
            near = did_you_mean(match[1], self.values) or listing(self.values, "parameters")
            self.findings.add("G111", f"no parameter {match[1]!r}", span, near)


def _holds_unknown(values: Iterable[Any]) -> bool:
    return any(value is UNKNOWN for value in values)


def _is_literal(location: Location, value: Value) -> bool:
    """Whether `$(name)` stands for itself: in keys, wires and types."""
    if location[0] in ("parameters", "graph", "format", "connections", "layout"):
        return True
    short_form = len(location) == 2 and isinstance(value.data, str)
    return location[0] == "nodes" and (short_form or (len(location) == 3 and location[2] in ("type", "subgraph")))


def _expand(
    flat: FlatGraph,
    loaded: Loaded[GraphSpec],
    prefix: str,
    via: tuple[tuple[Span, str], ...],
    stack: tuple[Path, ...],
    files: Files,
    findings: Findings,
) -> dict[str, Loaded[GraphSpec]]:
    """Append a file's nodes and wires; subgraphs first become nodes, then the wires to them are led through."""
    subgraphs: dict[str, Loaded[GraphSpec]] = {}
    for name, spec in loaded.spec.nodes.items():
        entry = NodeEntry(prefix + name, spec, loaded.document, ("nodes", name), via)
        if not spec.subgraph:
            flat.nodes.append(entry)
            if len(flat.nodes) > MAX_NODES:
                findings.add("G105", f"more than {MAX_NODES} nodes in one graph", entry.span())
                return subgraphs
            continue
        inner = _open_subgraph(entry, loaded.folder, stack, files, findings)
        if inner is None:
            flat.unopened.append(entry.id)
        else:
            subgraphs[name] = inner
            inner_via = (*via, (entry.key_span(), f"in subgraph {entry.id}"))
            _expand(
                flat, inner, f"{prefix}{name}/", inner_via, (*stack, inner.document.path.resolve()), files, findings
            )
    for number, text in enumerate(loaded.spec.connections):
        wire = _parse_wire(loaded.document, ("connections", number), text, findings)
        if wire is not None:
            source, target, span = wire
            outer = _lead_through(source, subgraphs, "outputs", findings)
            inner_end = _lead_through(target, subgraphs, "inputs", findings)
            if outer is not None and inner_end is not None:
                flat.wires.append(WireEntry(_prefixed(prefix, outer), _prefixed(prefix, inner_end), span, via))
    return subgraphs


def _prefixed(prefix: str, end: WireEnd) -> WireEnd:
    return replace(end, node=prefix + end.node)


def _open_subgraph(
    entry: NodeEntry, folder: Path, stack: tuple[Path, ...], files: Files, findings: Findings
) -> Loaded[GraphSpec] | None:
    span = entry.span("subgraph")
    try:
        path = files.find(entry.spec.subgraph, folder)
    except NotFoundError as error:
        findings.add("G214", f"subgraph: {error.message}", span, *error.help)
        return None
    if path.resolve() in stack:
        loop = " -> ".join(p.name for p in (*stack[stack.index(path.resolve()) :], path))
        findings.add("G214", f"a subgraph that contains itself: {loop}", span)
        return None
    if len(stack) > MAX_SUBGRAPH_DEPTH:
        findings.add("G214", f"subgraphs nested more than {MAX_SUBGRAPH_DEPTH} deep", span)
        return None
    inner = _load(path, {}, findings, str(path), Use(span))
    if inner is None:
        return None
    for name in entry.spec.inputs:
        findings.add(
            "G214",
            f"{name!r}: values for a subgraph's inputs are wired, not set",
            entry.key_span("inputs", name),
            "wire a Constant node",
        )
    return inner


def _parse_wire(
    document: Document, location: Location, text: str, findings: Findings
) -> tuple[WireEnd, WireEnd, Span] | None:
    value = document.find(*location)
    assert value is not None
    parts = re.split(r"\s*->\s*", text)
    ends: list[WireEnd] = []
    offset = 0
    for part in parts:
        offset = text.index(part, offset) if part else offset
        span = value.span.part(offset, len(part)) if value.plain and value.span.length == len(text) else value.span
        offset += len(part)
        match = _END.match(part)
        if match is None or len(parts) != 2:
            legal = "write `Node.port -> Other.port`, as in `OnPlaybackTick.tick -> SubscribeTwist.execIn`"
            arrows = f"a connection has one arrow, this one {len(parts) - 1 or 'none'}"
            what = f"{part!r} is not `Node.port`" if len(parts) == 2 else arrows
            findings.add("G202", what, span if len(parts) == 2 else value.span, legal)
            return None
        ends.append(WireEnd(match["node"], match["port"], match["side"] or "", span))
    return ends[0], ends[1], value.span


def _lead_through(
    end: WireEnd, subgraphs: Mapping[str, Loaded[GraphSpec]], side: str, findings: Findings
) -> WireEnd | None:
    """The end inside of a subgraph that a wire to one of its declared ports means."""
    if end.node not in subgraphs:
        return end
    subgraph = subgraphs[end.node]
    declared = subgraph.spec.outputs if side == "outputs" else subgraph.spec.inputs
    if end.port not in declared:
        findings.add(
            "G204",
            f"subgraph {end.node!r} has no {side[:-1]} {end.port!r}",
            end.span,
            did_you_mean(end.port, declared) or listing(declared, side),
        )
        return None
    span = subgraph.document.span(side, end.port)
    match = _END.match(declared[end.port])
    if match is None:
        findings.add("G202", f"{declared[end.port]!r} is not `Node.port`", span)
        return None
    if match["node"] in _inner_subgraphs(subgraph):
        findings.add(
            "G214",
            f"port {declared[end.port]} of a subgraph leads into another subgraph",
            end.span,
            "wire it inside of the subgraph's own file",
        )
        return None
    via = ((end.span, f"in subgraph {end.node}"),)
    return WireEnd(f"{end.node}/{match['node']}", match["port"], match["side"] or "", span, via)


def _inner_subgraphs(loaded: Loaded[GraphSpec]) -> list[str]:
    return [name for name, spec in loaded.spec.nodes.items() if spec.subgraph]


def node_names(flat: FlatGraph) -> Iterator[str]:
    """Ids of all nodes in order."""
    return (node.id for node in flat.nodes)
