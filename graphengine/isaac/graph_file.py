"""Converts recorded graphs to the text of graph files, and reports the parts that cannot be converted."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graphengine.compiler.graph import find_port, port_names
from graphengine.compiler.registry import Registry
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.errors import ContextError
from graphengine.format.wording import listing, quoted
from graphengine.format.yaml_text import block, comment, flow, scalar
from graphengine.isaac.narrowing import narrow
from graphengine.isaac.node_replacements import GONE, modernize, replacement
from graphengine.isaac.recorded_graph import IMPULSE, RecordedGraph, RecordedNode, RecordedValue, RecordedWire
from graphengine.node import PortType, types
from graphengine.node.node_class import Node, grown
from graphengine.node.port import Port

WIDTH = 120
SCRIPT_NODE = "omni.graph.scriptnode.ScriptNode"

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
_PORT = re.compile(r"[A-Za-z_][A-Za-z0-9_:]*\Z")
_OMNIVERSE = re.compile(r"^\s*(?:import|from)\s+((?:omni|pxr|carb|isaacsim|usdrt)\b[\w.]*)", re.MULTILINE)
"""Matches the imports of Omniverse's modules in a script."""
_LONGEST_NAME = 200
"""Maximum length of an imported name, characters."""
_MOST_PARTS = 20
"""Maximum number of prim path elements in a file name."""
_MOST_FOLLOWED = 100_000
"""Maximum number of wires per graph that are followed upstream to find the outputs that fire an execution input."""


def file_names(graphs: Sequence[RecordedGraph]) -> list[str]:
    """Return a file name without suffix for each graph, from the end of its prim path. Names also differ if case is ignored."""
    taken: dict[str, int] = {}
    names = []
    for graph in graphs:
        parts = [_legal(part) for part in graph.path.strip("/").split("/")]
        choices = ["_".join(parts[-count:]) for count in range(1, min(len(parts), _MOST_PARTS) + 1)]
        names.append(unique(choices, taken))
    return names


def _legal(name: str) -> str:
    legal = re.sub(r"[^A-Za-z0-9_]", "_", name)[:_LONGEST_NAME]
    return legal if _NAME.match(legal) else f"_{legal}"


def unique(choices: Sequence[str], taken: dict[str, int], *, fold: bool = True) -> str:
    """Return the first choice that is not taken, or else the last choice with a number appended; mark the name as taken.

    Args:
        choices: names in order of preference.
        taken: names in use, each with the first number to try when this name is requested again; updated by this function.
        fold: whether names that differ only in case count as equal; the keys of `taken` are then lower case.
    """
    key = str.lower if fold else str
    name = next((choice for choice in choices if key(choice) not in taken), choices[-1])
    if key(name) in taken:
        number = next(n for n in itertools.count(taken[key(name)]) if key(f"{name}_{n}") not in taken)
        taken[key(name)], name = number + 1, f"{name}_{number}"
    taken[key(name)] = 2
    return name


def compose(
    graph: RecordedGraph, name: str, registry: Registry, findings: Findings, origin: str, robot: str = ""
) -> str:
    """Return the text of a graph file.

    Args:
        graph: recorded graph; its nodes and wires are changed during the conversion.
        name: name of the graph in the file.
        registry: registry of the available node types.
        findings: receives a finding for each part that is left out of the file or changed.
        origin: text after "Imported from" in the first line of the file.
        robot: default of the parameter `robot`, to which the graph refers after `use_parameter`; empty for a file without it.
    """
    return "\n".join([*_Composer(graph, registry, findings).lines(name, origin, robot), ""])


class _Composer:
    def __init__(self, graph: RecordedGraph, registry: Registry, findings: Findings) -> None:
        self.graph, self.registry, self.findings = graph, registry, findings
        self.names: dict[str, str] = {}
        """Node names in the file, by node name in the recorded graph."""
        self.classes: dict[str, type[Node] | None] = {}
        """Node classes, including the ports that the graph adds, by node name in the graph; None for an unavailable type."""
        self.wired: dict[str, set[str]] = {}
        """Full names of the wired ports, by node name in the graph."""
        self.driving: dict[tuple[str, str], list[RecordedWire]] = {}
        """Wires by their target: node name and full port name."""
        self.followed = 0
        for wire in graph.wires:
            for end, port in wire.ends:
                self.wired.setdefault(end, set()).add(port)
            self.driving.setdefault(wire.ends[1], []).append(wire)
        taken: dict[str, int] = {}
        for node in graph.nodes.values():
            if not node.type:
                findings.add("W302", f"the node {graph.path}/{node.name} is left out: it has no type", node.span)
                continue
            modernize(node, registry, findings)
            self.names[node.name] = legal = unique([_legal(node.name)], taken, fold=False)
            if legal != node.name:
                findings.add("N301", f"node {node.name!r} is named {legal!r} in the file", node.span)
            self.classes[node.name] = self._class(node)
        for node in narrow(graph, self.classes, findings):
            self.names[node.name] = unique([_legal(node.name)], taken, fold=False)
            self.classes[node.name] = self._class(node)

    def _class(self, node: RecordedNode) -> type[Node] | None:
        found = self.registry.find(node.type)
        if found is None:
            what = f"{node.name}: the node type {node.type!r} is not available"
            advice = replacement(node.type) or self.registry.suggest(node.type, self.findings)
            self.findings.add("W301", what, node.span, advice, "`graphrun check` reports this node again")
            return None
        if found.old_name:
            what = f"the node type name {node.type!r} is from before Isaac Sim 4.5"
            self.findings.add("N101", what, node.span, f"its current name is {found.cls.type_name!r}")
        named = [*self.wired.get(node.name, ()), *node.attributes]
        if found.cls.type_name == SCRIPT_NODE:
            self._check_script(node)
        if found.cls.type_name == SCRIPT_NODE and node.attributes:
            declared = [
                text for text in map(" ".join, node.attributes.items()) if self._declares(node, found.cls, text)
            ]
            node.values["inputs:attributes"] = RecordedValue(declared, span=node.span)
        values = {_port_name(key): value.data for key, value in node.values.items()}
        try:
            return grown(found.cls, values, self.registry.definitions, [_port_name(name) for name in named])
        except (ContextError, TypeError, ValueError):  # `graphrun check` reports the error in the file
            return None

    def _check_script(self, node: RecordedNode) -> None:
        """Report modules of Omniverse that a script node imports; they do not exist when the graph runs."""
        script = node.values.get("inputs:script", RecordedValue(""))
        modules = dict.fromkeys(_OMNIVERSE.findall(script.data)) if isinstance(script.data, str) else ()
        if modules:
            what = f"{node.name}: its script imports {', '.join(modules)}, which do not exist in graphengine"
            advice = "set execution outputs to True instead of og.ExecutionAttributeState.ENABLED"
            self.findings.add("W302", what, script.span or node.span, "change the script", advice)

    def _declares(self, node: RecordedNode, script_node: type[Node], text: str) -> bool:
        """Return whether a script node can have the attribute that `text` declares; if not, report that it is left out."""
        try:
            grown(script_node, {"attributes": [text]}, self.registry.definitions)
        except ValueError as error:
            self._leave_out(f"an attribute of {node.name}: {error}", node.span)
            return False
        return True

    def lines(self, name: str, origin: str, robot: str) -> Iterator[str]:
        """Yield the lines of the graph file; the default of its parameter `robot` is `robot`, unless that is empty."""
        graph = self.graph
        yield comment(f"Imported from {origin}")
        yield "format: 1"
        yield f"graph: {name}"
        yield f"at: {flow(graph.path)}"
        if robot:
            yield "parameters:"
            yield f"  robot: {flow({'type': 'target', 'default': robot})}"
        yield from self._when()
        if graph.variables:
            yield "variables:"
            for key, variable in graph.variables.items():
                yield from self._variable(key, variable)
        yield "nodes:" if self.names else "nodes: {}"
        for name in self.names:
            yield from self._node(graph.nodes[name])
        driven = dict.fromkeys(wire for known in graph.wires for wire in self._driven(known))
        wires = [line for wire in driven if (line := self._wire(wire))]
        if wires:
            yield "connections:"
            yield from (f"  - {line}" for line in wires)
        at = {key: graph.nodes[name].position for name, key in self.names.items()}
        placed = {key: position for key, position in at.items() if position and math.isfinite(sum(position))}
        if placed:
            yield "layout:"
            yield from (f"  {key}: {flow(position)}" for key, position in placed.items())

    def _when(self) -> Iterator[str]:
        """Yield the lines `runs:` and `evaluator:`; report a pipeline stage or evaluator that a graph file cannot express."""
        graph = self.graph
        physics = any(node.type.rpartition(".")[2] == "OnPhysicsStep" for node in graph.nodes.values())
        if graph.pipeline_stage == "on_demand" and physics:
            yield "runs: physics_step"
        elif graph.pipeline_stage == "on_demand":
            self._leave_out("the evaluation on demand by a script; the graph runs every tick", graph.span)
        elif graph.pipeline_stage != "simulation":
            self._leave_out(f"the pipeline stage {graph.pipeline_stage}; the graph runs every tick", graph.span)
        if graph.evaluator != "execution":
            yield "evaluator: push"
            advice = "if events are to decide which nodes are computed, set the evaluator to 'execution'"
            self.findings.add(
                "N301", f"{graph.path} is a push graph: every node is computed in every tick", graph.span, advice
            )
        if graph.evaluator == "dirty_push":
            self._leave_out("the evaluator dirty_push; every node is computed, not only changed ones", graph.span)

    def _leave_out(self, what: str, span: Span | None, *help: str) -> None:
        self.findings.add("W302", f"{self.graph.path}: not converted: {what}", span, *help)

    def _variable(self, name: str, variable: RecordedValue) -> Iterator[str]:
        if not _NAME.match(name):
            self._leave_out(f"variable {name!r}, whose name is not legal (letters, digits and _)", variable.span)
            return
        data: Any = variable.data
        try:
            port_type = types.parse(variable.type)
            data = fit(data, port_type) if isinstance(port_type, PortType) else data
        except ValueError:  # `graphrun check` reports the error in the file
            pass
        default = {"default": data} if data is not None else {}
        yield f"  {name}: {flow({'type': variable.type, **default})}"

    def _node(self, node: RecordedNode) -> Iterator[str]:
        cls = self.classes[node.name]
        found = self.registry.find(node.type)
        type_name = found.cls.type_name if found else node.type
        inputs: dict[str, Any] = {}
        for key, value in node.values.items():
            name = _port_name(key)
            if self._carried(node, cls, key, value):
                port = find_port(cls, name, ["inputs"]) if cls else None
                inputs[name] = _literal(value.data, value.type or node.attributes.get(key, ""), port)
        key = self.names[node.name]
        if not inputs:
            yield f"  {key}: {scalar(type_name)}"
            return
        yield f"  {key}:"
        yield f"    type: {scalar(type_name)}"
        line = f"    inputs: {flow(inputs)}"
        if len(line) <= WIDTH and not any(map(block, inputs.values())):
            yield line
            return
        yield "    inputs:"
        for name, data in inputs.items():
            first, *lines = block(data) or [flow(data)]
            yield f"      {scalar(name)}: {first}"
            yield from (f"        {line}" if line else "" for line in lines)

    def _carried(self, node: RecordedNode, cls: type[Node] | None, key: str, value: RecordedValue) -> bool:
        """Return whether the graph file can contain an attribute value of a node; if not, report why the value is left out."""
        name = _port_name(key)
        what, advice = "", ""
        if not key.startswith("inputs:"):
            what = "a graph file contains values of inputs only"
            advice = f"at run time: graphrun ctl impulse {quoted(self.names[node.name])}" if key == IMPULSE else ""
        elif value.data is None or not _PORT.match(name):
            what = "it is None" if value.data is None else "it is not a legal port name"
        elif cls is not None:
            port = find_port(cls, name, ["inputs"])
            if port is None:
                inputs = port_names(cls, "inputs")
                what = f"{cls.__name__} has no such input"
                advice = GONE.get(f"{cls.type_name}.{name}") or self.findings.guess(name, inputs)
                advice = advice or listing(inputs, "inputs")
            elif port.is_exec:
                return False  # scripts also write execution states to these ports
        if what:
            self._leave_out(f"the value of {node.name}.{key}: {what}", value.span or node.span, advice)
        return not what

    def _driven(self, wire: RecordedWire) -> Iterator[RecordedWire]:
        """Yield the wire itself or, if its source is an execution input, one wire from each output that fires this input."""
        ends = [(self.classes.get(node), _port_name(key)) for node, key in wire.ends]
        ports = [find_port(cls, name, ["inputs"]) for cls, name in ends if cls is not None]
        if not wire.source_port.startswith("inputs:") or not any(port is not None and port.is_exec for port in ports):
            yield wire
            return
        pending, reached, driven = [wire.ends[0]], {wire.ends[0]}, False
        for known in (known for end in pending for known in self.driving.get(end, ())):
            self.followed += 1
            if self.followed > _MOST_FOLLOWED:
                break
            if not known.source_port.startswith("inputs:"):
                driven = True
                yield replace(wire, source=known.source, source_port=known.source_port)
            elif known.ends[0] not in reached:
                reached.add(known.ends[0])
                pending.append(known.ends[0])
        many = self.followed > _MOST_FOLLOWED
        if many or not driven:
            why = f"more than {_MOST_FOLLOWED} wires lead to" if many else "no output fires"
            self._leave_out(f"the wire {wire}: {why} {wire.source}.{wire.source_port}", wire.span)

    def _wire(self, wire: RecordedWire) -> str:
        """Return a wire as text for the file; report a wire whose node or port does not exist, and return an empty string."""
        ends = (wire.source, wire.source_port, ("outputs", "inputs")), (wire.target, wire.target_port, ("inputs",))
        written = []
        for node, key, sides in ends:
            side, name = key.partition(":")[0], _port_name(key)
            if node not in self.names:
                self._leave_out(f"the wire {wire}: there is no node {node!r}", wire.span)
                return ""
            cls = self.classes[node]
            if not _PORT.match(name) or (cls is not None and f"{side}:{name}" not in cls.ports):
                legal = port_names(cls, side) if cls is not None else []
                gone = GONE.get(f"{cls.type_name}.{name}") if cls is not None else None
                near = gone or self.findings.guess(name, legal) or listing(legal, side)
                self._leave_out(f"the wire {wire}: {cls.__name__ if cls else node} has no {key}", wire.span, near)
                return ""
            meant = next((s for s in sides if cls is not None and f"{s}:{name}" in cls.ports), sides[0])
            written.append(f"{self.names[node]}.{name if meant == side else f'{side}:{name}'}")
        return " -> ".join(written)


def _port_name(key: str) -> str:
    """Return an attribute name without its side: `wheelRadius` for `inputs:wheelRadius`."""
    side, colon, name = key.partition(":")
    return name if colon and side in ("inputs", "outputs", "state") else key


def _literal(data: Any, type: str, port: Port | None) -> Any:
    """Return a value as written in a graph file: for a union or `any` port, `{type: …, value: …}` if the type is known."""
    if port is None:
        return data
    if isinstance(port.type, PortType) and port.type != types.ANY:
        return fit(data, port.type)
    try:
        given = types.parse(type)
    except ValueError:
        return data
    return {"type": type, "value": fit(data, given)} if isinstance(given, PortType) else data


def fit(data: Any, port_type: PortType) -> Any:
    """Return a number, or a list of numbers, in the Python type of the port if no information is lost: 1.0 as 1, 1 as True."""
    if isinstance(data, list):
        element = PortType(port_type.base, port_type.count, False, port_type.role)
        return [fit(item, element) for item in data]
    if port_type.base == "bool" and data in (0, 1):
        return bool(data)
    whole = port_type.is_number and np.dtype(port_type.dtype).kind in "iu"
    if isinstance(data, float) and data.is_integer() and whole:
        return int(data)
    return data
