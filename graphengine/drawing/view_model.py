"""View model of a drawing: nodes with ports and values, wires, subgraphs, and their findings.

The view model follows the graph in the file, so it also contains nodes with unknown types and refused wires.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from graphengine.compiler.graph import Graph, Instance, find_port, settled_type
from graphengine.compiler.port_texts import brief, listed
from graphengine.compiler.subgraph_expansion import NodeEntry, WireEnd, WireEntry
from graphengine.drawing.finding_assignment import assign_findings
from graphengine.drawing.geometry import Point
from graphengine.format.diagnostics import Finding, Findings
from graphengine.format.errors import UsageError
from graphengine.format.spec import EverySpec
from graphengine.format.wording import printable

MAX_NODES = 3000
"""Maximum number of nodes in a drawing."""
_SHOWN = 6
"""Maximum number of list elements in the value of a port on a box."""
FARTHEST = 100_000.0
"""Largest coordinate of a position in a graph file, px; positions beyond it are ignored."""
_LONG = 400
"""Maximum length of a text in a tooltip, characters."""


Mistake = Literal["", "refused", "circle"]
"""Error of a wire: `refused` by the compiler, `circle` for a wire of a cycle, empty for a correct wire."""
Key = tuple[str, str]
"""Identifies a port on a box: the side (`left` or `right`) and the name of the port."""
PortPlace = tuple[str, Key]
"""Identifies a port in a drawing: the id of the node, and the key of the port."""


@dataclass(slots=True)
class PortView:
    """A port on a box."""

    name: str
    is_exec: bool
    value: str = ""
    is_path: bool = False
    wired: bool = False
    about: str = ""


@dataclass(slots=True)
class NodeView:
    """A node in a drawing; `ports` has the ports with a wire or a set value, execution ports first."""

    id: str
    type_name: str
    kind: str
    place: Point | None
    about: str
    pace: str = ""
    """The rate that the node's `every:` sets, as text; empty if the node has no `every:`."""
    instance: Instance | None = None
    """Resolved node; None for an unknown node type."""
    ports: dict[Key, PortView] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)

    @property
    def name(self) -> str:
        """Name of the node within its own file."""
        return self.id.rpartition("/")[2]

    @property
    def group(self) -> str:
        """Id of the subgraph that contains the node; empty if the node is not in a subgraph."""
        return self.id.rpartition("/")[0]


@dataclass(frozen=True, slots=True)
class WireView:
    """A wire between two ports.

    Attributes:
        source: node and port where the wire begins.
        target: node and port where the wire ends.
        form: `exec` for execution, `later` for execution in a later pass, `data` for values.
        mistake: error of the wire; empty for a correct wire.
        about: text of the wire's tooltip.
    """

    source: PortPlace
    target: PortPlace
    form: Literal["exec", "later", "data"]
    mistake: Mistake
    about: str


@dataclass(slots=True)
class GraphView:
    """A graph in a drawing."""

    title: str
    caption: str
    nodes: list[NodeView]
    wires: list[WireView]
    groups: dict[str, tuple[str, Point | None]]
    """A dict from ids of subgraphs to file names and positions."""
    findings: list[Finding]
    """Findings that belong to no node."""


def make_graph_view(graph: Graph, findings: Findings) -> GraphView:
    """Return the view of a resolved graph, with or without errors.

    Raises:
        UsageError: the graph is too large for a useful drawing.
    """
    if len(graph.flat.nodes) > MAX_NODES:
        raise UsageError(f"{graph.name} has {len(graph.flat.nodes)} nodes; a drawing can have at most {MAX_NODES}")
    instances = {instance.id: instance for instance in graph.instances}
    nodes = {entry.id: _node(graph, entry, instances.get(entry.id)) for entry in graph.flat.nodes}
    made = {id(wire.entry) for wire in (*graph.exec_wires, *graph.data_wires)}
    assigned = assign_findings(graph, findings)
    wires = []
    for wire in graph.flat.wires:
        if wire.source.node in nodes and wire.target.node in nodes:
            mistake: Mistake = "refused" if id(wire) not in made else "circle" if wire in assigned.circular else ""
            wires.append(_wire(wire, nodes, mistake))
    for node in nodes.values():
        _sort_ports(node)
    groups: dict[str, tuple[str, Point | None]] = {}
    for entry in graph.flat.nodes:
        parts = entry.id.split("/")[:-1]
        for depth in range(1, len(parts) + 1):
            group = "/".join(parts[:depth])
            place = _place(graph.flat.spec.layout.get(group))
            file = entry.document.path.name if depth == len(parts) else ""
            groups[group] = (file or groups.get(group, ("", None))[0], place)
    for name, told in assigned.nodes.items():
        nodes[name].findings += told
    pushed = ", every node each time" if graph.flat.spec.evaluator == "push" else ""
    caption = f"at {graph.prim_path}, every {graph.runs.replace('_', ' ')}{pushed}"
    return GraphView(graph.name, caption, list(nodes.values()), wires, groups, assigned.graph)


def put_values(view: GraphView, value: Callable[[Instance, str], Any]) -> None:
    """Show other values of the ports that are set in the file.

    Args:
        view: the drawing to change.
        value: returns the value of a field of a node, such as the one that an input has now.
    """
    for node in view.nodes:
        fields = node.instance.cls.fields.items() if node.instance is not None else ()
        for name, port in fields:
            shown = node.ports.get(("left", port.name))
            if shown is not None and shown.value and node.instance is not None:
                shown.value = _with_unit(_value(value(node.instance, name), whole=False), port.unit)


def _node(graph: Graph, entry: NodeEntry, instance: Instance | None) -> NodeView:
    place = _layout(entry)
    if instance is None:
        return NodeView(entry.id, entry.spec.type, "unknown", place, f"{entry.id}\n{entry.spec.type}")
    cls = instance.cls
    doc = (inspect.getdoc(cls) or "").partition("\n\n")[0]
    about = "\n".join(filter(None, (f"{entry.id} ({cls.kind()})", cls.type_name, entry.spec.doc, doc)))
    node = NodeView(entry.id, cls.type_name, cls.kind(), place, about, _pace(entry.spec.every), instance)
    for name in cls.fields:
        if name in instance.literals:
            _add_port(node, "left", name, instance)
    return node


def _pace(every: EverySpec | None) -> str:
    if every is None:
        return ""
    return "once" if every.once else f"every {every.ticks} ticks" if every.ticks else f"every {every.hz:g} Hz"


def _layout(entry: NodeEntry) -> Point | None:
    """Return the position of a node in the section `layout` of its file, or None."""
    found = entry.document.find("layout", str(entry.location[-1]))
    return _place(found.to_data()) if found is not None else None


def _place(data: Any) -> Point | None:
    """Return a position in a file; None if it is malformed or too far away."""
    if not isinstance(data, list | tuple) or len(data) != 2 or not all(type(part) in (int, float) for part in data):
        return None
    return (float(data[0]), float(data[1])) if all(abs(part) <= FARTHEST for part in data) else None


def _add_port(node: NodeView, side: str, name: str, instance: Instance) -> PortView:
    port = instance.cls.fields[name]
    key = (side, port.name)
    if key not in node.ports:
        view = PortView(port.name, port.is_exec, about=_about(name, instance))
        if name in instance.literals:
            value = instance.value(name)
            view.value = _with_unit(_value(value, whole=False), port.unit)
            view.is_path = isinstance(value, str | tuple) and "/" in view.value
            view.about += f"\nset to {_with_unit(_value(value, whole=True), port.unit)}"
        node.ports[key] = view
    return node.ports[key]


def _about(name: str, instance: Instance) -> str:
    """Return the text of a port's tooltip: type, unit, default, constraint and documentation."""
    port = instance.cls.fields[name]
    if port.is_exec:
        return "\n".join(filter(None, (f"{port.name}: execution", port.doc)))
    first = f"{port.name}: {brief(settled_type(instance, port))}{f', {port.unit}' if port.unit else ''}"
    has_default = port.side == "inputs" and port.default is not None
    default = f"default {_value(port.default, whole=True)}" if has_default else ""
    return "\n".join(filter(None, (first, default, port.constraint, port.doc)))


def _value(value: Any, *, whole: bool) -> str:
    """Return a value as YAML on one line, with truncated long lists and texts."""
    most = 64 if whole else _SHOWN
    more = isinstance(value, np.ndarray | tuple | list) and len(value) > most
    value = value[:most] if more else value
    value = listed(value)
    if isinstance(value, tuple | list) and len(value) == 1 and isinstance(value[0], str) and not whole:
        value = value[0]
    text = _written(value)
    if more:
        text = f"{text[:-1]}, …]"
    return printable(text if len(text) <= _LONG else f"{text[:_LONG]}…")


def _written(value: Any) -> str:
    if isinstance(value, str):
        return value or '""'
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_written, value))}]"
    return json.dumps(value, ensure_ascii=False, default=repr)


def _with_unit(text: str, unit: str) -> str:
    return f"{text} {unit}" if unit else text


def _wire(entry: WireEntry, nodes: dict[str, NodeView], mistake: Mistake) -> WireView:
    source, is_exec = _end(entry.source, "right", ("outputs", "state", "inputs"), nodes)
    target, _ = _end(entry.target, "left", ("inputs", "state"), nodes)
    later = nodes[entry.source.node].kind == "latent"
    form: Literal["exec", "later", "data"] = "data" if not is_exec else "later" if later else "exec"
    return WireView(source, target, form, mistake, printable(f"{entry.source} -> {entry.target}"))


def _end(end: WireEnd, side: str, sides: Sequence[str], nodes: dict[str, NodeView]) -> tuple[PortPlace, bool]:
    """Add the port at one end of a wire to its node; return the port, and whether it is an execution port."""
    node = nodes[end.node]
    instance = node.instance
    port = find_port(instance.cls, end.port, [end.side] if end.side else sides) if instance else None
    if instance is None or port is None:
        view = node.ports.setdefault((side, end.port), PortView(end.port, False))
    else:
        view = _add_port(node, side, port.field, instance)
    view.wired = True
    return (node.id, (side, end.port)), view.is_exec


def _sort_ports(node: NodeView) -> None:
    """Sort the ports of a node: execution ports first, then the others in the order of the node type.

    An input at which wires begin but none ends stays only on the right side.
    """
    names = dict.fromkeys(port.name for port in node.instance.cls.fields.values()) if node.instance else ()
    order = {name: number for number, name in enumerate(names)}
    for side, name in list(node.ports):
        if side == "left" and not node.ports[side, name].wired and ("right", name) in node.ports:
            del node.ports[side, name]
    last = len(order)
    node.ports = dict(sorted(node.ports.items(), key=lambda item: (not item[1].is_exec, order.get(item[0][1], last))))
