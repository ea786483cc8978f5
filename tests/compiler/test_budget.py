"""What one graph may hold with all of its subgraphs in place; the files are small, what they amount to is not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphengine.compiler import budget
from graphengine.compiler.budget import MAX_PARTS
from graphengine.format import document
from graphengine.format.diagnostics import MAX_GUESSES, Finding, Findings
from graphengine.scene import build
from graphengine.scene import graph_loading as uses_of_graphs


def findings(folder: Path, **files: str) -> list[Finding]:
    for name, body in files.items():
        (folder / f"{name}.yaml").write_text(f"graph: {name}\n{body}")
    return build.load(folder / f"{next(iter(files))}.yaml").findings.items


def uses(count: int, file: str, more: str = "") -> str:
    return "nodes:\n" + "".join(f"  S{i}: {{subgraph: {file}.yaml{more}}}\n" for i in range(count))


def tree(leaf: str, more: str = "") -> dict[str, str]:
    return {f"f{i}": leaf if i == 14 else uses(10, f"f{i + 1}", more) for i in range(15)}


PARAMETER = "parameters: {p: {type: string, default: x}}\n"
HOSTILE = {
    "nodes": tree("nodes: {A: Counter}\n"),
    "uses alone": tree(""),
    "other parameters each": {
        name: PARAMETER + body for name, body in tree("nodes: {A: Counter}\n", ", parameters: {p: $(p)x}").items()
    },
    "variables": {
        "a": uses(200, "v"),
        "v": "variables:\n" + "".join(f"  v{i}: {{type: double}}\n" for i in range(5000)),
    },
    "wires": {
        "a": uses(200, "w"),
        "w": "nodes: {T: OnPlaybackTick, C: Counter}\nconnections:\n" + "  - T.tick -> C.execIn\n" * 5000,
    },
}


@pytest.mark.parametrize("files", HOSTILE.values(), ids=HOSTILE)
def test_too_many_nodes_of_subgraphs_are_one_error_with_limit_counts_and_position(
    files: dict[str, str], tmp_path: Path
) -> None:
    (found,) = findings(tmp_path, **files)
    assert found.code == "G105"
    assert f"more than {MAX_PARTS} nodes, wires, variables and uses of subgraphs in one graph: " in found.message
    assert found.span is not None


@pytest.mark.parametrize(("limit", "codes"), [(4, []), (3, ["G105"])])
def test_a_graph_may_hold_as_many_parts_as_the_limit(
    limit: int, codes: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(budget, "MAX_PARTS", limit)
    wired = (
        "variables: {v: {type: double}}\nnodes: {T: OnPlaybackTick, C: Counter}\nconnections: [T.tick -> C.execIn]\n"
    )
    assert [one.code for one in findings(tmp_path, a=wired) if one.severity == "error"] == codes


def test_values_of_a_file_count_at_every_use(tmp_path: Path) -> None:
    array = f"nodes: {{A: {{type: ConstantDouble, inputs: {{value: [{'1.0, ' * 50_000}]}}}}}}\n"
    found = [one for one in findings(tmp_path, a=uses(20, "v"), v=array) if one.code == "G105"]
    assert [one.message.partition(" values")[0] for one in found] == ["more than 400000"]


def test_all_graphs_of_a_scene_share_a_limit_of_nodes_wires_and_variables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(uses_of_graphs, "MAX_SCENE_PARTS", 18)  # six graphs of two nodes and a wire
    (tmp_path / "world.xml").write_text("<mujoco/>")
    (tmp_path / "g.yaml").write_text(
        "graph: g\nnodes: {T: OnPlaybackTick, C: Counter}\nconnections: [T.tick -> C.execIn]\n"
    )
    for count, told in (
        (6, []),
        (7, [("G105", "more than 18 nodes, wires and variables in the graphs of one scene", 10)]),
    ):
        graphs = "".join(f"  g{i}: {{use: g.yaml, at: /World/g{i}}}\n" for i in range(count))
        (tmp_path / "scene.yaml").write_text(f"scene: many\nworld: world.xml\ngraphs:\n{graphs}")
        assembly = build.load(tmp_path / "scene.yaml")
        errors = assembly.findings.errors
        assert [(one.code, one.message, one.span.line) for one in errors if one.span] == told
        assert len(assembly.graphs) == (0 if told else count)


def test_a_file_is_read_once_however_often_it_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parsed: list[str] = []
    real = document.parse

    def parse(text: str, shown: str, found: Findings, **options: Any) -> document.Document | None:
        parsed.append(shown)
        return real(text, shown, found, **options)

    monkeypatch.setattr(document, "parse", parse)
    findings(tmp_path, a=uses(100, "b"), b="nodes: {A: Counter}\n")
    assert len([path for path in parsed if path.endswith("b.yaml")]) == 1


def test_a_repeated_wire_is_one_finding_and_one_wire(tmp_path: Path) -> None:
    body = "nodes: {T: OnPlaybackTick, C: Counter}\nconnections:\n" + "  - T.tick -> C.execIn\n" * 10_000
    (found,) = findings(tmp_path, a=body)
    assert (found.code, found.message) == ("W108", "T.tick -> C.execIn is written 10000 times")
    assert found.span is not None
    assert (found.span.line, found.related[0][0].line) == (5, 4)
    assert len(build.load(tmp_path / "a.yaml").graphs[0].exec_wires) == 1


def test_only_the_first_findings_suggest_names(tmp_path: Path) -> None:
    body = "nodes:\n" + "".join(f"  N{i}: Countr{i}\n" for i in range(200))
    found = findings(tmp_path, a=body)
    assert {one.code for one in found} == {"G201"}
    assert sum("did you mean" in one.help[0] for one in found) == MAX_GUESSES
