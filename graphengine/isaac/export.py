"""Exports a graph as a script that builds it in Isaac Sim with one `og.Controller.edit`.

Subgraphs are expanded and parameters are replaced by their values, because scripts have neither. A part without a counterpart in
Isaac Sim becomes a comment at its place in the script.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from graphengine.compiler.every_gates import EveryHz, EveryOnce, EveryTicks
from graphengine.compiler.graph import Graph, Instance, Wire
from graphengine.compiler.port_texts import listed
from graphengine.format.diagnostics import Findings
from graphengine.format.templates import filled
from graphengine.isaac.graph_file import SCRIPT_NODE, unique
from graphengine.node import PortType, UnionType, types
from graphengine.node.port import ExecOut, Port

OWN = "graphengine."
"""Prefix of the names of graphengine's own node types, which Isaac Sim does not have."""
GATES = {
    EveryTicks.type_name: ("isaacsim.core.nodes.IsaacSimulationGate", "execOut"),
    EveryHz.type_name: ("isaacsim.core.nodes.IsaacSimulationGate", "execOut"),
    EveryOnce.type_name: ("isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame", "step"),
}
"""Isaac Sim's node type, and the name of its execution output, by the type name of graphengine's `every:` gate."""
_MESSAGE = ("messagePackage", "messageSubfolder", "messageName")
"""Inputs of generic ROS nodes that select the message type, for whose fields Isaac Sim then creates ports."""
TICK_RATE = 60
"""Default tick rate of scenes and of Isaac Sim, Hz."""


def write_script(graph: Graph, findings: Findings, *, strict: bool = False) -> str:
    """Return the script as text; parts without a counterpart in Isaac Sim are comments in it.

    Args:
        graph: resolved graph without errors.
        findings: receives a warning for each part without a counterpart in Isaac Sim.
        strict: whether each of these parts is an error; the script is then an empty string.
    """
    before = len(findings.errors)
    exporter = _Exporter(graph, findings, "G402" if strict else "W303")
    return "" if len(findings.errors) > before else exporter.script()


class _Exporter:
    def __init__(self, graph: Graph, findings: Findings, code: str) -> None:
        self.graph, self.findings, self.code = graph, findings, code
        self.names = _names([instance.id for instance in graph.instances])
        self.lost: dict[tuple[int, str], str] = {}
        """Why a node or port is left out, by index of the node and field of the port; the field is empty for the whole node."""
        for instance in graph.instances:
            if not instance.part_of:
                self._check(instance)
        lost = {graph.instances[index].id for index, field in self.lost if not field}
        self.lost |= {(gate.index, ""): "" for gate in graph.instances if gate.part_of in lost}
        self.starved = self._find_starved()
        self.into: dict[int, list[Wire]] = {}
        """Execution wires by the index of their target."""
        for wire in graph.exec_wires:
            self.into.setdefault(wire.target, []).append(wire)

    def _check(self, instance: Instance) -> None:
        """Report what Isaac Sim lacks for a node: its type, a gate with a rate in Hz, and ports that are wired or set."""
        if instance.cls.type_name.startswith(OWN):
            self._tell(instance, "", f"Isaac Sim has no node type {instance.cls.type_name}")
        every = instance.entry.spec.every
        if every is not None and every.hz is not None:
            ticks = _ticks(every.hz)
            counted = f"which at {TICK_RATE} ticks a second is {TICK_RATE / ticks:g} Hz"
            advice = f"write `every: {{ticks: {ticks}}}`, {counted}"
            what = f"{instance.id}: `every` has a rate in Hz, but the gates of Isaac Sim count ticks"
            does = "" if self.code == "G402" else f"; the script counts {ticks} ticks"
            self.findings.add(self.code, what + does, instance.span, advice, related=instance.entry.via)
        wires = [*self.graph.data_wires, *self.graph.exec_wires]
        used = instance.literals.keys() | {wire.target_field for wire in wires if wire.target == instance.index}
        used |= {wire.source_field for wire in wires if wire.source == instance.index}
        for field in sorted(used):
            port = instance.cls.fields[field]
            if port.extension and not (instance.cls.type_name == SCRIPT_NODE and port.name == "attributes"):
                self._tell(instance, field, f"{instance.cls.type_name} has no {port.side}:{port.name} in Isaac Sim")

    def _tell(self, instance: Instance, field: str, what: str) -> None:
        self.lost[instance.index, field] = what
        does = "" if self.code == "G402" else "; it is left out of the script"
        self.findings.add(self.code, f"{instance.id}: {what}{does}", instance.span, related=instance.entry.via)

    def _item(self, code: str, index: int, field: str = "", *more: tuple[int, str]) -> str:
        """Return a line of the script with an item of an edit, or a comment if its node or one of its ports is left out."""
        ends = ((index, field), *more)
        why = next((self.lost[end] for end in ends if end in self.lost), "")
        left = why or any((end[0], "") in self.lost for end in ends)
        return f"# left out: {code}{f': {why}' if why else ''}" if left else f"{code},"

    def _find_starved(self) -> set[int]:
        """Return the nodes that are left out, and the nodes that read data of such nodes."""
        readers: dict[int, list[int]] = {}
        for wire in self.graph.data_wires:
            readers.setdefault(wire.source, []).append(wire.target)
        lost = pending = [index for index, field in self.lost if not field]
        found = set(lost)
        while pending:
            more = {reader for index in pending for reader in readers.get(index, ())} - found
            found |= more
            pending = [index for index in more if self.graph.instances[index].cls.kind() == "data"]
        return found

    def _bridged(self, wire: Wire) -> Iterator[Wire]:
        """Yield the wires that replace a wire from a node that is left out, so that its target is still executed.

        They begin at the outputs that execute this node. There are none if the target needs data of nodes that are left out, or
        if the node does not fire at each execution.
        """
        pending, seen = [wire.source] if wire.target not in self.starved else [], set[int]()
        while pending:
            source = self.graph.instances[pending.pop(0)]
            if source.index in seen or source.cls.gated or source.cls.kind() != "action":
                continue
            seen.add(source.index)
            for before in self.into.get(source.index, ()):
                if (before.source, "") in self.lost:
                    pending.append(before.source)
                elif not source.cls.fields[before.target_field].control:
                    yield replace(wire, source=before.source, source_field=before.source_field)

    def script(self) -> str:
        """Return the text of the script."""
        graph, spec = self.graph, self.graph.flat.spec
        kept = {instance.id for instance in graph.instances if (instance.index, "") not in self.lost}
        layout = {self.names[name]: place for name, place in spec.layout.items() if name in kept}
        messages = list(self._values(of_messages=True))
        created = _block("CREATE_VARIABLES", self._variables()) + _block("CREATE_NODES", self._nodes())
        created += _block("CREATE_ATTRIBUTES", self._attributes()) + _block("SET_VALUES", messages)
        attribute = 'node.CreateAttribute("ui:nodegraph:node:pos", Sdf.ValueTypeNames.Float2)'
        places = (
            f'node = stage.GetPrimAtPath(f"{{GRAPH_PATH}}/{name}")\n{attribute}.Set(Gf.Vec2f({number(x)}, {number(y)}))'
            for name, (x, y) in layout.items()
        )
        return filled(
            Path(__file__).with_suffix(".txt"),
            {
                "doc": bool(spec.doc),
                "placed": bool(layout),
                "targets": self._targets(),
                "steps": graph.runs == "physics_step",
                "messages": bool(messages),
            },
            doc=_docstring(spec.doc),
            path=text(graph.prim_path),
            evaluator=text(spec.evaluator),
            created=f"\n{created}".removesuffix("\n"),
            wired=_block("CONNECT", self._wires()) + _block("SET_VALUES", self._values(of_messages=False)),
            places="\n".join(places),
        )

    def _variables(self) -> Iterator[str]:
        for name, value in self.graph.variables.items():
            port_type = self.graph.variable_types[name]
            yield f"({text(name)}, {text(str(port_type))}, {literal(value, port_type)}),"

    def _nodes(self) -> Iterator[str]:
        for instance in self.graph.instances:
            type_name = GATES[instance.cls.type_name][0] if instance.part_of else instance.cls.type_name
            yield self._item(f"({text(self.names[instance.id])}, {text(type_name)})", instance.index)

    def _attributes(self) -> Iterator[str]:
        """Yield the Python code of a tuple `(attribute, type)` for each port that the script must add to a node."""
        for instance in self.graph.instances:
            fixed = _fixed_ports(instance)
            for key, port in instance.cls.ports.items():
                if key not in fixed:
                    settled = instance.settled.get(port.field, port.type)
                    name = "any" if isinstance(settled, UnionType) else str(settled)
                    yield self._item(f"({text(self._end(instance, port))}, {text(name)})", instance.index, port.field)
            for hole in _holes(instance):
                end = text(f"{self.names[instance.id]}.outputs:{hole}")
                yield self._item(f"({end}, {text('execution')})", instance.index)

    def _wires(self) -> Iterator[str]:
        for wire in sorted([*self.graph.data_wires, *self.graph.exec_wires], key=lambda wire: wire.order):
            yield self._wire(wire)
            if (wire.source, "") in self.lost and self.graph.source(wire)[1].is_exec:
                yield from map(self._wire, self._bridged(wire))

    def _wire(self, wire: Wire) -> str:
        start, end = self._end(*self.graph.source(wire)), self._end(*self.graph.target(wire))
        source, target = (wire.source, wire.source_field), (wire.target, wire.target_field)
        return self._item(f"({text(start)}, {text(end)})", *source, target)

    def _end(self, instance: Instance, port: Port) -> str:
        """Return the name that a script uses for a port, such as `Node.inputs:x`, or `Node.outputs_x` for a bundle output."""
        output = port.side == "outputs"
        name = GATES[instance.cls.type_name][1] if instance.part_of and output else port.name
        between = "_" if output and str(port.type) == "bundle" else ":"
        return f"{self.names[instance.id]}.{port.side}{between}{name}"

    def _values(self, *, of_messages: bool) -> Iterator[str]:
        """Yield the Python code of tuples `(attribute, value)` for inputs that select message types, or for all other inputs."""
        for instance in self.graph.instances:
            if issubclass(instance.cls, EveryTicks | EveryHz) and not of_messages:
                hz = instance.value("hz") if issubclass(instance.cls, EveryHz) else None
                ticks = _ticks(hz) if hz is not None else instance.value("ticks")
                item = self._item(f"({text(f'{self.names[instance.id]}.inputs:step')}, {ticks})", instance.index)
                yield item + (f"  # every: {{hz: {hz:g}}}" if hz is not None else "")
        for instance, port in self._literals():
            if (port.name in _MESSAGE) != of_messages:
                continue
            settled = instance.settled.get(port.field, port.type)
            value = instance.value(port.field)
            shown = literal(value, settled) if isinstance(settled, PortType) else plain(value)
            several = isinstance(port.type, UnionType) or port.type == types.ANY
            typed = f", {text(str(settled))}" if several and isinstance(settled, PortType) else ""
            yield self._item(f"({text(self._end(instance, port))}, {shown}{typed})", instance.index, port.field)

    def _literals(self) -> Iterator[tuple[Instance, Port]]:
        for instance in self.graph.instances:
            for port in instance.cls.fields.values():
                declares = instance.cls.type_name == SCRIPT_NODE and port.name == "attributes"
                if port.field in instance.literals and not declares and not instance.part_of:
                    yield instance, port

    def _targets(self) -> bool:
        variables = self.graph.variable_types.values()
        return any(port.type == types.TARGET for _, port in self._literals()) or types.TARGET in variables


def _ticks(hz: float) -> int:
    """Return the number of ticks, at `TICK_RATE`, between two executions at a rate in Hz."""
    return max(1, round(TICK_RATE / hz))


def _names(ids: Sequence[str]) -> dict[str, str]:
    """Return a unique Python identifier for each node ID: `Sub/Node` becomes `Sub_Node`, or `Sub_Node_2` if that is taken.

    The ID of an `every:` gate contains a dot between the ID of its node and a suffix; the dot also becomes `_`.
    """
    names: dict[str, str] = {}
    taken = {known: 2 for known in ids if known.isidentifier()}
    for full in ids:
        joined = full.replace("/", "_").replace(".", "_")
        names[full] = full if full.isidentifier() else unique([joined], taken, fold=False)
    return names


def _fixed_ports(instance: Instance) -> set[str]:
    """Return the keys of the ports that exist without `CREATE_ATTRIBUTES`, because the node type defines or creates them."""
    bases = [base for base in instance.cls.__mro__[1:] if getattr(base, "type_name", "") == instance.cls.type_name]
    grows = instance.cls.type_name == SCRIPT_NODE or instance.cls.numbered
    base: Any = bases[-1] if bases and grows else instance.cls
    return set(base.ports)


def _holes(instance: Instance) -> Iterator[str]:
    """Yield the execution outputs that close gaps in a numbered series, because OmniGraph ignores outputs after a gap."""
    for stem, make in instance.cls.numbered.items():
        numbers = {int(field.removeprefix(stem)) for field in instance.cls.series[stem]}
        if make is ExecOut and 0 in numbers:
            yield from (f"{stem}{number}" for number in range(max(numbers)) if number not in numbers)


def _block(key: str, items: Iterable[str]) -> str:
    """Return the lines of an entry of an edit, each with its line end; empty without items."""
    lines = "".join(f"            {item}\n" for item in items)
    return f"        keys.{key}: [\n{lines}        ],\n" if lines else ""


def literal(value: Any, port_type: PortType) -> str:
    """Return Python code for a port value; target paths become `usdrt.Sdf.Path` objects."""
    if port_type == types.TARGET:
        return f"[{', '.join(f'usdrt.Sdf.Path({text(path)})' for path in value)}]"
    return plain(value)


def plain(value: Any) -> str:
    """Return Python code for a number, a string, an array, or a nested list of them."""
    value = listed(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(plain, value))}]"
    if isinstance(value, str):
        return text(value)
    return number(value)


def number(value: Any) -> str:
    """Return Python code for a number or boolean, such as `float("inf")` for infinity."""
    if isinstance(value, float) and not math.isfinite(value):
        return f'float("{value}")'
    return repr(value)


def text(value: str) -> str:
    """Return Python code for a string, in double quotes unless they would need more escapes than single quotes."""
    quoted = repr(value)
    return f'"{quoted[1:-1]}"' if quoted[0] == "'" and '"' not in value and "\\'" not in quoted else quoted


def _docstring(doc: str) -> str:
    return "".join(c if c.isprintable() and c not in '"\\' else " " for c in doc)
