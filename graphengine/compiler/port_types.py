"""Resolves the types of union and `any` ports along the wires, and checks the types at both ends of every wire."""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from dataclasses import replace

from graphengine.compiler.digraph import Digraph, reached
from graphengine.compiler.graph import Graph, Instance, Wire, known_type, visible
from graphengine.compiler.port_texts import with_article
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import ContextError
from graphengine.node import PortType, UnionType, types
from graphengine.node.node_class import Node
from graphengine.node.port import Port

_TUPLES = ("double", "float", "half", "int")
"""Base types for which a node such as ToFloat converts tuples too."""
_SCALARS = (*_TUPLES, "bool", "int64", "uchar", "uint", "uint64")
"""Base types for which a node such as ToBool converts numbers."""
_BETWEEN = {("token", "string"): "ToString", ("string", "token"): "ToToken"}
"""For two string types: the node type that converts from the first to the second."""


def settle_types(graph: Graph, findings: Findings) -> None:
    """Resolve the types of union and `any` ports, then check every data wire and set its converter.

    Errors are added to `findings`, and wires with errors are removed from the graph.
    """
    refused = _settle(graph)
    for index, error in refused.items():
        if not graph.instances[index].refused:  # otherwise the error may result from one that is already reported
            _tell_refusal(graph.instances[index], error, findings)
    unknown = _tell_unsettled(graph, findings, set(refused))
    checked: list[Wire] = []
    untold: list[Wire] = []
    for wire in graph.data_wires:
        source, into = graph.source(wire)[0], graph.target(wire)[1]
        gives, takes = known_type(*graph.source(wire)), known_type(*graph.target(wire))
        converter = types.conversion(gives, takes) if gives and takes else None
        told = wire.source in unknown or source.settled.get(wire.source_field) == types.ANY
        if told and (gives is None or gives == types.ANY != takes):
            continue
        if gives is None:
            untold.append(wire)
        elif gives == types.ANY != takes and source.cls.resolve_types is not Node.resolve_types:
            message = (
                f"the type of {wire.entry.source} cannot be resolved, because the input that determines it is wired"
            )
            remedy = f"remove the wire into that input of {source.id}, and set the input below `inputs:`"
            findings.add("G213", message, wire.entry.source.span, remedy, related=wire.entry.via)
        elif takes is None or converter is None:
            legal = takes or into.type
            hint = _number_hint(gives, legal) if gives.is_number else ""
            if isinstance(legal, PortType) and (gives.base, legal.base) in _BETWEEN and not gives.array:
                hint = f"put {_BETWEEN[gives.base, legal.base]} between them"
            if gives.count == 3 and not gives.array and isinstance(legal, PortType) and legal.count == 1:
                hint = "split it with BreakVector3"
            if legal == types.POINTER:
                hint = "wire the pointer output of another node; arrays go into array inputs"
            message = f"{wire.entry.source} is {with_article(gives)}, {wire.entry.target} takes {with_article(legal)}"
            findings.add("G206", message, wire.span, hint, related=wire.entry.via)
        else:
            checked.append(replace(wire, converter=converter))
    graph.data_wires = checked + _tell_untold(graph, untold, findings)


def _number_hint(gives: PortType, legal: object) -> str:
    """Return the remedy for a wire from a number or an array of numbers to an input that takes another type."""
    if isinstance(legal, PortType) and gives.array and legal.is_number and not legal.array:
        return "take an element of the array with ArrayIndex"
    if isinstance(legal, PortType) and (gives.count, gives.array) == (legal.count, legal.array):
        convertible = _SCALARS if legal.count == 1 else _TUPLES
        if gives.base in convertible and legal.base in convertible and gives != types.POINTER:
            return f"put To{legal.base.capitalize()} between them"
    return "put a converter node between them"


def _tell_untold(graph: Graph, untold: list[Wire], findings: Findings) -> list[Wire]:
    """Add an error for each wire of unknown type, except wires from a cycle of data nodes.

    Returns:
        The wires from cycles, for which the planner reports the cycle.
    """
    circular = _circular(graph) if untold else set()
    for wire in (wire for wire in untold if wire.source not in circular):
        what = f"the type of {wire.entry.source} cannot be resolved from its wires ({wire})"
        remedy = "write an input of the node as {type: …, value: …}"
        findings.add("G213", what, wire.entry.source.span, remedy, related=wire.entry.via)
    return [wire for wire in untold if wire.source in circular]


def _circular(graph: Graph) -> set[int]:
    """Return the data nodes in a cycle of data nodes and downstream of one; their types cannot be resolved."""
    waiting = Digraph(range(len(graph.instances)))
    for wire in graph.data_wires:
        source, target = graph.instances[wire.source].cls, graph.instances[wire.target].cls
        if source.kind() == target.kind() == "data" and source.fields[wire.source_field].side == "outputs":
            waiting.add_edge(wire.source, wire.target)
    return waiting.successors.keys() - waiting.sort()


def _tell_refusal(instance: Instance, error: ValueError | ContextError, findings: Findings) -> None:
    """Add an error for a node whose `resolve_types` failed: port types are incompatible, or an input has an invalid value."""
    if isinstance(error, ValueError):
        findings.add("G206", f"{instance.id}: {error}", instance.span, related=instance.entry.via)
        return
    findings.put(instance.refusal(error))
    instance.refused.add(instance.asking(error.value)[0])


def _settle(graph: Graph) -> dict[int, ValueError | ContextError]:
    """Propagate port types through nodes and along wires; return a dict from indices of nodes to errors of their `resolve_types`.

    Each round visits the nodes that the previous round changed. When no node changes any more, types go backwards: the output of
    the first wire without a type gets the type of the input at the wire's end, and the rounds continue.
    """
    refused: dict[int, ValueError | ContextError] = {}
    instances, wires = graph.instances, graph.data_wires
    _settle_defaults(graph)
    out_of, into = dict[int, list[int]](), dict[int, list[int]]()
    for number, wire in enumerate(wires):
        out_of.setdefault(wire.source, []).append(number)
        into.setdefault(wire.target, []).append(number)
    changed, backwards = set(range(len(instances))), list[int]()
    while changed or backwards:
        if not changed:
            wire = wires[heapq.heappop(backwards)]
            if _settle_source(graph, wire):
                changed = {wire.source}
            continue
        for index in changed:
            for number in into.get(index, ()):
                heapq.heappush(backwards, number)
        looked_at, changed = sorted(changed), set()
        changed.update(index for index in looked_at if _settle_node(graph, instances[index], refused))
        onwards = sorted(number for index in looked_at for number in out_of.get(index, ()))
        changed.update(wires[number].target for number in onwards if _settle_target(graph, wires[number]))
    return refused


def _settle_defaults(graph: Graph) -> None:
    """Give each unwired union input without a literal the first type that accepts its default value."""
    given = graph.wired_ports | graph.declared_inputs
    for instance in graph.instances:
        for port in instance.cls.fields.values():
            kept = port.field not in instance.literals and (instance.id, port.name) not in given
            if kept and isinstance(port.type, UnionType) and port.side == "inputs" and port.default is not None:
                instance.settled[port.field], _ = types.first_that_takes(port.default, port.type.alternatives)


def _settle_node(graph: Graph, instance: Instance, refused: dict[int, ValueError | ContextError]) -> bool:
    """Resolve ports of a node whose types follow from its known port types; return whether a type changed.

    An error of `resolve_types` is added to `refused`, by index of the node.
    """
    changed = _settle_couples(instance)
    if instance.index in refused or instance.cls.resolve_types is Node.resolve_types:
        return changed
    try:
        return _settle_derived(instance, visible(instance.id, graph.variable_types)) or changed
    except (ValueError, ContextError) as error:
        refused[instance.index] = error
        return changed


def _settle_target(graph: Graph, wire: Wire) -> bool:
    return _choose(*graph.target(wire), known_type(*graph.source(wire)), widening=True)


def _settle_source(graph: Graph, wire: Wire) -> bool:
    source, out = graph.source(wire)
    takes = known_type(*graph.target(wire))
    if takes == types.ANY and isinstance(out.type, UnionType) and not _depends_on_inputs(source):
        takes = out.type.alternatives[0]
    return _choose(source, out, takes, widening=False)


def _depends_on_inputs(instance: Instance) -> bool:
    """Return whether a node has union inputs, from which the types of its outputs may follow."""
    return any(port.side == "inputs" and isinstance(port.type, UnionType) for port in instance.cls.fields.values())


def _tell_unsettled(graph: Graph, findings: Findings, refusing: set[int]) -> set[int]:
    """Add an error for each input whose type cannot be resolved.

    Returns:
        The indices of all nodes with unresolved types: nodes in `refusing`, nodes with such inputs or with inputs that lack a
        value, and all nodes downstream of these.
    """
    wired, declared, behind = graph.wired_ports, graph.declared_inputs, dict[int, list[int]]()
    wires = {(wire.target, wire.target_field): wire for wire in graph.data_wires}
    unknown = set(refusing)
    for instance in graph.instances:
        for port in instance.cls.fields.values():
            if port.side == "inputs" and _misses(instance, port, wired):
                unknown.add(instance.index)
            if not isinstance(port.type, UnionType) or port.side != "inputs" or port.field in instance.settled:
                continue
            wire = wires.get((instance.index, port.field))
            if wire is not None:
                behind.setdefault(wire.source, []).append(instance.index)
                if known_type(*graph.source(wire)) is not None:  # its type does not fit the input
                    unknown.add(instance.index)
                continue
            if (instance.id, port.name) in declared:
                graph.left_open[f"{instance.id}.{port.name}"] = None
            elif instance.index not in unknown and (instance.id, port.name) not in wired:
                message = f"the type of {instance.id}.{port.name} cannot be resolved: it has neither a wire nor a value"
                remedy = f"wire it, or write {{type: {str(port.type).partition(' ')[0]}, value: …}}"
                findings.add("G213", message, instance.span, remedy, related=instance.entry.via)
                continue
            unknown.add(instance.index)
    return set(reached(unknown, lambda index: behind.get(index, ())))


def _misses(instance: Instance, port: Port, wired: set[tuple[str, str]]) -> bool:
    """Return whether an input lacks a value because of an error that is reported elsewhere."""
    if port.field in instance.refused:
        return True
    return port.required is True and port.field not in instance.literals and (instance.id, port.name) not in wired


def _choose(instance: Instance, port: Port, other: PortType | None, *, widening: bool) -> bool:
    """Resolve a union port to the alternative that fits the type at the other end of a wire; return whether one fits.

    Args:
        instance: node that has the port.
        port: port to resolve; ports of other types and resolved ports stay as they are.
        other: type at the other end of the wire; None if it is unknown.
        widening: whether an alternative also fits if `other` can be converted to it; otherwise only an equal type fits.
    """
    if other is None or other == types.ANY or not isinstance(port.type, UnionType) or port.field in instance.settled:
        return False
    form = (other.base, other.count, other.array)
    chosen = next((a for a in port.type.alternatives if (a.base, a.count, a.array) == form), None)
    if chosen is None and widening:
        chosen = next((a for a in port.type.alternatives if types.conversion(other, a) is not None), None)
    if chosen is None:
        return False
    instance.settled[port.field] = chosen
    return True


def _settle_derived(instance: Instance, variables: Mapping[str, PortType]) -> bool:
    """Set the port types that `resolve_types` of the node class derives from known types; return whether a type changed.

    Raises:
        ValueError: the port types are incompatible.
        ContextError: an input that determines the types has an invalid value.
    """
    fields, changed = instance.cls.fields, False
    known = {
        name: found for name, port in fields.items() if (found := known_type(instance, port)) not in (None, types.ANY)
    }
    for name, wanted in instance.make_node().resolve_types(known, variables).items():
        port = fields[name]
        if known.get(name) == wanted or instance.settled.get(name) == wanted:
            continue
        open_type = port.type == types.ANY or (isinstance(port.type, UnionType) and wanted in port.type.alternatives)
        if not open_type or (name in known and not _restate(instance, port, wanted)):
            is_one = known.get(name, port.type)
            raise ValueError(f"{port.name} must be {with_article(wanted)}, but it is {with_article(is_one)}")
        instance.settled[name] = wanted
        changed = True
    return changed


def _restate(instance: Instance, port: Port, wanted: PortType) -> bool:
    """Convert the literal of an input to the type `wanted`; return whether the input has a literal that can be converted."""
    if port.field not in instance.literals:
        return False
    try:
        instance.literals[port.field] = types.coerce(instance.literals[port.field], wanted)
    except (TypeError, ValueError):
        return False
    return True


def _counterpart(settled: PortType, port: Port, other: Port) -> PortType | None:
    """Return the alternative of the port `other` that corresponds to the resolved type of the coupled port `port`.

    Args:
        settled: resolved type of `port`.
        port: port with a resolved type.
        other: union port, coupled with `port`.

    Returns:
        The alternative; None if `other` has no corresponding one.
    """
    assert isinstance(other.type, UnionType)
    if port.component != other.component:
        form = (settled.base, settled.array)
        return next((a for a in other.type.alternatives if (a.base, a.array) == form), None)
    if port.element != other.element:
        settled = replace(settled, array=port.element)
    return settled if settled in other.type.alternatives else None


def _settle_couples(instance: Instance) -> bool:
    """Resolve the ports of a node that are coupled with a resolved port; return whether a type changed."""
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
