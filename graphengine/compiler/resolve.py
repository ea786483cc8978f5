"""Resolves a flat graph: finds its node types and ports, sets values and resolves port types; errors become findings."""

from __future__ import annotations

from collections.abc import Sequence

from graphengine.compiler.every_gates import add_gates
from graphengine.compiler.graph import Graph, Instance, Wire, find_port, port_names
from graphengine.compiler.literals import Override, check_required, set_literals, set_overrides, set_variables
from graphengine.compiler.port_texts import brief
from graphengine.compiler.port_types import settle_types
from graphengine.compiler.registry import Registry
from graphengine.compiler.subgraph_expansion import FlatGraph, WireEnd, WireEntry
from graphengine.compiler.substitution import UNKNOWN
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import ContextError
from graphengine.format.wording import listing, similar
from graphengine.node.node_class import grown
from graphengine.node.port import Port
from graphengine.node.types import UnionType

_BEGINS = ("outputs", "state", "inputs")
"""Sides on which the first port of a wire is looked up, in this order."""
_ENDS = ("inputs", "state")


def resolve(
    flat: FlatGraph,
    name: str,
    prim_path: str,
    registry: Registry,
    findings: Findings,
    overrides: Sequence[Override] = (),
    *,
    recorded: bool = False,
) -> Graph:
    """Return the resolved graph: its instances with values and types, and its wires; parts with errors are left out.

    Args:
        flat: the graph file, with subgraphs expanded.
        name: name of the graph: `robot/graph`, or `graph` for a graph that belongs to no robot.
        prim_path: path of the graph's prim.
        registry: node types that the graph can use.
        findings: receives the errors.
        overrides: values from the command line; `used` is set for each one that matches an input.
        recorded: whether files and overrides come from a recording; then values out of range are only warnings.
    """
    graph = Graph(name, prim_path, flat)
    known = _instantiate(graph, registry, findings)
    set_literals(graph, findings, recorded=recorded)
    set_overrides(graph, graph.instances, overrides, findings, recorded=recorded)
    _connect(graph, known, findings)
    set_overrides(graph, add_gates(graph, findings), overrides, findings, recorded=recorded)
    set_variables(graph, findings)
    settle_types(graph, findings)
    check_required(graph, findings)
    graph.note_accesses()
    return graph


def _instantiate(graph: Graph, registry: Registry, findings: Findings) -> dict[str, Instance | None]:
    """Add an instance to the graph for each node; errors are added to `findings`.

    Returns:
        The instances by node id; None for a node with an error, so that its wires cause no further errors.
    """
    known: dict[str, Instance | None] = dict.fromkeys(graph.flat.unopened)
    wired: dict[str, list[str]] = {}
    ends = [end for wire in graph.flat.wires for end in (wire.source, wire.target)]
    for end in (*ends, *(end for _, end in graph.flat.declared)):
        wired.setdefault(end.node, []).append(end.port)
    for entry in graph.flat.nodes:
        if findings.full:
            break
        found = registry.find(entry.spec.type)
        known[entry.id] = None
        span = entry.span("type")
        if found is None:
            message = f"unknown node type {entry.spec.type!r}"
            findings.add("G201", message, span, registry.suggest(entry.spec.type, findings), related=entry.via)
            continue
        if found.old_name:
            message = f"{entry.spec.type!r} is a name from before Isaac Sim 4.5"
            findings.add("N101", message, span, f"its current name is {found.cls.type_name!r}")
        if found.cls.grows() and any(value is UNKNOWN for value in entry.spec.inputs.values()):
            continue  # its ports depend on a literal that is reported already
        try:
            cls = grown(found.cls, entry.spec.inputs, registry.definitions, wired.get(entry.id, ()))
        except ContextError as error:
            culprit = next((key for key, value in entry.spec.inputs.items() if value == error.value), None)
            place = entry.span("inputs", culprit) if culprit is not None else entry.span("inputs")
            findings.add(error.code, f"{entry.id}: {error.message}", place, *error.help, related=entry.via)
            continue
        except (TypeError, ValueError) as error:
            findings.add("G211", f"{entry.id}: {error}", entry.span("inputs"), related=entry.via)
            continue
        known[entry.id] = instance = Instance(len(graph.instances), entry.id, cls, entry)
        graph.instances.append(instance)
    return known


def _connect(graph: Graph, known: dict[str, Instance | None], findings: Findings) -> None:
    """Add the wires of the file to the graph; wires that have errors, or that the file repeats, are left out and reported.

    An error is: no such node or port, a wrong direction, execution at only one end, or a second wire into a data input.
    """
    taken: dict[tuple[int, str], Wire] = {}
    written: dict[tuple[int, str, int, str], Wire] = {}
    repeated: dict[int, tuple[Wire, list[WireEntry]]] = {}
    siblings: dict[str, list[str]] = {}
    for node in known:
        siblings.setdefault(node.rpartition("/")[0], []).append(node.rpartition("/")[2])
    for side, end in graph.flat.declared:
        _end(end, _BEGINS if side == "outputs" else _ENDS, known, siblings, WireEntry(end, end, end.span), findings)
    for order, entry in enumerate(graph.flat.wires):
        source = _end(entry.source, _BEGINS, known, siblings, entry, findings)
        target = _end(entry.target, _ENDS, known, siblings, entry, findings)
        if source is None or target is None:
            if findings.full:
                return
            continue
        (one, out), (other, into) = source, target
        wire = Wire(one.index, out.field, other.index, into.field, "", entry, order)
        first = written.setdefault(wire.ends, wire)
        if first is not wire:
            repeated.setdefault(first.order, (first, []))[1].append(entry)
            continue
        if out.is_exec != into.is_exec:
            what = "execution" if out.is_exec else f"a value ({brief(out.type)})"
            wants = "execution" if into.is_exec else f"a value ({brief(into.type)})"
            message = f"{entry.source} carries {what}, {entry.target} takes {wants}"
            findings.add("G206", message, entry.span, related=entry.via)
        elif out.is_exec and out.side == "inputs":
            message = f"{entry.source} is an execution input; a wire begins at an output"
            findings.add("G205", message, entry.source.span, related=entry.via)
        elif out.is_exec:
            graph.exec_wires.append(wire)
        elif (other.index, into.field) in taken:
            first = taken[other.index, into.field]
            message = f"{entry.target} has two wires; a data input takes one"
            remedy = "remove one, or choose between the two values with a SelectIf node"
            findings.add("G207", message, entry.span, remedy, related=[(first.span, "the other one"), *entry.via])
        else:
            taken[other.index, into.field] = wire
            graph.data_wires.append(wire)
            if into.field in other.literals and not isinstance(into.type, UnionType):
                message = f"{entry.target} has a value and a wire; the wire wins"
                remedy = f"wired from {entry.source}; remove the value, or the wire"
                place = other.entry.key_span("inputs", other.literal_key(into))
                findings.add("W103", message, place, remedy, related=entry.via)
    _drop_repeated(graph, list(repeated.values()), findings)


def _drop_repeated(graph: Graph, repeated: Sequence[tuple[Wire, Sequence[WireEntry]]], findings: Findings) -> None:
    """Remove the repetitions of wires from the flat graph, with a warning; two ports are connected once, as in OmniGraph.

    Args:
        graph: graph that has the wires.
        repeated: each repeated wire, with its repetitions in the file.
        findings: receives the warnings.
    """
    for wire, again in repeated:
        times = f"{len(again) + 1} times" if len(again) > 1 else "twice"
        related = [(wire.span, "first here"), *again[0].via]
        findings.add("W108", f"{wire} is written {times}", again[0].span, "remove all but one", related=related)
    dropped = {id(entry) for _, again in repeated for entry in again}
    graph.flat.wires = [entry for entry in graph.flat.wires if id(entry) not in dropped]


def _end(
    end: WireEnd,
    sides: tuple[str, ...],
    known: dict[str, Instance | None],
    siblings: dict[str, list[str]],
    wire: WireEntry,
    findings: Findings,
) -> tuple[Instance, Port] | None:
    """Return the instance and port at one end of a wire; None after an error.

    Args:
        end: node id and port name of the end.
        sides: sides on which the port is looked up, in this order.
        known: instances by node id; None for a node with a reported error.
        siblings: names of the nodes of each subgraph, for suggestions.
        wire: the wire that has the end.
        findings: receives the error.
    """
    via = (*wire.via, *end.via)
    if end.node not in known:
        inner, _, name = end.node.rpartition("/")
        near = siblings.get(inner, [])
        guess = findings.guess(name, near)
        findings.add("G203", f"no node {name!r}", end.span, guess or listing(near, "nodes"), related=via)
        for sibling in similar(name, near) if guess and sides is _ENDS else ():
            meant = known[f"{inner}/{sibling}" if inner else sibling]
            port = find_port(meant.cls, end.port, _ENDS) if meant is not None else None
            if meant is not None and port is not None:
                meant.refused.add(port.field)
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
        message = f"{end} is an {wrong.side[:-1]}{', ' if said else '; '}{rule}"
        turn = f"write {wire.target} -> {wire.source}" if turned else ""
        legal = f"leave out `{end.side}:`" if said else listing(names, f"{sides[0]} of {instance.cls.__name__}")
        findings.add("G205", message, end.span, turn, legal, related=via)
    else:
        message = f"{instance.cls.__name__} has no {sides[0][:-1]} {end.port!r}"
        hint = findings.guess(end.port, names) or listing(names, sides[0])
        findings.add("G204", message, end.span, hint, related=via)
    if not begins:
        instance.note_misnamed(end.port, end.span)
    return None
