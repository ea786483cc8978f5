"""Stages in a few lines of text, read in this process, and what comes of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from graphengine.compiler.registry import default_registry
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.isaac.recorded_graph import RecordedGraph
from graphengine.isaac.stage.graphs import graphs_of
from graphengine.isaac.stage.stage_contents import StageContents
from graphengine.isaac.stage.stage_process import StageReading
from graphengine.sandbox.untrusted import encoded
from graphengine.sandbox.untrusted import read as read_answer

GRAPH = '#usda 1.0\ndef OmniGraph "G"\n{{\n    token evaluator:type = "execution"\n{}\n}}\n{}'


@dataclass
class Stage:
    contents: StageContents
    graphs: list[RecordedGraph]
    findings: Findings

    @property
    def graph(self) -> RecordedGraph:
        (graph,) = self.graphs
        return graph

    @property
    def wires(self) -> list[str]:
        return [str(wire) for wire in self.graph.wires]

    @property
    def told(self) -> str:
        return "\n".join(finding.render() for finding in self.findings.items)

    def value(self, node: str, port: str) -> object:
        return self.graph.nodes[node].values[f"inputs:{port}"].data


def node(name: str, type: str = "omni.graph.nodes.ConstantDouble", *lines: str, below: str = "") -> str:
    """The text of a node prim; `below` is what it contains."""
    return f'def OmniGraphNode "{name}" {{\ntoken node:type = "{type}"\n' + "\n".join(lines) + f"\n{below}\n}}\n"


def read(folder: Path, text: str, **others: str) -> Stage:
    """The stage of a text; of others beside it, `name.usda` by name. USD wants a new line before each closing bracket."""
    for name, content in {**others, "stage": text}.items():
        (folder / f"{name}.usda").write_text(content.replace(" }", "\n}"))
    path = folder / "stage.usda"
    findings = Findings()
    contents = read_answer(encoded(StageReading(Files.of(path)).run(path)).encode(), StageContents, 10_000_000)
    assert not contents.failure, contents.failure
    return Stage(contents, graphs_of(contents, default_registry(), PrimSpans(path), findings), findings)


def read_graph(folder: Path, *nodes: str, after: str = "") -> Stage:
    """The stage with one graph `/G` of some nodes; `after` are prims beside it."""
    return read(folder, GRAPH.format("".join(nodes), after))
