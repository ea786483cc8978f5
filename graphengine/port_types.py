"""Types of ports that take several, settled along the wires; and whether every wire's two ends fit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from graphengine import types
from graphengine.diagnostics import Findings
from graphengine.graph import Graph, Instance, Wire, known_type, wired_ports, with_article
from graphengine.node import Port
from graphengine.types import PortType, UnionType


def settle_types(graph: Graph, findings: Findings) -> None:
    """Resolve ports of several types along the wires until nothing changes, then check every wire."""
    contradicted: dict[int, str] = {}
    while _settle_forwards(graph, contradicted) or _settle_backwards(graph):
        pass
    for index, message in contradicted.items():
        instance = graph.instances[index]
        findings.add("G206", f"{instance.id}: {message}", instance.span, related=instance.entry.via)
    unknown = _tell_unsettled(graph, findings) | set(contradicted)
    checked: list[Wire] = []
    for wire in graph.data_wires:
        source, target = graph.instances[wire.source], graph.instances[wire.target]
        gives = known_type(source, source.cls.fields[wire.source_field])
        takes = known_type(target, target.cls.fields[wire.target_field])
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
            if legal == types.POINTER:
                hint = "a pointer takes a buffer, from a pointer of another node; arrays have inputs of their own"
            findings.add(
                "G206",
                f"{wire.entry.source} is {with_article(gives)}, {wire.entry.target} takes {with_article(legal)}",
                wire.span,
                hint,
                related=wire.entry.via,
            )
        else:
            checked.append(
                Wire(wire.source, wire.source_field, wire.target, wire.target_field, converter, wire.entry, wire.order)
            )
    graph.data_wires = checked


def _settle_forwards(graph: Graph, contradicted: dict[int, str]) -> bool:
    """Carry types along the wires and through the nodes, once; whether that settled anything."""
    changed = False
    for instance in graph.instances:
        changed |= _settle_couples(instance)
        if instance.index not in contradicted:
            try:
                changed |= _settle_what_follows(instance, graph.variable_types)
            except ValueError as error:
                contradicted[instance.index] = str(error)
    for wire in graph.data_wires:
        source, target = graph.instances[wire.source], graph.instances[wire.target]
        out, into = source.cls.fields[wire.source_field], target.cls.fields[wire.target_field]
        changed |= _settle(target, into, known_type(source, out), widening=True)
    return changed


def _settle_backwards(graph: Graph) -> bool:
    """Where nothing else tells what a port gives, it is what the other end of its wire takes."""
    for wire in graph.data_wires:
        source, target = graph.instances[wire.source], graph.instances[wire.target]
        out, into = source.cls.fields[wire.source_field], target.cls.fields[wire.target_field]
        if _settle(source, out, known_type(target, into), widening=False):
            return True
    return False


def _tell_unsettled(graph: Graph, findings: Findings) -> set[int]:
    """Tell of inputs that nothing gives a type; the instances that lack one for a reason told elsewhere, and those behind."""
    wired, behind = wired_ports(graph), dict[int, list[int]]()
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


def _settle_what_follows(instance: Instance, variables: Mapping[str, PortType]) -> bool:
    """Settle what the node itself concludes from the types that are known.

    Raises:
        ValueError: they do not go together.
    """
    fields, changed = instance.cls.fields, False
    known = {
        name: found for name, port in fields.items() if (found := known_type(instance, port)) not in (None, types.ANY)
    }
    for name, wanted in instance.node.resolve_types(known, variables).items():
        port = fields[name]
        if known.get(name) == wanted:
            continue
        open_type = port.type == types.ANY or (isinstance(port.type, UnionType) and wanted in port.type.alternatives)
        if not open_type or (name in known and not _restate(instance, port, wanted)):
            is_one = known.get(name, port.type)
            raise ValueError(f"{port.name} would be {with_article(wanted)}, and is {with_article(is_one)}")
        instance.settled[name] = wanted
        changed = True
    return changed


def _restate(instance: Instance, port: Port, wanted: PortType) -> bool:
    """Take a literal whose type was a guess for one of another type; whether that can be."""
    if port.field not in instance.literals:
        return False
    try:
        setattr(instance.node, port.field, types.coerce(getattr(instance.node, port.field), wanted))
    except (TypeError, ValueError):
        return False
    return True


def _counterpart(settled: PortType, port: Port, other: Port) -> PortType | None:
    """The alternative of a port that belongs to what another one of its couple was settled to."""
    assert isinstance(other.type, UnionType)
    if port.component != other.component:
        return next((a for a in other.type.alternatives if a.base == settled.base), None)
    if port.element != other.element:
        settled = replace(settled, array=port.element)
    return settled if settled in other.type.alternatives else None


def _settle_couples(instance: Instance) -> bool:
    """Carry a settled type over to the ports that are coupled with it."""
    ports, changed = instance.cls.fields.values(), False
    for port in ports:
        if not port.couple or (settled := instance.settled.get(port.field)) is None:
            continue
        for other in ports:
            if other.couple != port.couple or other.field in instance.settled or not isinstance(other.type, UnionType):
                continue
            match = _counterpart(settled, port, other)
            if match is not None:
                instance.settled[other.field] = match
                changed = True
    return changed
