"""Graph files and recorded graphs in a form in which two of them compare."""

from __future__ import annotations

import functools
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
import pytest

from graphengine.compiler.graph import Graph
from graphengine.compiler.library import GraphLibrary
from graphengine.compiler.registry import default_registry
from graphengine.compiler.resolve import resolve
from graphengine.compiler.subgraph_expansion import load_graph
from graphengine.format.diagnostics import Finding, Findings
from graphengine.format.files import Files
from graphengine.isaac.graph_file import compose, file_names
from graphengine.isaac.recorded_graph import RecordedGraph, RecordedNode
from graphengine.isaac.script.script_reader import read_script
from graphengine.sandbox import confinement

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = Path(__file__).parent / "scripts"


def resolved(path: Path) -> tuple[Graph, Findings]:
    """A graph file with its types and wires settled."""
    findings = Findings()
    flat = load_graph(path, {}, GraphLibrary(Files.of(path)), findings)
    assert flat is not None, findings.items
    name, at = flat.spec.graph, flat.spec.at or f"/World/{flat.spec.graph}"
    return resolve(flat, name, at, default_registry(), findings), findings


def meaning(graph: Graph) -> dict[str, Any]:
    """All that a graph file says but for its name, its words and how it is written."""
    names = [instance.id.replace("/", "_") for instance in graph.instances]
    wires = sorted([*graph.data_wires, *graph.exec_wires], key=lambda wire: wire.order)
    spec = graph.flat.spec
    return {
        "at": graph.prim_path,
        "runs": spec.runs,
        "evaluator": spec.evaluator,
        "nodes": [
            (name, instance.cls.type_name, {f: _value(value) for f, value in sorted(instance.literals.items())})
            for name, instance in zip(names, graph.instances, strict=True)
        ],
        "settled": [{f: str(t) for f, t in sorted(instance.settled.items())} for instance in graph.instances],
        "wires": [(names[w.source], w.source_field, names[w.target], w.target_field) for w in wires],
        "variables": {n: (str(graph.variable_types[n]), _value(v)) for n, v in graph.variables.items()},
        "layout": dict(spec.layout),
    }


def _value(value: Any) -> Any:
    """By its text, in which a number that is none equals itself."""
    return repr(value.tolist() if isinstance(value, np.ndarray) else value)


@functools.cache
def recorded(script: Path, *arguments: str) -> tuple[list[RecordedGraph], list[Finding]]:
    """The graphs of a script and what is told, found out once."""
    findings = Findings()
    return read_script(script, findings, arguments, types=default_registry().types), findings.items


def graph(*nodes: RecordedNode, **values: Any) -> RecordedGraph:
    return RecordedGraph("/World/g", "execution", nodes={node.name: node for node in nodes}, **values)


def composed(recorded: RecordedGraph) -> tuple[str, Findings]:
    findings = Findings()
    return compose(recorded, "g", default_registry(), findings, "a test"), findings


def kept_answers(module: ModuleType, patch: pytest.MonkeyPatch) -> list[bytes]:
    """Answers of the confined processes that a module asks from now on."""
    real: list[bytes] = []

    def ask(*given: Any) -> bytes:
        real.append(confinement.ask(*given))
        return real[-1]

    patch.setattr(module, "ask", ask)
    return real


class Read(NamedTuple):
    """What a script gives."""

    graphs: list[RecordedGraph]
    warnings: list[str]
    """Each with its line, counted from the end of the beginning that all scripts of a test share."""
    findings: Findings


def read_text(folder: Path, text: str, start: str = "", **given: Any) -> Read:
    """Read a script that has a beginning and a text; it builds some graph."""
    path, findings, begun = folder / "script.py", Findings(), start.count("\n")
    path.write_text(start + text, encoding="utf-8")
    graphs = read_script(path, findings, **given)
    assert findings.errors == []
    return Read(graphs, [f"{f.span.line - begun}: {f.message}" for f in findings.warnings if f.span], findings)


def imported(script: Path, folder: Path, *arguments: str) -> tuple[list[Path], Findings]:
    """The graph files that a script gives, and what is told."""
    findings = Findings()
    graphs, items = recorded(script, *arguments)
    for item in items:
        findings.put(item)
    written = []
    for graph, name in zip(graphs, file_names(graphs), strict=True):
        path = folder / f"{name}.yaml"
        path.write_text(compose(graph, name, default_registry(), findings, script.name), encoding="utf-8")
        written.append(path)
    return written, findings


def texts(findings: Findings) -> list[str]:
    return [finding.render() for finding in findings.sorted()]
