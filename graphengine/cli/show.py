"""`graphrun show`: print a graph's nodes and wires, its schedule or its generated code, or draw the graph."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import add_file_arguments, check_suffix, clean, counted, load, print_findings
from graphengine.cli.options import add_flag, add_value
from graphengine.format.atomic_write import write_together
from graphengine.format.files import near
from graphengine.format.wording import printable

if TYPE_CHECKING:
    from graphengine.compiler.graph import Graph, Wire
    from graphengine.compiler.plan import Call, Region
    from graphengine.scene.loaded_scene import LoadedScene


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun show` to its parser."""
    add_file_arguments(parser)
    form = parser.add_mutually_exclusive_group()
    add_flag(form, "--schedule", "print the nodes in the order in which they run, with the condition of each")
    add_flag(form, "--plan", "print the Python code that is generated for a tick")
    add_flag(form, "--mermaid", "print a Mermaid flowchart")
    add_value(form, "--svg", "FILE", "SVG file to write: a drawing with ports, values and findings", type=Path)
    page_file = "HTML file to write: the drawing as a web page with zoom and details of ports"
    add_value(form, "--html", "FILE", page_file, type=Path)


def execute(arguments: argparse.Namespace) -> int:
    """Print or draw all graphs of the file; return 0, or 1 if it has errors."""
    from graphengine.compiler.codegen import source_of

    scene = load(arguments)
    if arguments.svg or arguments.html:
        return draw(scene, arguments)
    if scene.findings.errors:
        print_findings(scene.findings, notes=False)
        return 1
    if arguments.mermaid:
        print("\n".join(["flowchart LR", *map(mermaid, scene.planned)]))
        return 0
    if arguments.plan:
        texts = [f"# {_at(graph)}\n{source_of(graph.plan).text}" for graph in scene.planned]
    else:
        texts = [f"{(schedule if arguments.schedule else outline)(graph)}\n" for graph in scene.planned]
    print("\n".join(texts), end="")
    return 0


def draw(scene: LoadedScene, arguments: argparse.Namespace) -> int:
    """Write a drawing of all graphs, including graphs with errors.

    Returns:
        0, or 1 if the file has errors or no graphs.

    Raises:
        UsageError: the name of the file to write has the wrong suffix.
    """
    from graphengine.drawing import page, svg
    from graphengine.drawing.view_model import make_graph_view

    print_findings(scene.findings, notes=False)
    views = [make_graph_view(graph, scene.findings) for graph in scene.graphs]
    if not views:
        return 1
    path: Path = arguments.svg or arguments.html
    check_suffix(path, *((".svg",) if arguments.svg else (".html", ".htm")))
    text = svg.draw(views) if arguments.svg else page.draw(views)
    write_together({path: text.encode()})
    print(clean(f"{near(str(path))}: {counted(len(views), 'graph')}"))
    return 1 if scene.findings.errors else 0


def _at(graph: Graph) -> str:
    """Return a line with the name, the prim path and the occasion of execution of a graph."""
    pushed = ", all nodes" if graph.flat.spec.evaluator == "push" else ""
    return printable(f"{graph.name}  at {graph.prim_path}, every {graph.runs.replace('_', ' ')}{pushed}")


def _value(value: Any) -> str:
    """Return a value as JSON on one line."""
    from graphengine.compiler.port_texts import listed

    return printable(json.dumps(listed(value), ensure_ascii=False))


def outline(graph: Graph) -> str:
    """Return the nodes of a graph as text, with types and the values in the file, and then the wires."""
    lines = [_at(graph)]
    gates = {instance.part_of: instance.make_node() for instance in graph.instances if instance.part_of}
    for instance in (instance for instance in graph.instances if not instance.part_of):
        pace = f", {gates[instance.id]}" if instance.id in gates else ""
        lines.append(f"  {instance.id}: {instance.cls.type_name}{pace}")
        for port in instance.cls.fields.values():
            if port.field in instance.literals:
                unit = f" {port.unit}" if port.unit else ""
                lines.append(f"    {port.name} = {_value(instance.value(port.field))}{unit}")
    wires = sorted([*graph.exec_wires, *graph.data_wires], key=lambda wire: wire.order)
    written = {id(entry) for entry in graph.flat.wires}
    return "\n".join([*lines, *(f"  {wire}" for wire in wires if id(wire.entry) in written)])


def schedule(graph: Graph) -> str:
    """Return the schedule of a graph as text: the regions of the plan, each with its nodes in execution order."""
    lines = [_at(graph)]
    constants = [graph.instances[refresh.node].id for refresh in graph.plan.constants]
    if constants:
        lines.append(f"  once, before the first tick: {', '.join(constants)}")
    for region in graph.plan.regions:
        lines.append(f"  {_occasion(region)}")
        lines += _calls(graph, region)
    return "\n".join(lines)


def _occasion(region: Region) -> str:
    if region.ending:
        return {"at_stop": "when a play ends", "at_close": "before the graph is closed"}[region.ending]
    return "each pass" if region.index == 0 else f"each time {region.title} fires"


def _calls(graph: Graph, region: Region) -> Iterator[str]:
    for call in region.calls:
        if_stale = {refresh.node: refresh.if_stale for refresh in call.refreshes}
        above = graph.plan.upstream(refresh.node for refresh in call.refreshes if refresh.shared)
        if_stale |= dict.fromkeys((refresh.node for refresh in above), True)
        for node in sorted(if_stale, key=graph.plan.ranks.__getitem__):
            yield _line(graph, node, "data", "when a value that it reads has changed" if if_stale[node] else "")
        instance = graph.instances[call.node]
        kind, pace = ("gate", str(instance.make_node())) if instance.part_of else (call.kind, "")
        yield _line(graph, call.node, kind, ", ".join(said for said in (pace, _when(graph, region, call)) if said))


def _when(graph: Graph, region: Region, call: Call) -> str:
    """Return a condition such as `when Tick.tick fires`, with all outputs that can start a node in a region.

    Return an empty text if the node always runs in this region.
    """
    if not call.guard:
        return ""
    wires = [wire for wire in graph.exec_wires if wire.target == call.node and _fires(graph, region, wire)]
    sources = dict.fromkeys(str(wire.entry.source) for wire in wires)  # one output may fire several inputs of a node
    return f"when {' or '.join(sources)} fires"


def _fires(graph: Graph, region: Region, wire: Wire) -> bool:
    """Return whether an execution wire can start its target in this region.

    A wire from a pusher node cannot, because the node itself runs its targets. A wire whose target runs in a later pass cannot.
    """
    kind = graph.instances[wire.source].cls.kind()
    if kind == "latent":
        return region.index == 0
    branches = [branch for call in region.calls if call.node == wire.source for branch in call.branches]
    later = {(fire.target, fire.pending_pin) for branch in branches for fire in branch.fires}
    return bool(branches) and kind != "pusher" and (wire.target, wire.target_field) not in later


def _line(graph: Graph, index: int, kind: str, when: str) -> str:
    return f"    {graph.instances[index].id:28} {kind:7} {when}".rstrip()


def mermaid(graph: Graph) -> str:
    """Return a graph as a subgraph of a Mermaid flowchart, with thick arrows for execution and thin arrows for data."""
    lines = [f'  subgraph {_safe(graph.name)}["{graph.name}"]']
    for instance in graph.instances:
        short = instance.cls.type_name.rpartition(".")[2]
        lines.append(f'    {_safe(graph.name)}_{instance.index}["{instance.id}<br/><small>{short}</small>"]')
    for wire in sorted([*graph.exec_wires, *graph.data_wires], key=lambda wire: wire.order):
        arrow = "==>" if wire in graph.exec_wires else "-->"
        label = f"{wire.entry.source.port} to {wire.entry.target.port}"
        name = _safe(graph.name)
        lines.append(f'    {name}_{wire.source} {arrow}|"{label}"| {name}_{wire.target}')
    return "\n".join([*lines, "  end"])


def _safe(name: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in name)
