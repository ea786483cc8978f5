import importlib.util
import random
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pxr")

from pxr import Sdf, UsdUtils

from graphengine.cli import main
from graphengine.compiler.registry import default_registry
from graphengine.descriptions.usd.stage_files import LONGEST
from graphengine.format.diagnostics import Findings, to_json
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.files import Files, shipped
from graphengine.isaac.graph_file import compose
from graphengine.isaac.stage import graphs as stage_graphs
from graphengine.isaac.stage import stage_reader as stage
from graphengine.isaac.stage.stage_contents import StageAttribute, StageContents, StagePrim
from graphengine.isaac.stage.stage_reader import ImportedStage, read_stage
from graphengine.sandbox.untrusted import encoded
from graphengine.scene import build
from tests.descriptions.files.forging import forged
from tests.isaac.harness import kept_answers
from tests.isaac.stage.harness import GRAPH, node

TUTORIAL = Path(__file__).parent / "tutorial.usda"


def imported(path: Path) -> tuple[ImportedStage | None, str]:
    findings = Findings()
    found = read_stage(path, Files.of(path, near=path.parent), default_registry(), findings)
    return found, "\n".join(finding.render() for finding in findings.items)


def refused(path: Path) -> str:
    """What is told of a stage that cannot be read."""
    found, told = imported(path)
    assert found is None
    return told


def resolved(path: Path) -> tuple[str, dict[str, Any], set[str]]:
    """What a graph file means: its place, the type and inputs of each node, and the wires."""
    assembly = build.load(path)
    assert not assembly.findings.errors
    (graph,) = assembly.planned
    nodes = {}
    for instance in graph.instances:
        inputs = [name for name, port in instance.cls.fields.items() if port.side == "inputs"]
        nodes[instance.id] = instance.cls.type_name, {name: repr(instance.value(name)) for name in inputs}
    return graph.prim_path, nodes, {str(wire) for wire in (*graph.data_wires, *graph.exec_wires)}


@pytest.fixture(scope="module")
def tutorial() -> tuple[ImportedStage, str]:
    found, told = imported(TUTORIAL)
    assert found is not None
    return found, told


@pytest.mark.parametrize("name", ["clock", "scan", "cmd_vel", "joint_states"])
def test_the_graphs_of_the_tutorial_come_out_as_they_ship(
    name: str, tutorial: tuple[ImportedStage, str], tmp_path: Path
) -> None:
    (graph,) = [graph for graph in tutorial[0].graphs if graph.path.endswith(f"/{name}")]
    findings = Findings()
    file = tmp_path / f"{name}.yaml"
    file.write_text(compose(graph, name, default_registry(), findings, "tutorial.usda"))
    assert not findings.items
    assert resolved(file) == resolved(shipped() / "graphs" / "tutorial" / f"{name}.yaml")


def test_the_tutorial_is_imported_without_a_word(tutorial: tuple[ImportedStage, str]) -> None:
    assert not tutorial[1]


def test_namespaces_are_offered_for_the_scene(tutorial: tuple[ImportedStage, str]) -> None:
    assert tutorial[0].scene_lines() == (
        "namespaces:\n"
        "  /dd100/Geometry/base_link: dd100_0000\n"
        "  /dd100/Geometry/base_link/chassis_link/sim_lidar: sim_lidar\n"
    )


def test_the_three_forms_of_a_file_are_the_same(tmp_path: Path, tutorial: tuple[ImportedStage, str]) -> None:
    for suffix in ("usdc", "usd"):
        path = tmp_path / f"tutorial.{suffix}"
        Sdf.Layer.FindOrOpen(str(TUTORIAL)).Export(str(path))
        found, told = imported(path)
        assert not told
        assert found is not None
        assert [set(graph.wires) for graph in found.graphs] == [set(graph.wires) for graph in tutorial[0].graphs]


def test_a_mistake_in_the_text_is_reported_at_its_place(tmp_path: Path) -> None:
    path = tmp_path / "broken.usda"
    path.write_text('#usda 1.0\ndef OmniGraph "G" {\n    double x = "text"\n}\n')
    told = refused(path)
    assert f"{path}:3:" in told
    assert "error G401: USD syntax error" in told
    assert '     3 |     double x = "text"' in told


@pytest.mark.parametrize("content", [b"", b"PXR-USDC", b"PXR-USDC" + bytes(200), b"\x00" * 50])
def test_a_file_that_is_no_stage_is_reported(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "none.usd"
    path.write_bytes(content)
    told = refused(path)
    assert "error G401" in told
    assert "Traceback" not in told


@pytest.mark.parametrize("seed", range(4))
def test_a_damaged_binary_file_is_read_or_reported(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "damaged.usdc"
    Sdf.Layer.FindOrOpen(str(TUTORIAL)).Export(str(path))
    content, generator = bytearray(path.read_bytes()), random.Random(seed)
    for _ in range(20):
        content[generator.randrange(8, len(content))] = generator.randrange(256)
    path.write_bytes(content)
    found, told = imported(path)
    assert (found is None) == ("error G401" in told)


def test_a_crash_of_the_reader_is_reported_as_damage_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "crash.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(stage, "_PROCESS", "crash")
    assert "error G401: USD's reader crashed: Segmentation fault" in refused(tmp_path / "a.usda")


def test_without_usd_core_the_installation_command_is_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UsageError, match=r"pip install '\.\[usd\]'"):
        imported(TUTORIAL)


def test_the_graphs_of_a_package_are_read(tmp_path: Path) -> None:
    (tmp_path / "robot.usda").write_text(f'#usda 1.0\ndef OmniGraph "G" {{\n{node("C")}}}\n')
    UsdUtils.CreateNewUsdzPackage(str(tmp_path / "robot.usda"), str(tmp_path / "robot.usdz"))
    found, _ = imported(tmp_path / "robot.usdz")
    assert found is not None
    assert [graph.path for graph in found.graphs] == ["/G"]


def test_the_command_line_writes_the_graphs_and_offers_the_namespaces(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["import", str(TUTORIAL), "-o", str(tmp_path)]) == 0
    assert sorted(path.stem for path in tmp_path.glob("*.yaml")) == ["clock", "cmd_vel", "joint_states", "scan"]
    assert "/dd100/Geometry/base_link: dd100_0000" in capsys.readouterr().out


def test_omitted_parts_are_reported_with_their_place(tmp_path: Path) -> None:
    path = tmp_path / "stage.usda"
    path.write_text(f'#usda 1.0\ndef "a" (references = @../b.usd@) {{}}\ndef OmniGraph "G" {{\n{node("C")}}}\n')
    found, told = imported(path)
    assert found is not None
    assert f"{path}:2:24: warning W302: ../b.usd is left out: it lies outside" in told


def test_messages_of_usd_are_printed_in_one_line_of_bounded_length(tmp_path: Path) -> None:
    deep = "".join(f'def Xform "a_rather_long_name_{n}" {{\n' for n in range(100))
    (tmp_path / "deep.usda").write_text(f"#usda 1.0\n{deep}{'}' * 2000}", encoding="utf-8")
    findings = Findings()
    path = tmp_path / "deep.usda"
    assert read_stage(path, Files.of(path, near=tmp_path), default_registry(), findings) is None
    (finding,) = findings.items
    assert finding.message.startswith("USD syntax error: ")
    assert len(finding.message) <= LONGEST + 20


def test_no_forged_answer_raises_anything_but_errors_of_this_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = kept_answers(stage, monkeypatch)
    path = tmp_path / "a.usda"
    below = f'def OmniGraph "Graph" {{\n{node("In")}}}\n'
    compound = node("C", "x.y", "rel omni:graph:compoundGraph = <Graph>", below=below)
    path.write_text(GRAPH.format(compound, 'def "P" {\nrel omniGraphs = </G>\n}\n'))
    assert imported(path)[0]
    for answer in forged(real[0], 300):
        monkeypatch.setattr(stage, "ask", lambda *_, answer=answer: answer)
        findings = Findings()
        try:
            found = read_stage(path, Files.of(path), default_registry(), findings)
            for graph in found.graphs if found else ():
                compose(graph, "g", default_registry(), findings, "a.usda").encode()
        except GraphError:
            continue
        to_json(findings.sorted())
        assert all(finding.render() for finding in findings.items)


def attribute(*sources: str) -> StageAttribute:
    return StageAttribute("double", sources=list(sources))


LONG = "/h" * 200_000
COMPOUNDS = ["/G" + "/C/g" * depth for depth in range(1, 45)]
NESTED = [
    StagePrim("/G", "OmniGraph"),
    *(StagePrim(path, "OmniGraph") for path in COMPOUNDS),
    *(
        StagePrim(path[:-2], "OmniGraphNode", targets={"omni:graph:compoundGraph": COMPOUNDS[number:] * 3})
        for number, path in enumerate(COMPOUNDS)
    ),
]
USED = [StagePrim("/G", "OmniGraph"), *(StagePrim(f"/G/N{n}", "OmniGraphNode") for n in range(100))]
USERS = [StagePrim(f"/P{n}", "", targets={"omniGraphs": ["/G"] * 10}) for n in range(100)]
THROUGH = StagePrim("/G/C", "OmniGraphNode", {"inputs:x": attribute(*["/G/N.outputs:x"] * 100)})
THROUGH.targets["omni:graph:compoundGraph"] = ["/G/C/g"]
READERS = [
    StagePrim("/G", "OmniGraph"),
    StagePrim("/G/N", "OmniGraphNode"),
    THROUGH,
    *(StagePrim(f"/G/R{n}", "OmniGraphNode", {"inputs:y": attribute("/G/C.inputs:x")}) for n in range(100)),
]


@pytest.mark.parametrize(
    ("contents", "said"),
    [
        (StageContents(failure=f"/a.usda:{10**4000}:1: bad"), "error G401: USD cannot read the stage"),
        (StageContents(failure=f"/a.usda:{10**8}:{10**8}: bad"), "error G401: USD syntax error: bad"),
        (StageContents({prim.path: prim for prim in NESTED}), ""),
        (StageContents({prim.path: prim for prim in (*USED, *USERS)}), "more than 1000 nodes, wires and values"),
        (StageContents({prim.path: prim for prim in READERS}), "more than 1000 nodes, wires and values"),
        (StageContents({LONG: StagePrim(LONG, "OmniGraphNode")}), ""),
    ],
    ids=["digits", "place", "compounds", "instances", "wires", "path"],
)
def test_a_stage_that_multiplies_comes_to_an_end(
    contents: StageContents, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stage_graphs, "MAX_PARTS", 1000)
    (tmp_path / "a.usda").write_text("#usda 1.0\n")
    sent = encoded(contents).encode()
    monkeypatch.setattr(stage, "ask", lambda *_: sent)
    found, told = imported(tmp_path / "a.usda")
    assert said in told
    assert (found is None) == ("G401" in told)
