"""Limits of the room isaac."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphengine.compiler.registry import default_registry
from graphengine.descriptions.usd import usd_reader
from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.descriptions.usd.stage_physics_process import PhysicsReading
from graphengine.descriptions.usd.usd_reader import read_usd
from graphengine.descriptions.usd_model import PhysicsContents
from graphengine.format.diagnostics import Findings, Source, Span
from graphengine.format.files import Files
from graphengine.isaac import graph_file
from graphengine.isaac.omniverse import og_edit, og_names, plain_data
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder
from graphengine.isaac.omniverse.og_names import OmniGraphError
from graphengine.isaac.omniverse.plain_data import UnknownError
from graphengine.isaac.omniverse.script_notes import EndlessError, ScriptNotes
from graphengine.isaac.omniverse.stubs import StubObject
from graphengine.isaac.recorded_graph import RecordedGraph, RecordedNode, RecordedWire, carried
from graphengine.isaac.script import script_process, script_reader
from graphengine.isaac.script.import_finder import ImportFinder
from graphengine.isaac.script.losses import Losses
from graphengine.isaac.script.script_answer import ScriptAnswer
from graphengine.isaac.stage import graphs, stage_reader, usd_conversion
from graphengine.isaac.stage.stage_contents import StageContents, StagePrim
from graphengine.isaac.stage.stage_process import StageReading
from graphengine.sandbox.untrusted import encoded
from tests.isaac.harness import composed, graph
from tests.isaac.stage.harness import node, read, read_graph
from tests.isaac.stage.test_graphs import compound
from tests.limits.table import accepts, limit, repeat

SPAN = Span(Source("a", ()), 1, 1)

# Recorded graphs


def paths_of(*names: str) -> list[str]:
    return graph_file.file_names([RecordedGraph(name) for name in names])


@limit("isaac.graph_file._LONGEST_NAME")
def _(letters: int) -> bool:
    return paths_of(f"/World/{'g' * letters}") == ["g" * letters]


@limit("isaac.graph_file._MOST_PARTS", at=3)
def _(parts: int) -> bool:
    """The name of a graph that needs all parts of its path, because another one differs only in the first."""
    below = "/g" * (parts - 1)
    return paths_of(f"/a{below}", f"/b{below}", f"/c{below}")[-1].startswith("c_")


@limit("isaac.graph_file._MOST_FOLLOWED", at=3)
def _(wires: int) -> bool:
    """The last wire begins at an input, to which so many wires lead."""
    names = [f"T{number}" for number in range(wires)]
    nodes = [RecordedNode(name, "omni.graph.action.OnPlaybackTick") for name in names]
    nodes += [RecordedNode(name, "omni.graph.action.Counter") for name in ("C", "D")]
    ticks = [RecordedWire(name, "outputs:tick", "C", "inputs:execIn") for name in names]
    made = graph(*nodes, wires=[*ticks, RecordedWire("C", "inputs:execIn", "D", "inputs:execIn")])
    return "wires lead to" not in str(composed(made)[1].items)


@limit("isaac.recorded_graph.MAX_ITEMS", at=10)
def _(items: int) -> bool:
    return accepts(lambda: plain_data.plain_data([1] * (items - 1)), UnknownError)  # the list is an item too


@limit("isaac.recorded_graph.MAX_ITEMS", at=10)
def _(items: int) -> bool:
    return accepts(lambda: plain_data.plain_data(np.ones(items - 1)), UnknownError)


@limit("isaac.recorded_graph.MAX_ITEMS", at=10)
def _(items: int) -> bool:
    from pxr import Vt

    return accepts(lambda: usd_conversion.plain_value(Vt.DoubleArray(items), "double[]"), ValueError)


@limit("isaac.recorded_graph.MAX_GRAPHS", at=3)
def _(number: int) -> bool:
    findings = Findings()
    return carried(["a"] * number, lambda name: [name], "graphs", findings) == ["a"] * number and not findings.items


@limit("isaac.recorded_graph.MAX_NAME")
def _(letters: int) -> bool:
    return bool(carried(["a" * letters], lambda name: [name], "graphs", Findings()))


# Scripts


@limit("isaac.omniverse.plain_data.MAX_TEXT", at=10)
def _(letters: int) -> bool:
    return accepts(lambda: plain_data.plain_data("x" * letters), UnknownError)


@limit("isaac.omniverse.plain_data.MAX_DEPTH")
def _(levels: int) -> bool:
    value: Any = 1
    for _ in range(levels):
        value = [value]
    return accepts(lambda: plain_data.plain_data(value), UnknownError)


@limit("isaac.omniverse.og_names.MAX_NAME")
def _(letters: int) -> bool:
    return accepts(lambda: og_names.checked("a" * letters, "a name"), OmniGraphError)


@limit("isaac.omniverse.og_edit.MAX_LOST", at=3)
def _(commands: int) -> bool:
    error = OmniGraphError()
    og_edit.name_lost(error, {"create_nodes": [(f"N{number}", "T") for number in range(commands)]}, 0)
    (note,) = error.__notes__
    return note.count(",") == commands - 1 and "…" not in note


def notes() -> ScriptNotes:
    return ScriptNotes(lambda hint: SPAN, lambda: (("", 0, 0), ()), assumed=False)


@limit("isaac.omniverse.script_notes.MAX_CALLS", at=3)
def _(calls: int) -> bool:
    made = notes()
    return accepts(lambda: repeat(calls, made.idle), EndlessError)


@limit("isaac.omniverse.script_notes.MAX_FRAMES", at=3)
def _(frames: int) -> bool:
    made = notes()
    made.frames.number = frames
    return accepts(made.idle, EndlessError)


@limit("isaac.omniverse.script_notes.MAX_PASSED_OVER", at=3)
def _(actions: int) -> bool:
    made = notes()
    for number in range(actions):
        made.pass_over(f"action {number}")
    return len(made.findings.items) == actions


@limit("isaac.omniverse.graph_recorder.MAX_PARTS", at=3)
def _(parts: int) -> bool:
    recorder = GraphRecorder(lambda hint: SPAN)
    return accepts(lambda: repeat(parts, recorder.count), OmniGraphError)


@limit("isaac.script.import_finder.MAX_ABOVE")
def _(levels: int, folder: Path) -> bool:
    (folder / "mine.py").touch()
    deep = folder.joinpath(*["d"] * levels)
    deep.mkdir(parents=True)
    finder = ImportFinder.__new__(ImportFinder)
    finder.folders = [str(deep)]
    return bool(list(finder._remedy("mine")))


@limit("isaac.script.losses.MAX_CAUGHT", at=3)
def _(errors: int) -> bool:
    losses = Losses(GraphRecorder(lambda hint: SPAN), None)  # type: ignore[arg-type]
    for number in range(errors):
        losses.note(ValueError(), number)
    return len(losses._caught) == errors


@limit("isaac.script.losses.MOST_CALLABLE", at=3)
def _(conditions: int) -> bool:
    recorder = GraphRecorder(lambda hint: SPAN)
    recorder.graphs["/g"] = RecordedGraph("/g")
    recorder.missed["a.py", 1] = {f"condition{number}": "" for number in range(conditions)}
    Losses(recorder, None).report_conditions()  # type: ignore[arg-type]
    return "more" not in recorder.findings.items[0].message


@limit("isaac.omniverse.stubs.MAX_SAID")
def _(letters: int) -> bool:
    recorder = GraphRecorder(lambda hint: SPAN)
    StubObject("carb.log_warn", recorder)("x" * letters)
    return list(recorder.said) == ["x" * letters]


@limit("isaac.script.script_process.MAX_LINE")
def _(letters: int) -> bool:
    recorder = GraphRecorder(lambda hint: SPAN)
    print("x" * letters, file=script_process._Printed(recorder))
    return list(recorder.said) == ["x" * letters]


def answered(module: Any, answer: bytes, action: Any) -> Any:
    """Return the result of `action` while the confined process of `module` gives this answer."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "ask", lambda *_: answer)
        return action()


def script(folder: Path, text: str, answer: ScriptAnswer, size: int = 0) -> list[str]:
    """Return the findings for a script whose confined process answers with `size` bytes."""
    path, findings = folder / "script.py", Findings()
    path.write_text(text, encoding="utf-8")
    answered(script_reader, encoded(answer).encode().ljust(size), lambda: script_reader.read_script(path, findings))
    return [finding.message for finding in findings.items]


@limit("isaac.script.script_reader.MAX_BYTES", at=50)
def _(size: int, folder: Path) -> bool:
    return not script(folder, "x = 1".ljust(size), ScriptAnswer())


@limit("isaac.script.script_reader.MAX_ANSWER", at=1000)
def _(size: int, folder: Path) -> bool:
    return not script(folder, "x = 1", ScriptAnswer(), size)


@limit("isaac.script.script_reader.MAX_STAGES", at=3)
def _(stages: int, folder: Path) -> bool:
    return not script(folder, "x = 1", ScriptAnswer(stages=[f"{number}.usda" for number in range(stages)]))


@limit("isaac.script.script_reader.MAX_RUNS")
def _(runs: int, folder: Path) -> bool:
    """Runs after which no prim is found that the script creates itself."""
    left = [ScriptAnswer(granted={"/a"}, prims={"/a"}, may_differ=True)] * (runs - 1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(script_reader, "_run_once", lambda *_: left.pop() if left else ScriptAnswer())
        return not script_reader._run_on_a_full_stage(folder / "a.py", {}, ScriptAnswer()).granted


# Stages


@limit("isaac.stage.graphs.MAX_DEPTH", at=3)
def _(levels: int, folder: Path) -> bool:
    inner = node("C")
    for number in range(levels):
        inner = compound(f"N{number}", inner)
    return "levels deep" not in read_graph(folder, inner).told


@limit("isaac.stage.graphs.MAX_LEVELS", at=5)
def _(levels: int) -> bool:
    reader = graphs._GraphReader.__new__(graphs._GraphReader)
    reader.prims = {"/G": StagePrim("/G", "OmniGraph")}
    return reader._graph_above("/G" + "/p" * levels) == "/G"


@limit("isaac.stage.graphs.MAX_PARTS", at=10)
def _(parts: int) -> bool:
    reader = graphs._GraphReader.__new__(graphs._GraphReader)
    reader.parts = 0
    return accepts(lambda: reader.count(parts), graphs.TooManyError)


@limit("descriptions.usd.layers.MAX_BYTES", at=1000)
def _(size: int, folder: Path) -> bool:
    (folder / "a.usda").write_text("#usda 1.0\n".ljust(size - 100, "#"), encoding="utf-8")
    stage = '#usda 1.0\n( subLayers = [@a.usda@]\n)\ndef "A" {}\n'.ljust(100, "\n")
    (folder / "stage.usda").write_text(stage, encoding="utf-8")
    contents = StageReading(Files.of(folder / "stage.usda")).run(folder / "stage.usda")
    assert not contents.failure
    return not contents.left_out


@limit("descriptions.usd.layers.MAX_LAYERS", at=3)
def _(layers: int, folder: Path) -> bool:
    names = [f"l{number}" for number in range(layers - 1)]
    text = f"#usda 1.0\n( subLayers = [{', '.join(f'@{name}.usda@' for name in names)}]\n)\n"
    return not read(folder, text, **dict.fromkeys(names, "#usda 1.0\n")).contents.left_out


@limit("descriptions.usd.layers.MOST_CHOICES", at=3)
def _(choices: int, folder: Path) -> bool:
    names = [f"v{number}" for number in range(choices)]
    sets = "".join(f'    variantSet "{name}" = {{ "a" {{\n}}\n}}\n' for name in names)
    listed = ", ".join(f'"{name}"' for name in names)
    text = f'#usda 1.0\ndef "A" (\n    variantSets = [{listed}]\n)\n{{\n{sets}}}\n'
    return len(read(folder, text).contents.choices) == choices


@limit("descriptions.usd.prim_spans.MAX_BYTES", at=50)
def _(size: int, folder: Path) -> bool:
    (folder / "a.usda").write_text('#usda 1.0\ndef "A" {}\n'.ljust(size, "#"), encoding="utf-8")
    return PrimSpans(folder / "a.usda").of("/A").line == 2


@limit("descriptions.usd.prim_spans.MAX_PATHS", at=10)
def _(characters: int, folder: Path) -> bool:
    (folder / "a.usda").write_text(f'#usda 1.0\ndef "{"A" * (characters - 1)}" {{}}\n', encoding="utf-8")
    return PrimSpans(folder / "a.usda").of(f"/{'A' * (characters - 1)}").line == 2


def stage(folder: Path, contents: StageContents, size: int = 0) -> list[str]:
    """Return the findings for a stage whose confined process answers with `size` bytes."""
    path, findings = folder / "a.usda", Findings()
    path.write_text("#usda 1.0\n", encoding="utf-8")
    answer = encoded(contents).encode().ljust(size)
    answered(
        stage_reader,
        answer,
        lambda: stage_reader.read_stage(path, Files.of(path), default_registry(), findings),
    )
    return [finding.message for finding in findings.items]


@limit("isaac.stage.stage_reader.MAX_ANSWER", at=1000)
def _(size: int, folder: Path) -> bool:
    return not stage(folder, StageContents(), size)


@limit("descriptions.usd.stage_files.MOST_TOLD", at=3)
def _(parts: int, folder: Path) -> bool:
    told = stage(folder, StageContents(left_out=[(f"/{number}", "why") for number in range(parts)]))
    return told == [f"/{number} is left out: why" for number in range(parts)]


@limit("descriptions.usd.stage_files.LONGEST")
def _(letters: int, folder: Path) -> bool:
    (told,) = stage(folder, StageContents(failure="x" * letters))
    return told.endswith(f" {'x' * letters}")


# Robots of stages


def physics(folder: Path, text: str) -> PhysicsContents:
    path = folder / "stage.usda"
    path.write_text(f"#usda 1.0\n{text}".replace(" }", "\n}"), encoding="utf-8")
    return PhysicsReading(Files.of(path)).run(path)


@limit("descriptions.usd.stage_physics_process.MAX_PRIMS", at=3)
def _(prims: int, folder: Path) -> bool:
    return not physics(folder, "".join(f'def "p{number}" {{ }}\n' for number in range(prims))).failure


@limit("descriptions.usd.stage_shapes.MAX_POINTS", at=24)
def _(points: int, folder: Path) -> bool:
    """A mesh of one triangle, whose points and corners count; points that no face uses are dropped."""
    corners = points - 4
    faces = f"int[] faceVertexCounts = [{', '.join(['3'] * (corners // 3))}]"
    indices = f"int[] faceVertexIndices = [{', '.join(str(n % 4) for n in range(corners // 3 * 3))}]"
    more = "" if corners % 3 == 2 else ", (1, 1, 1)"
    text = f'def Mesh "m" {{\npoint3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1){more}]\n{faces}\n{indices}\n }}\n'
    return not physics(folder, text).left_out


def robots(folder: Path, text: str) -> list[str]:
    """Return the errors of the robot of a stage."""
    path, findings = folder / "robot.usda", Findings()
    path.write_text(f"#usda 1.0\n{text}".replace(" }", "\n}"), encoding="utf-8")
    read_usd(path, Files.of(path), findings)
    return [finding.message for finding in findings.errors]


@limit("descriptions.usd.usd_reader.MAX_BODIES", at=3)
def _(bodies: int, folder: Path) -> bool:
    apis = '(\n    apiSchemas = ["PhysicsRigidBodyAPI"]\n)'
    told = robots(folder, "".join(f'def Xform "p{number}" {apis} {{ }}\n' for number in range(bodies)))
    return not any("bodies or joints" in message for message in told)


@limit("descriptions.usd.usd_reader.MAX_ANSWER", at=2000)
def _(size: int, folder: Path) -> bool:
    empty = PhysicsContents(failure="x" * (size - len(encoded(PhysicsContents()))))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(usd_reader, "ask", lambda *_: encoded(empty).encode())
        return "answers with more than" not in robots(folder, "")[0]


@limit("descriptions.usd.layers._MOST_USERS")
def _(users: int, folder: Path) -> bool:
    text = "".join(f'def "p{number}" (references = @gone.usd@) {{ }}\n' for number in range(users))
    ((_, why),) = physics(folder, text).left_out
    return why.count("/p") == users


@limit("descriptions.usd.stage_commands._MOST_INPUTS", at=3)
def _(names: int, folder: Path) -> bool:
    inputs = "\n".join(f'token inputs:input{number} = "j{number}"' for number in range(names))
    text = f"""def OmniGraphNode "A" {{
token node:type = "omni.graph.nodes.ConstructArray"
{inputs}
token[] outputs:array
}}
def OmniGraphNode "C" {{
token node:type = "isaacsim.core.nodes.IsaacArticulationController"
double[] inputs:velocityCommand = [1]
token[] inputs:jointNames.connect = </A.outputs:array>
}}
"""
    return len(physics(folder, text).commands[0].joints) == names
