"""Exports a graph as a script that builds it in Isaac Sim with one `og.Controller.edit`.

Subgraphs are expanded and parameters are replaced by their values, because scripts have neither. Each feature without a
counterpart in Isaac Sim is reported.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from graphengine.compiler.every_gates import EveryOnce, EveryTicks
from graphengine.compiler.graph import Graph, Instance
from graphengine.format.diagnostics import Findings
from graphengine.isaac.graph_file import SCRIPT_NODE, unique
from graphengine.node import PortType, UnionType, types
from graphengine.node.port import ExecOut, Port

OWN = "graphengine."
"""Prefix of the names of graphengine's own node types, which Isaac Sim does not have."""
GATES = {
    EveryTicks.type_name: ("isaacsim.core.nodes.IsaacSimulationGate", "execOut"),
    EveryOnce.type_name: ("isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame", "step"),
}
"""Isaac Sim's node type, and the name of its execution output, by the type name of graphengine's `every:` gate."""
_MESSAGE = ("messagePackage", "messageSubfolder", "messageName")
"""Inputs of generic ROS nodes that select the message type, for whose fields Isaac Sim then creates ports."""
TICK_RATE = 60
"""Default tick rate of scenes and of Isaac Sim, Hz."""


def write_script(graph: Graph, findings: Findings) -> str:
    """Return the script as text, or an empty string, with errors in `findings`, if a part of the graph cannot be exported.

    Args:
        graph: resolved graph without errors.
        findings: receives an error for each part without a counterpart in Isaac Sim.
    """
    before = len(findings.errors)
    exporter = _Exporter(graph, findings)
    return "" if len(findings.errors) > before else "\n".join([*exporter.lines(), ""])


class _Exporter:
    def __init__(self, graph: Graph, findings: Findings) -> None:
        self.graph, self.findings = graph, findings
        self.names = _names([instance.id for instance in graph.instances])
        for instance in graph.instances:
            if not instance.part_of:
                self._refuse(instance)

    def _refuse(self, instance: Instance) -> None:
        """Report what Isaac Sim lacks for a node: its type, a gate with a rate in Hz, and ports that are wired or set."""
        if instance.cls.type_name.startswith(OWN):
            self._tell(instance, f"Isaac Sim has no node type {instance.cls.type_name}")
        every = instance.entry.spec.every
        if every is not None and every.hz is not None:
            ticks = max(1, round(TICK_RATE / every.hz))
            counted = f"which at {TICK_RATE} ticks a second is {TICK_RATE / ticks:g} Hz"
            advice = f"write `every: {{ticks: {ticks}}}`, {counted}"
            self._tell(instance, "`every` has a rate in Hz, but the gates of Isaac Sim count ticks", advice)
        wires = [*self.graph.data_wires, *self.graph.exec_wires]
        used = instance.literals.keys() | {wire.target_field for wire in wires if wire.target == instance.index}
        used |= {wire.source_field for wire in wires if wire.source == instance.index}
        for field in sorted(used):
            port = instance.cls.fields[field]
            if port.extension and not (instance.cls.type_name == SCRIPT_NODE and port.name == "attributes"):
                self._tell(instance, f"{instance.cls.type_name} has no {port.side}:{port.name} in Isaac Sim")

    def _tell(self, instance: Instance, what: str, *help: str) -> None:
        self.findings.add("G402", f"{instance.id}: {what}", instance.span, *help, related=instance.entry.via)

    def lines(self) -> Iterator[str]:
        """Yield the lines of the script."""
        graph, spec = self.graph, self.graph.flat.spec
        layout = {self.names[name]: place for name, place in spec.layout.items() if name in self.names}
        if spec.doc:
            yield from ('"""' + _docstring(spec.doc) + '"""', "")
        yield "import omni.graph.core as og"
        if layout:
            yield "import omni.usd"
        if self._targets():
            yield "import usdrt.Sdf"
        if layout:
            yield "from pxr import Gf, Sdf"
        yield from ("", f"GRAPH_PATH = {text(graph.prim_path)}", "", "keys = og.Controller.Keys", "og.Controller.edit(")
        yield from ("    {", '        "graph_path": GRAPH_PATH,', f'        "evaluator_name": {text(spec.evaluator)},')
        if graph.runs == "physics_step":
            yield '        "pipeline_stage": og.GraphPipelineStage.GRAPH_PIPELINE_STAGE_ONDEMAND,'
        yield from ("    },", "    {")
        yield from _block("CREATE_VARIABLES", list(self._variables()))
        yield from _block("CREATE_NODES", list(self._nodes()))
        yield from _block("CREATE_ATTRIBUTES", list(self._attributes()))
        if messages := list(self._values(of_messages=True)):
            yield from _block("SET_VALUES", messages)
            yield from ("    },", ")", "", "# from here on, the nodes have ports for the fields of their messages")
            yield from ("og.Controller.edit(", "    GRAPH_PATH,", "    {")
        yield from _block("CONNECT", list(self._wires()))
        yield from _block("SET_VALUES", list(self._values(of_messages=False)))
        yield from ("    },", ")")
        if layout:
            yield from ("", "stage = omni.usd.get_context().get_stage()")
        for name, (x, y) in layout.items():
            yield f'node = stage.GetPrimAtPath(f"{{GRAPH_PATH}}/{name}")'
            attribute = 'node.CreateAttribute("ui:nodegraph:node:pos", Sdf.ValueTypeNames.Float2)'
            yield f"{attribute}.Set(Gf.Vec2f({number(x)}, {number(y)}))"

    def _variables(self) -> Iterator[str]:
        for name, value in self.graph.variables.items():
            port_type = self.graph.variable_types[name]
            yield f"({text(name)}, {text(str(port_type))}, {literal(value, port_type)})"

    def _nodes(self) -> Iterator[str]:
        for instance in self.graph.instances:
            type_name = GATES[instance.cls.type_name][0] if instance.part_of else instance.cls.type_name
            yield f"({text(self.names[instance.id])}, {text(type_name)})"

    def _attributes(self) -> Iterator[str]:
        """Yield the Python code of a tuple `(attribute, type)` for each port that the script must add to a node."""
        for instance in self.graph.instances:
            fixed = _fixed_ports(instance)
            for key, port in instance.cls.ports.items():
                if key not in fixed:
                    settled = instance.settled.get(port.field, port.type)
                    name = "any" if isinstance(settled, UnionType) else str(settled)
                    yield f"({text(self._end(instance, port))}, {text(name)})"
            for hole in _holes(instance):
                yield f"({text(f'{self.names[instance.id]}.outputs:{hole}')}, {text('execution')})"

    def _wires(self) -> Iterator[str]:
        wires = sorted([*self.graph.data_wires, *self.graph.exec_wires], key=lambda wire: wire.order)
        for wire in wires:
            start, end = self._end(*self.graph.source(wire)), self._end(*self.graph.target(wire))
            yield f"({text(start)}, {text(end)})"

    def _end(self, instance: Instance, port: Port) -> str:
        """Return the name that a script uses for a port, such as `Node.inputs:x`, or `Node.outputs_x` for a bundle output."""
        output = port.side == "outputs"
        name = GATES[instance.cls.type_name][1] if instance.part_of and output else port.name
        between = "_" if output and str(port.type) == "bundle" else ":"
        return f"{self.names[instance.id]}.{port.side}{between}{name}"

    def _values(self, *, of_messages: bool) -> Iterator[str]:
        """Yield the Python code of tuples `(attribute, value)` for inputs that select message types, or for all other inputs."""
        for instance in self.graph.instances:
            if issubclass(instance.cls, EveryTicks) and not of_messages:
                yield f"({text(f'{self.names[instance.id]}.inputs:step')}, {instance.value('ticks')})"
        for instance, port in self._literals():
            if (port.name in _MESSAGE) != of_messages:
                continue
            settled = instance.settled.get(port.field, port.type)
            value = instance.value(port.field)
            shown = literal(value, settled) if isinstance(settled, PortType) else plain(value)
            several = isinstance(port.type, UnionType) or port.type == types.ANY
            typed = f", {text(str(settled))}" if several and isinstance(settled, PortType) else ""
            yield f"({text(self._end(instance, port))}, {shown}{typed})"

    def _literals(self) -> Iterator[tuple[Instance, Port]]:
        for instance in self.graph.instances:
            for port in instance.cls.fields.values():
                declares = instance.cls.type_name == SCRIPT_NODE and port.name == "attributes"
                if port.field in instance.literals and not declares:
                    yield instance, port

    def _targets(self) -> bool:
        variables = self.graph.variable_types.values()
        return any(port.type == types.TARGET for _, port in self._literals()) or types.TARGET in variables


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


def _block(key: str, items: Sequence[str]) -> Iterator[str]:
    if items:
        yield f"        keys.{key}: ["
        yield from (f"            {item}," for item in items)
        yield "        ],"


def literal(value: Any, port_type: PortType) -> str:
    """Return Python code for a port value; target paths become `usdrt.Sdf.Path` objects."""
    if port_type == types.TARGET:
        return f"[{', '.join(f'usdrt.Sdf.Path({text(path)})' for path in value)}]"
    return plain(value)


def plain(value: Any) -> str:
    """Return Python code for a number, a string, an array, or a nested list of them."""
    value = types.listed(value)
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
