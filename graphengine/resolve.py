"""From a flat graph to typed instances and wires; every mistake becomes a finding, none stops the search for the next."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from graphengine import types
from graphengine.diagnostics import MAX_ERRORS, Findings, Span, did_you_mean, listing, shown
from graphengine.node import Node, Port, grown
from graphengine.registry import Registry
from graphengine.template import UNKNOWN, FlatGraph, NodeEntry, WireEnd, WireEntry
from graphengine.types import PortType, UnionType


@dataclass(slots=True, eq=False)
class Instance:
    """A node of a resolved graph."""

    index: int
    id: str
    node: Node
    entry: NodeEntry
    literals: set[str] = field(default_factory=set)
    """Fields of inputs that the file or an override set."""
    refused: set[str] = field(default_factory=set)
    """Fields of inputs whose value was told to be wrong: they are not missing as well."""
    settled: dict[str, PortType] = field(default_factory=dict)
    """Types that ports of several types were resolved to, by field."""

    @property
    def cls(self) -> type[Node]:
        """Its type."""
        return type(self.node)

    @property
    def span(self) -> Span:
        """Where its name stands in the file."""
        return self.entry.key_span()


@dataclass(frozen=True, slots=True)
class Wire:
    """A wire between two instances; `converter` names how a value changes type on the way."""

    source: int
    source_field: str
    target: int
    target_field: str
    converter: str
    entry: WireEntry
    order: int

    @property
    def span(self) -> Span:
        """Where it stands in the file."""
        return self.entry.span

    def __str__(self) -> str:
        return f"{self.entry.source} -> {self.entry.target}"


@dataclass(slots=True)
class Graph:
    """Typed instances and wires of one graph, put at a prim."""

    name: str
    prim_path: str
    flat: FlatGraph
    instances: list[Instance] = field(default_factory=list)
    data_wires: list[Wire] = field(default_factory=list)
    exec_wires: list[Wire] = field(default_factory=list)
    variables: dict[str, Any] = field(default_factory=dict)

    @property
    def runs(self) -> str:
        """`tick` or `physics_step`."""
        return self.flat.spec.runs

    def by_id(self, node_id: str) -> Instance:
        """The instance of a node's name."""
        return next(instance for instance in self.instances if instance.id == node_id)


@dataclass(slots=True)
class Override:
    """A value given on the command line: `[robot/][graph/]Node.port=value`, globs allowed."""

    text: str
    target: str
    port: str
    value: Any
    used: bool = False

    @staticmethod
    def parse(text: str, value: Any) -> Override:
        """Of `Node.port`, with as many outer names in front as wanted."""
        target, _, port = text.rpartition(".")
        return Override(text, target, port.removeprefix("inputs:"), value)

    def matches(self, path: str) -> bool:
        """Whether it means the node at `robot/graph/Node`."""
        wanted, parts = self.target.split("/"), path.split("/")
        tail = parts[-len(wanted) :]
        return len(tail) == len(wanted) and all(fnmatch.fnmatchcase(p, w) for p, w in zip(tail, wanted, strict=True))


def resolve(
    flat: FlatGraph,
    name: str,
    prim_path: str,
    registry: Registry,
    findings: Findings,
    overrides: Sequence[Override] = (),
) -> Graph:
    """Instances, literals, wires and types of one graph.

    Args:
        flat: the graph file.
        name: `robot/graph`, or `graph` for one that belongs to no robot.
        prim_path: the graph's own prim.
        registry: node types.
        findings: where mistakes go.
        overrides: values from the command line; those that match are marked as used.
    """
    graph = Graph(name, prim_path, flat)
    known = _instantiate(graph, registry, findings)
    _set_literals(graph, known, findings)
    _set_overrides(graph, overrides, findings)
    _connect(graph, known, findings)
    _settle_types(graph, findings)
    _check_required(graph, findings)
    _set_variables(graph, findings)
    return graph


def _instantiate(graph: Graph, registry: Registry, findings: Findings) -> dict[str, Instance | None]:
    """An instance for each entry; None for one of which a mistake was told, so that its wires raise no second finding."""
    known: dict[str, Instance | None] = dict.fromkeys(graph.flat.unopened)
    for entry in graph.flat.nodes:
        found = registry.find(entry.spec.type)
        known[entry.id] = None
        span = entry.span("type")
        if found is None:
            findings.add(
                "G201",
                f"unknown node type {entry.spec.type!r}",
                span,
                registry.suggest(entry.spec.type),
                related=entry.via,
            )
            continue
        if found.old_name:
            new = found.cls.type_name
            findings.add(
                "N101", f"{entry.spec.type!r} is a name from before Isaac Sim 4.5", span, f"its name now is {new!r}"
            )
        try:
            cls = grown(found.cls, entry.spec.inputs)
        except (TypeError, ValueError) as error:
            findings.add("G211", f"{entry.id}: {error}", entry.span("inputs"), related=entry.via)
            continue
        known[entry.id] = instance = Instance(len(graph.instances), entry.id, cls(), entry)
        graph.instances.append(instance)
    return known


def find_port(cls: type[Node], name: str, sides: Iterable[str]) -> Port | None:
    """A node type's port by OmniGraph name, on the first of the sides that has it."""
    return next((cls.ports[f"{side}:{name}"] for side in sides if f"{side}:{name}" in cls.ports), None)


def port_names(cls: type[Node], side: str) -> list[str]:
    """OmniGraph names of a node type's ports on one side."""
    return [port.name for port in cls.fields.values() if port.side == side]


def _set_literals(graph: Graph, known: dict[str, Instance | None], findings: Findings) -> None:
    for instance in graph.instances:
        entry, cls = instance.entry, instance.cls
        for name, value in entry.spec.inputs.items():
            port = find_port(cls, name.removeprefix("inputs:"), ["inputs"])
            if port is None:
                outputs = find_port(cls, name.removeprefix("outputs:"), ["outputs"])
                inputs = [p.name for p in cls.fields.values() if p.side == "inputs" and not p.is_exec]
                findings.add(
                    "G205" if outputs else "G204",
                    f"{name!r} is an output of {cls.__name__}" if outputs else f"{cls.__name__} has no input {name!r}",
                    entry.key_span("inputs", name),
                    did_you_mean(name, inputs) or listing(inputs, "inputs"),
                    related=entry.via,
                )
                meant = [p for p in cls.fields.values() if p.name in inputs and did_you_mean(name, [p.name])]
                instance.refused.update(p.field for p in meant)
            elif port.is_exec:
                findings.add(
                    "G211",
                    f"{name!r} carries execution and has no value",
                    entry.key_span("inputs", name),
                    "wire it",
                    related=entry.via,
                )
            else:
                _set_literal(instance, port, value, entry.span("inputs", name), findings)


def _set_literal(instance: Instance, port: Port, value: Any, span: Span, findings: Findings) -> None:
    """Put a value from the file, or from the command line, into an input."""
    if value is UNKNOWN:
        instance.refused.add(port.field)
        return
    try:
        if isinstance(port.type, UnionType) or port.type == types.ANY:
            port_type, value = _explicit(value, port.type)
            instance.settled[port.field] = port_type
        setattr(instance.node, port.field, port.check(value))
    except TypeError as error:
        instance.refused.add(port.field)
        wrong, _, remedy = str(error).partition("; ")
        if isinstance(port.type, PortType) and port.type.array and isinstance(value, str | int | float):
            remedy = f"write [{value}]"
        findings.add(
            "G211",
            f"{instance.id}.{port.name} is {_a(port.type)}: {wrong}, got {shown(value)}",
            span,
            remedy,
            related=instance.entry.via,
        )
    except ValueError as error:
        instance.refused.add(port.field)
        unit = f" (unit: {port.unit})" if port.unit else ""
        given = "" if ", got " in str(error) else f", got {shown(value)}"
        findings.add(
            "G212",
            f"{instance.id}.{port.name}: {error}{given}{unit}",
            span,
            did_you_mean(str(value), port.tokens) if port.tokens else "",
            related=instance.entry.via,
        )
    else:
        instance.literals.add(port.field)
        instance.refused.discard(port.field)


def _a(port_type: PortType | UnionType) -> str:
    name = str(port_type)
    return f"{'an' if name[0] in 'aeio' else 'a'} {name}"


def _explicit(value: Any, port_type: PortType | UnionType) -> tuple[PortType, Any]:
    """The type and value of a literal for a port of several types: `{type: double, value: 1}`, or the first that takes it."""
    alternatives = port_type.alternatives if isinstance(port_type, UnionType) else ()
    if isinstance(value, dict) and set(value) == {"type", "value"}:
        named = types.parse(str(value["type"]))
        if isinstance(named, UnionType) or (alternatives and named not in alternatives):
            raise ValueError(f"expected one of {port_type}")
        return named, types.coerce(value["value"], named)
    for alternative in alternatives:
        try:
            return alternative, types.coerce(value, alternative)
        except (TypeError, ValueError):
            continue
    raise TypeError("write {type: …, value: …}")


def _set_overrides(graph: Graph, overrides: Sequence[Override], findings: Findings) -> None:
    for override in overrides:
        for instance in graph.instances:
            if not override.matches(f"{graph.name}/{instance.id}"):
                continue
            port = find_port(instance.cls, override.port, ["inputs"])
            if port is not None and not port.is_exec:
                override.used = True
                _set_literal(instance, port, override.value, instance.span, findings)


def _connect(graph: Graph, known: dict[str, Instance | None], findings: Findings) -> None:
    """Wires between ports that exist, in the right direction, of types that match."""
    taken: dict[tuple[int, str], Wire] = {}
    siblings: dict[str, list[str]] = {}
    for node in known:
        siblings.setdefault(node.rpartition("/")[0], []).append(node.rpartition("/")[2])
    for order, entry in enumerate(graph.flat.wires):
        source = _end(entry.source, ("outputs", "state", "inputs"), known, siblings, entry, findings)
        target = _end(entry.target, ("inputs", "state"), known, siblings, entry, findings)
        if source is None or target is None:
            if len(findings.errors) > MAX_ERRORS:  # a guess at what was meant takes time
                return
            continue
        (one, out), (other, into) = source, target
        wire = Wire(one.index, out.field, other.index, into.field, "", entry, order)
        if out.is_exec != into.is_exec:
            what = "execution" if out.is_exec else f"a value ({out.type})"
            wants = "execution" if into.is_exec else f"a value ({into.type})"
            findings.add(
                "G206", f"{entry.source} carries {what}, {entry.target} takes {wants}", entry.span, related=entry.via
            )
        elif out.is_exec and out.side == "inputs":
            findings.add(
                "G205",
                f"{entry.source} is an execution input; a wire begins at an output",
                entry.source.span,
                related=entry.via,
            )
        elif out.is_exec:
            graph.exec_wires.append(wire)
        elif (other.index, into.field) in taken:
            first = taken[other.index, into.field]
            findings.add(
                "G207",
                f"two wires into {entry.target}; a data input takes one",
                entry.span,
                "remove one, or choose between them with a node",
                related=[(first.span, "the other one"), *entry.via],
            )
        else:
            taken[other.index, into.field] = wire
            graph.data_wires.append(wire)
            if into.field in other.literals and not isinstance(into.type, UnionType):
                findings.add(
                    "W103",
                    f"{entry.target} has a value and a wire; the wire wins",
                    other.entry.key_span("inputs", into.name),
                    f"wired from {entry.source}; remove the value, or the wire",
                    related=entry.via,
                )


def _end(
    end: WireEnd,
    sides: tuple[str, ...],
    known: dict[str, Instance | None],
    siblings: dict[str, list[str]],
    wire: WireEntry,
    findings: Findings,
) -> tuple[Instance, Port] | None:
    """The instance and port that one end of a wire means."""
    via = (*wire.via, *end.via)
    if end.node not in known:
        inner, _, name = end.node.rpartition("/")
        near = siblings.get(inner, [])
        hint = did_you_mean(name, near) or listing(near, "nodes")
        findings.add("G203", f"no node {name!r}", end.span, hint, related=via)
        return None
    instance = known[end.node]
    if instance is None:
        return None
    port = find_port(instance.cls, end.port, [end.side] if end.side else sides)
    begins = sides[0] == "outputs"
    if port is not None and (not end.side or end.side in sides):
        return instance, port
    wrong = find_port(instance.cls, end.port, ["inputs", "outputs"])
    names = port_names(instance.cls, sides[0])
    if wrong is not None:
        said = f"not an {end.side[:-1]}" if end.side and end.side != wrong.side else ""
        rule = said or f"a wire {'begins at an output' if begins else 'ends at an input'}"
        other = known.get(wire.source.node)
        turned = not begins and other is not None and find_port(other.cls, wire.source.port, ["inputs"]) is not None
        findings.add(
            "G205",
            f"{end} is an {wrong.side[:-1]}{', ' if said else '; '}{rule}",
            end.span,
            f"write {wire.target} -> {wire.source}" if turned else "",
            f"leave out `{end.side}:`" if said else listing(names, f"{sides[0]} of {instance.cls.__name__}"),
            related=via,
        )
    else:
        findings.add(
            "G204",
            f"{instance.cls.__name__} has no {sides[0][:-1]} {end.port!r}",
            end.span,
            did_you_mean(end.port, names) or listing(names, sides[0]),
            related=via,
        )
    return None


def _settle_types(graph: Graph, findings: Findings) -> None:
    """Resolve ports of several types along the wires until nothing changes, then check every wire."""
    pending = True
    while pending:
        pending = False
        for instance in graph.instances:
            pending |= _settle_couples(instance)
        for wire in graph.data_wires:
            source, target = graph.instances[wire.source], graph.instances[wire.target]
            out, into = source.cls.fields[wire.source_field], target.cls.fields[wire.target_field]
            pending |= _settle(target, into, _known_type(source, out), widening=True)
            pending |= _settle(source, out, _known_type(target, into), widening=False)
    unknown = _tell_unsettled(graph, findings)
    checked: list[Wire] = []
    for wire in graph.data_wires:
        source, target = graph.instances[wire.source], graph.instances[wire.target]
        gives = _known_type(source, source.cls.fields[wire.source_field])
        takes = _known_type(target, target.cls.fields[wire.target_field])
        converter = types.conversion(gives, takes) if gives and takes else None
        if gives is None:
            if wire.source in unknown:
                continue
            span, name = wire.entry.source.span, wire.entry.source
            findings.add(
                "G213",
                f"the type of {name} cannot be told from its wires ({wire})",
                span,
                "set a value with its type",
                related=wire.entry.via,
            )
        elif takes is None or converter is None:
            legal = target.cls.fields[wire.target_field].type
            hint = "put a converter node between them" if gives.is_number else ""
            if gives.count == 3 and not gives.array and isinstance(legal, PortType) and legal.count == 1:
                hint = "take it apart with BreakVector3"
            findings.add(
                "G206",
                f"{wire.entry.source} is {_a(gives)}, {wire.entry.target} takes {_a(legal)}",
                wire.span,
                hint,
                related=wire.entry.via,
            )
        else:
            checked.append(
                Wire(wire.source, wire.source_field, wire.target, wire.target_field, converter, wire.entry, wire.order)
            )
    graph.data_wires = checked


def _tell_unsettled(graph: Graph, findings: Findings) -> set[int]:
    """Tell of inputs that nothing gives a type; the instances that lack one for a reason told elsewhere, and those behind."""
    wired, behind = _wired_ports(graph), dict[int, list[int]]()
    sources = {(wire.target, wire.target_field): wire.source for wire in graph.data_wires}
    unknown: set[int] = set()
    for instance in graph.instances:
        for port in instance.cls.fields.values():
            if not isinstance(port.type, UnionType) or port.side != "inputs" or port.field in instance.settled:
                continue
            source = sources.get((instance.index, port.field))
            if source is not None:
                behind.setdefault(source, []).append(instance.index)
                continue
            if port.required is True or port.field in instance.refused or (instance.id, port.name) in wired:
                unknown.add(instance.index)
                continue
            findings.add(
                "G213",
                f"the type of {instance.id}.{port.name} cannot be told: it has neither a wire nor a value",
                instance.span,
                f"wire it, or write {{type: {str(port.type).partition(' ')[0]}, value: …}}",
                related=instance.entry.via,
            )
    pending = list(unknown)
    while pending:
        for index in behind.pop(pending.pop(), ()):
            if index not in unknown:
                unknown.add(index)
                pending.append(index)
    return unknown


def _wired_ports(graph: Graph) -> set[tuple[str, str]]:
    """Node and name of the ports that the file wires at all, rightly or not."""
    return {(wire.target.node, wire.target.port) for wire in graph.flat.wires}


def _known_type(instance: Instance, port: Port) -> PortType | None:
    settled = instance.settled.get(port.field)
    if settled is not None:
        return settled
    return port.type if isinstance(port.type, PortType) else None


def _settle(instance: Instance, port: Port, other: PortType | None, *, widening: bool) -> bool:
    """Choose a union port's alternative by the type at the other end of a wire."""
    if other is None or other == types.ANY or not isinstance(port.type, UnionType) or port.field in instance.settled:
        return False
    exact = [a for a in port.type.alternatives if (a.base, a.count, a.array) == (other.base, other.count, other.array)]
    wider = [a for a in port.type.alternatives if types.conversion(other, a) is not None] if widening else []
    for chosen in (*exact, *wider):
        instance.settled[port.field] = chosen
        return True
    return False


def _settle_couples(instance: Instance) -> bool:
    """Carry a settled type over to the ports that are coupled with it."""
    ports, changed = instance.cls.fields.values(), False
    for port in ports:
        if not port.couple or (settled := instance.settled.get(port.field)) is None:
            continue
        for other in ports:
            if other.couple != port.couple or other.field in instance.settled or not isinstance(other.type, UnionType):
                continue
            if other.component == port.component:
                wanted: Iterable[PortType] = [settled]
            else:
                wanted = [a for a in other.type.alternatives if a.base == settled.base]
            match = next((a for a in wanted if a in other.type.alternatives), None)
            if match is not None:
                instance.settled[other.field] = match
                changed = True
    return changed


def settled_type(instance: Instance, port: Port) -> PortType | UnionType:
    """A port's type after resolution."""
    return _known_type(instance, port) or port.type


def _check_required(graph: Graph, findings: Findings) -> None:
    wired = _wired_ports(graph)
    for instance in graph.instances:
        groups: dict[str, list[Port]] = {}
        for port in instance.cls.fields.values():
            if port.side == "inputs" and port.required:
                groups.setdefault(port.field if port.required is True else str(port.required), []).append(port)
        for ports in groups.values():
            empty = [types.equal(getattr(instance.node, port.field), port.default) for port in ports]
            told = any(port.field in instance.refused for port in ports)
            if told or not all(empty) or any((instance.id, port.name) in wired for port in ports):
                continue
            names = " or ".join(repr(port.name) for port in ports)
            docs = "; ".join(f"{port.name}: {port.doc}" for port in ports if port.doc)
            findings.add(
                "G208",
                f"{instance.id} needs its input {names}",
                instance.span,
                "set it below `inputs:`, or wire it",
                docs,
                related=instance.entry.via,
            )


def _set_variables(graph: Graph, findings: Findings) -> None:
    document = graph.flat.loaded.document
    for name, spec in graph.flat.spec.variables.items():
        try:
            port_type = types.parse(spec.type)
            if isinstance(port_type, UnionType):
                raise ValueError(f"{spec.type!r} is not the type of a variable")
            graph.variables[name] = port_type.zero if spec.default is None else types.coerce(spec.default, port_type)
        except ValueError as error:
            span = document.span("variables", name, "type")
            findings.add("G211", f"variable {name!r}: {error}", span, "types are double, int, string, vectord[3], …")
        except TypeError as error:
            span = document.span("variables", name, "default")
            findings.add("G211", f"variable {name!r} is a {spec.type}: {error}, got {shown(spec.default)}", span)
