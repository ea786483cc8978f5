"""ScriptNode, IsaacReadEnvVar and IsaacReadFilePath: alone, in graphs, and what they may not do unless a user says so."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import ContextError, NodeError
from graphengine.format.files import Files
from graphengine.format.permissions import LARGEST_FILE, Permissions
from graphengine.messages.definitions import DEFINITIONS
from graphengine.node import Node
from graphengine.node.node_class import grown
from graphengine.nodes.core.outside import IsaacReadEnvVar, IsaacReadFilePath
from graphengine.nodes.script import ScriptNode
from graphengine.scene.loaded_scene import Options
from graphengine.testing import RecordingContext
from tests.nodes.harness import Player, Playing, computed, ready


def context(**permissions: Any) -> RecordingContext:
    made = RecordingContext()
    made.services.permissions = Permissions(**{"scripts": True, **permissions})
    return made


def scripted(text: str, *attributes: str, where: RecordingContext | None = None, **inputs: Any) -> Any:
    """A node with a script and attributes, set up."""
    made: type[Node] = grown(ScriptNode, {"attributes": list(attributes)}, DEFINITIONS)
    fields = {f"inputs_{name}": value for name, value in inputs.items()}
    return ready(made, where or context(), script=textwrap.dedent(text), attributes=list(attributes), **fields)


DOUBLE = """
def compute(db):
    db.outputs.command = [db.inputs.speed, 2 * db.inputs.speed]
"""


def test_a_script_computes_outputs_from_inputs() -> None:
    node = scripted(DOUBLE, "inputs:speed double", "outputs:command double[]", speed=1.5)
    assert node.compute() == node.exec_out
    assert node.outputs_command.dtype == np.float64
    assert node.outputs_command.tolist() == [1.5, 3.0]


STATEFUL = """
    import math
    step = 1
    def setup(db):
        db.per_instance_state.total = 10
    def compute(db):
        db.internal_state.total += step
        db.outputs.total = db.per_instance_state.total
        db.log_info("computed")
        return db.internal_state.total < 13
    def cleanup(db):
        db.log_warn(f"cleaned up at {db.internal_state.total}")
    """


COUNTING = """
    import math
    count, seen = 0, []
    def compute(db):
        global count
        count += 1
        seen.append(count)
        db.per_instance_state.last = seen
        db.outputs.total = len(seen) + 10 * count
"""


def test_restoring_a_checkpoint_restores_the_variables_of_a_script() -> None:
    node = scripted(COUNTING, "outputs:total int")
    totals = []
    node.compute()
    saved = node.save()
    for _ in range(2):
        for _ in range(3):
            node.compute()
            totals.append(node.outputs_total)
        node.restore(saved)
    assert totals == [22, 33, 44] * 2


def test_a_checkpoint_from_before_the_first_execution_restarts_the_script() -> None:
    node = scripted(COUNTING, "outputs:total int")
    saved = node.save()
    node.compute()
    node.restore(saved)
    node.compute()
    assert node.outputs_total == 11


def test_the_error_of_a_variable_that_cannot_be_copied_names_it(tmp_path: Path) -> None:
    node = scripted("import sys\ndef compute(db):\n    db.per_instance_state.lines = (line for line in 'ab')\n")
    node.compute()
    with pytest.raises(
        TypeError, match="the script's variable lines cannot be saved in a checkpoint: cannot pickle 'generator'"
    ):
        node.save()


def test_a_script_is_set_up_once_and_cleans_up_at_a_stop() -> None:
    where = context()
    node = scripted(STATEFUL, "outputs:total int64", where=where)
    assert [node.compute() for _ in range(3)] == [node.exec_out, node.exec_out, None]
    where.stop(node)
    assert where.logged[-1] == ("warning", "cleaned up at 13")
    assert node.outputs_total == 0
    node.compute()
    assert node.outputs_total == 11


def test_a_script_sees_its_inputs_when_it_is_set_up() -> None:
    text = """
    def setup(db):
        db.outputs.total = db.per_instance_state.first = db.inputs.speed
    def compute(db):
        db.outputs.total += db.per_instance_state.first
    """
    node = scripted(text, "inputs:speed double", "outputs:total double", speed=1.5)
    assert [(node.compute(), node.outputs_total)[1] for _ in range(2)] == [3.0, 4.5]


def test_a_script_cleans_up_when_its_context_is_closed() -> None:
    where = context()
    node = scripted(STATEFUL, "outputs:total int64", where=where)
    node.compute()
    where.close()
    assert where.logged[-1] == ("warning", "cleaned up at 11")


def test_a_script_without_a_compute_fires() -> None:
    node = scripted("x = 1\n")
    assert node.compute() == node.exec_out


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "def compute(db):\n    x = 1\n    raise KeyError('wheel')\n",
            r"line 3 \(raise KeyError\('wheel'\)\): KeyError: 'wheel'",
        ),
        ("1 / 0\n", r"line 1 \(1 / 0\): ZeroDivisionError"),
        ("import sys\ndef setup(db):\n    sys.exit(3)\n", r"line 3 \(sys.exit\(3\)\): SystemExit: 3"),
        (
            "def compute(db):\n    db.inputs.nothing\n",
            "line 2 .*the node declares no attribute 'nothing'; declared: ranges",
        ),
        ("def compute(db):\n    db.inputs.ranges[0] = 1.0\n", "line 2 .*read-only"),
        ("import omni.graph.core as og\n", "line 1 .*ModuleNotFoundError"),
    ],
)
def test_an_error_names_the_line_of_the_script(text: str, told: str) -> None:
    node = scripted(text, "inputs:ranges double[]", ranges=[1.0])
    with pytest.raises(RuntimeError, match=f"<script of /World/graph/node>, {told}"):
        node.compute()


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            "db.outputs.command = 'fast'",
            r"db.outputs.command has the type double\[\]: expected a list of double, got 'fast'",
        ),
        ("db.outputs.comand = []", "db.outputs.comand is not a declared output.*did you mean 'command'"),
        (
            "db.outputs.count = 2**40",
            "db.outputs.count has the type int: expected a value from -2147483648 to 2147483647",
        ),
    ],
)
def test_an_output_of_the_wrong_type_is_reported(line: str, told: str) -> None:
    node = scripted(f"def compute(db):\n    {line}\n", "outputs:command double[]", "outputs:count int")
    with pytest.raises((TypeError, ValueError), match=told):
        node.compute()


def test_a_script_has_no_access_to_its_node() -> None:
    node = scripted(
        "def compute(db):\n    db.outputs.names = sorted(n for n in dir(db) if n[0] != '_')\n", "outputs:names token[]"
    )
    node.compute()
    methods = {"log_error", "log_info", "log_warn", "log_warning"}
    assert set(node.outputs_names) == {"inputs", "outputs", "internal_state", "per_instance_state"} | methods


def test_a_syntax_error_is_reported_before_the_run_with_its_line() -> None:
    with pytest.raises(ContextError, match=r"<script of /World/graph/node>: line 2: "):
        scripted("def compute(db):\n    return (\n")
    with pytest.raises(ContextError, match="null bytes"):
        scripted("x = '\0'")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("speed double", "declares no attribute"),
        ("inputs:speed", "is not a port type"),
        ("inputs:speed dubble", "'dubble' is not a port type"),
        ("inputs:a b double", "is not a port type"),
        ("inputs:__class__ double", "declares no attribute"),
        ("inputs:x bundle", "cannot have a bundle"),
        ("inputs:execIn execution", "inputs:execIn already exists"),
        ("inputs:script string", "inputs:script already exists"),
        ("outputs:execOut double", "outputs:execOut already exists"),
    ],
)
def test_an_invalid_declaration_is_reported(text: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        scripted("", text)


GRAPH = """
nodes:
  Tick: OnPlaybackTick
  Double:
    type: ScriptNode
    inputs:
      attributes: ["inputs:speed double", "inputs:by int", "outputs:command double[]"]
      by: 2
      script: |
        def compute(db):
            db.outputs.command = [db.inputs.speed * db.inputs.by] * 2
  Each: ForEach
connections:
  - Tick.tick -> Double.execIn
  - Tick.time -> Double.speed
  - Double.execOut -> Each.execIn
  - Double.command -> Each.arrayIn
"""


BRANCHES = """
def compute(db):
    db.outputs.first = db.inputs.fromTick
    db.outputs.last = db.inputs.execIn
    db.outputs.execOut = False
"""


@pytest.mark.parametrize(("entry", "fired"), [("exec_in", "last"), ("inputs_fromTick", "first")])
def test_a_script_reads_the_fired_execution_inputs_and_fires_the_outputs_that_it_sets(entry: str, fired: str) -> None:
    declared = ("inputs:fromTick execution", "outputs:first execution", "outputs:last execution")
    node = scripted(BRANCHES, *declared)
    node.exec_in = node.inputs_fromTick = 0
    setattr(node, entry, 1)
    assert node.compute() == getattr(node, f"outputs_{fired}")


ANY = """
nodes:
  Tick: OnPlaybackTick
  Script:
    type: ScriptNode
    inputs:
      attributes: ["inputs:go execution", "outputs:done execution", "inputs:what any", "outputs:out any"]
      script: |
        def compute(db):
            db.outputs.out = 2 * db.inputs.what
            db.outputs.done = db.inputs.go
  Clock: {type: ROS2PublishClock, inputs: {topicName: doubled}}
connections:
  - Tick.tick -> Script.go
  - Tick.time -> Script.what
  - Script.done -> Clock.execIn
  - Script.out -> Clock.timeStamp
"""


def test_ports_of_any_type_take_their_types_from_their_wires(play: Player) -> None:
    playing = play_allowed(play, ANY).tick(3)
    assert playing.node("Clock").time_stamp == pytest.approx(2 * 3 / 60)


def play_allowed(play: Player, text: str = GRAPH) -> Playing:
    return play.graph(text, options=Options(scripts=True))


def test_a_script_node_is_wired_like_any_node(play: Player) -> None:
    playing = play_allowed(play).tick(3)
    assert playing.node("Each").element == 2 * 3 / 60


def test_without_permission_a_graph_file_runs_no_script(play: Player, tmp_path: Path) -> None:
    made = tmp_path / "made"
    text = GRAPH.replace(
        "def compute(db):", f"import pathlib\n        pathlib.Path({str(made)!r}).touch()\n        def compute(db):"
    )
    refusal = "Double: the node runs Python code, but graphs are not permitted to run code by default"
    with pytest.raises(CheckError, match=refusal) as refused:
        play.graph(text)
    assert "--allow-scripts" in str(refused.value)
    assert not made.exists()
    playing = play_allowed(play, text)
    assert not made.exists()  # a check compiles, and runs nothing
    playing.tick()
    assert made.exists()


def test_an_error_stops_the_run_and_names_node_and_line(play: Player) -> None:
    playing = play_allowed(play, GRAPH.replace("db.inputs.speed *", "db.inputs.sped *"))
    with pytest.raises(NodeError, match=r"node Double .*<script of .*/Double>, line 2 \(.*\): AttributeError"):
        playing.tick()


def test_a_script_file_outside_the_graphs_folder_is_refused(play: Player, tmp_path: Path) -> None:
    text = GRAPH.replace("script: |", "usePath: true\n      scriptPath: double.py\n      script: |")
    (play.folder / "double.py").write_text(DOUBLE, "utf-8")
    playing = play_allowed(play, text).tick()
    assert playing.node("Each").element == 2 / 60
    outside = tmp_path.parent / f"{tmp_path.name}_outside.py"
    outside.write_text(DOUBLE, "utf-8")
    with pytest.raises(CheckError, match="lies outside the folder of the file you gave"):
        play_allowed(play, text.replace("double.py", f"../{outside.name}"))


# IsaacReadEnvVar


def test_an_environment_variable_is_read_if_it_is_allowed_by_name() -> None:
    node = computed(IsaacReadEnvVar, context(environment={"ROBOT": "dd100"}), env_var="ROBOT")
    assert node.value == "dd100"


def test_an_environment_variable_that_is_set_but_not_allowed_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SECRET_TOKEN", "hidden")
    with pytest.raises(ContextError, match="'SECRET_TOKEN' may not be read") as refused:
        ready(IsaacReadEnvVar, context(), env_var="SECRET_TOKEN")
    assert "allow it with --env SECRET_TOKEN" in str(refused.value)
    assert "hidden" not in str(refused.value)


VARIABLE = """
nodes: {Tick: OnPlaybackTick, Name: {type: ReadEnvVar, inputs: {envVar: ROBOT}}, Print: PrintText}
connections: [Tick.tick -> Print.execIn, Name.value -> Print.text]
"""


def test_graphrun_check_names_the_environment_variable_that_a_graph_needs(play: Player) -> None:
    with pytest.raises(CheckError, match="the environment variable 'ROBOT' may not be read"):
        play.graph(VARIABLE)
    playing = play.graph(VARIABLE, options=Options(environment={"ROBOT": "dd100"})).tick()
    assert playing.node("Print").text == "dd100"


# IsaacReadFilePath


def test_a_file_beside_the_graph_is_read(tmp_path: Path) -> None:
    (tmp_path / "greeting.txt").write_text("grüß\n", "utf-8")
    where = context(files=Files.of(tmp_path / "graph.yaml"))
    node = computed(IsaacReadFilePath, where, path=str(tmp_path / "greeting.txt"))
    assert node.file_contents == "grüß\n"


def test_the_text_of_a_file_fits_an_input_of_any_type(play: Player) -> None:
    nodes = (
        "{Tick: OnPlaybackTick, File: {type: ReadFilePath, inputs: {path: graph.yaml}}, Text: ToString, Say: PrintText}"
    )
    wires = "[Tick.tick -> Say.execIn, File.fileContents -> Text.value, Text.converted -> Say.text]"
    playing = play.graph(f"nodes: {nodes}\nconnections: {wires}\n").tick()
    assert playing.node("Say").text.startswith("format: 1")


@pytest.mark.parametrize(
    ("data", "told"),
    [(b"\xff\xfe", "is not UTF-8 text"), (b"a" * (LARGEST_FILE + 1), "is larger than"), (None, "no file")],
)
def test_the_error_of_an_unreadable_file_gives_the_reason(tmp_path: Path, data: bytes | None, told: str) -> None:
    path = tmp_path / "data.txt"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(ContextError, match=told):
        ready(IsaacReadFilePath, context(files=Files.of(tmp_path / "graph.yaml")), path=str(path))


def test_a_file_outside_the_allowed_folders_is_refused(play: Player) -> None:
    text = VARIABLE.replace(
        "{type: ReadEnvVar, inputs: {envVar: ROBOT}}", "{type: ReadFilePath, inputs: {path: /etc/hostname}}"
    )
    with pytest.raises(CheckError, match="lies outside the folder of the file you gave"):
        play.graph(text.replace("Name.value", "Name.fileContents"))
