"""Whatever a user gets wrong, the answer is a sentence and an exit code: no traceback, and nothing that steers a terminal."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

import pytest

from graphengine.cli import main
from graphengine.format.files import STAGE
from tests.cli.harness import ROOT, Graphrun, command, environment, live, process

STEERING = "\x1b[31mred\x07\x9b2J\x7f"  # colours, rings, clears the screen

FILES = {
    "empty.yaml": "",
    "comment.yaml": "# nothing yet\n",
    "word.yaml": "scene",
    "list.yaml": "- a\n- b\n",
    "open.yaml": "a: [",
    "tab.yaml": "graph: g\nnodes:\n\tTick: OnPlaybackTick\n",
    "tag.yaml": "graph: !!python/object:os.system g\n",
    "twice.yaml": "graph: g\ngraph: h\n",
    "kinds.yaml": "nodes: {}\n",
    "version.yaml": "format: 99\ngraph: g\n",
    "names.yaml": "graph: g\nnodes: {1: OnPlaybackTick, a b: OnPlaybackTick}\n",
    "wires.yaml": "graph: g\nnodes: {T: OnPlaybackTick}\nconnections: [T.tick, -> T, T.tick -> T.tick -> T.tick, 5]\n",
    "noworld.yaml": "scene: s\nworld: nowhere.xml\n",
    "badworld.yaml": "scene: s\nworld: world.xml\n",
    "world.xml": "<mujoco><worldbody><geom type='nothing'/></worldbody></mujoco>",
    "norobot.yaml": "scene: s\nworld: worlds/flat_grid.xml\nrobots: {r: {use: nowhere.yaml}}\n",
    "self.yaml": "scene: s\nworld: worlds/flat_grid.xml\nrobots: {r: {use: self.yaml}}\ngraphs: {g: {use: self.yaml}}\n",
    "endless.yaml": "robot: r\nextends: endless.yaml\n",
    "endless_scene.yaml": "scene: s\nworld: worlds/flat_grid.xml\nrobots: {r: {use: endless.yaml}}\n",
    "fine.py": "GRAVITY = 9.81\n",
    "raises.py": "1 / 0\n",
    "syntax.py": "def f(:\n",
    "leaves.py": "import sys\nsys.exit(0)\n",
    "lacks.py": "import nowhere_at_all\n",
    "clash.py": "from graphengine.node import Node\n\n\n"
    'class Tick(Node, type="omni.graph.action.OnPlaybackTick"):\n    """Fires."""\n',
    "unported.py": "from graphengine.node import In, Node\n\n\n"
    'class A(Node, type="mistake.A"):\n    """Adds."""\n\n    a: float = In(default="five")\n',
}

USAGE = [
    [],
    ["ru"],
    ["run"],
    ["check"],
    ["show"],
    ["topics"],
    ["schema"],
    ["schema", "scenes"],
    ["run", "a", "b"],
    ["run", "dd100_flat", "--fro", "10s"],
    ["run", "dd100_flat", "--for"],
    ["run", "dd100_flat", "--for=-1s"],
    ["run", "dd100_flat", "--seed", "1.5"],
    ["run", "dd100_flat", "--set", "Diff.wheelRadius=1"],
    ["run", "dd100_flat", "--set", "*.topicName=a: b: c"],
    ["run", "nowhere"],
    ["run", ""],
    ["run", "."],
    ["run", "a\0b"],
    ["check", "/dev/null"],
    ["check", "world.xml"],
    ["check", "raises.py"],
    ["check", "dd100_flat", "--format", "xml"],
    ["check", "x" * 5000],
    ["show", "clock", "--plan", "--schedule"],
    ["nodes", "Nowhere"],
    ["nodes", "Tick", "Tock"],
    *(["nodes", "--import", module] for module in ("", ".", ".x", "a b")),
]

ERRORS = [
    *(["check", name] for name in FILES if name.endswith(".yaml") and name != "endless.yaml"),
    ["check", "endless.yaml"],
    ["check", "robots/dd100"],
    ["check", "sensors/lidar_360"],
    ["check", sys.executable],
    ["run", "open.yaml", "--transport", "memory"],
    ["show", "names.yaml", "--plan"],
    ["topics", "noworld.yaml"],
    ["nodes", "--import", "clash"],
    ["run", "dd100_flat", "--set", "*.wheelRadius=wide"],
    ["run", "dd100_flat", "--set", "*.wheelRadius="],
    ["run", "dd100_flat", "--set", "*.wheelRadius=[1, 2]"],
    ["run", "dd100_flat", "--set", "*.targetPrim=/nowhere"],
]


@pytest.fixture
def folder(project: Path) -> Path:
    for name, text in FILES.items():
        (project / name).write_text(text, encoding="utf-8")
    return project


def shown(arguments: list[str]) -> str:
    return " ".join(argument[:30] for argument in arguments) or "nothing"


@pytest.mark.parametrize("arguments", USAGE, ids=shown)
def test_an_invalid_command_line_is_reported(graphrun: Graphrun, folder: Path, arguments: list[str]) -> None:
    result = graphrun(*arguments, code=2, out="")
    assert result.err.startswith(("graphrun: ", "graphrun "))
    assert "usage: " not in result.err
    assert "Traceback" not in result.err


@pytest.mark.parametrize("arguments", ERRORS, ids=shown)
def test_an_invalid_file_or_value_is_reported(graphrun: Graphrun, folder: Path, arguments: list[str]) -> None:
    result = graphrun(*arguments, code=1)
    assert "error" in result.out + result.err
    assert "Traceback" not in result.out + result.err


@pytest.mark.parametrize("arguments", [["run", "open.yaml"], ["nodes", "--import", "raises"], ["check", "tag.yaml"]])
def test_mistakes_in_a_new_process_show_no_traceback(folder: Path, arguments: list[str]) -> None:
    result = process(*arguments, cwd=folder)
    assert result.code in (1, 2)
    assert "Traceback" not in result.out + result.err


@pytest.mark.parametrize(
    ("module", "complaint"),
    [
        ("raises", "ZeroDivisionError: division by zero (raises.py:1)"),
        ("syntax", "SyntaxError: invalid syntax (syntax.py, line 1)"),
        ("leaves", "SystemExit: 0 (leaves.py:2)"),
        ("lacks", "No module named 'nowhere_at_all' (lacks.py:1)"),
        ("unported", "TypeError: A.a: default 'five': expected a number (unported.py:4)"),
        ("fine.py", "write the name of the module, fine"),
        ("./fine.py", "write the name of a module, such as my_robot.nodes"),
        ("nowhere", "No module named 'nowhere'"),
    ],
)
def test_a_module_that_cannot_be_imported_is_reported_with_its_line(
    graphrun: Graphrun, folder: Path, module: str, complaint: str
) -> None:
    graphrun("nodes", "--import", module, code=2, out="", err=f"graphrun nodes: --import {module}: {complaint}\n")


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("ROS_DOMAIN_ID", "robot"),
        ("ROS_DOMAIN_ID", "233"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOT"),
        ("ROS_LOCALHOST_ONLY", "yes"),
    ],
)
def test_an_invalid_environment_is_reported(
    graphrun: Graphrun, folder: Path, monkeypatch: pytest.MonkeyPatch, variable: str, value: str
) -> None:
    monkeypatch.setenv(variable, value)
    result = graphrun("run", "mine.yaml", "--for", "100ms", "--transport", "dds", code=1)
    assert result.err.startswith(f"error: {variable} is {value!r}\n")
    assert "legal: " in result.err


def test_a_scene_whose_name_is_no_name_of_a_node_runs_on_the_network(graphrun: Graphrun, project: Path) -> None:
    (project / "mine.yaml").rename(project / "01 größe.yaml")
    result = graphrun("run", "01 größe.yaml", "--for", "100ms", "--transport", "dds")
    assert result.code == 0, result.err


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["chek", "dd100_flat"], "did you mean 'check'?"),
        (["topic", "inof", "/scan"], "did you mean 'info'?"),
        (["run", "dd100_flat", "--fro", "10s"], "did you mean '--for'?"),
        (["run", "dd100_flat", "--transport=dsd"], "did you mean 'dds'?"),
        (["topic", "pub", "/a", "std_msgs/String", "--ocne"], "did you mean '--once'?"),
        (["import", "x.py", "--forse"], "did you mean '--force'?"),
    ],
)
def test_a_mistyped_verb_or_option_gets_a_suggestion(graphrun: Graphrun, arguments: list[str], hint: str) -> None:
    result = graphrun(*arguments, code=2, out="")
    assert result.err.splitlines()[-2] == f"  {hint}"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["rnu"], "graphrun: no verb 'rnu'\n  did you mean 'run'?"),
        (["xyzzy"], "graphrun: no verb 'xyzzy'"),  # the help has the 28 verbs
        (["topic", "zzz"], "graphrun topic: no verb 'zzz'\n  choose from: list, info, echo, hz, delay, pub"),
        (["schema", "zzz"], "graphrun schema: no kind 'zzz'\n  choose from: graph, scene, robot"),
        (
            ["run", "dd100_flat", "--rays", "none"],
            "graphrun run: argument --rays: invalid choice: 'none'\n  choose from: auto, mujoco, fast",
        ),
    ],
)
def test_an_illegal_value_is_answered_with_a_guess_or_a_short_list(
    graphrun: Graphrun, arguments: list[str], said: str
) -> None:
    graphrun(*arguments, code=2, out="", err=f"{said}\n  see {said.partition(':')[0]} --help\n")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "my robot.urdf"], "a description\n  graphrun import-robot 'my robot.urdf' -o robots/NAME.yaml"),
        (["check", "fine.py"], "a script of Isaac Sim\n  graphrun import fine.py"),
        (["show", "out.mcap"], "a recording\n  graphrun replay out.mcap"),
        (["import", "my robot.urdf"], "a description\n  graphrun import-robot 'my robot.urdf' -o robots/NAME.yaml"),
        (["import-robot", "fine.py", "-o", "x.yaml"], "a script of Isaac Sim\n  graphrun import fine.py"),
        (["run", "hall.usda"], f"a {STAGE}\n  graphrun import hall.usda"),
    ],
)
def test_a_file_of_another_kind_is_answered_with_the_verb_for_it(
    graphrun: Graphrun, folder: Path, arguments: list[str], said: str
) -> None:
    (folder / "my robot.urdf").write_text("<robot name='r'/>", encoding="utf-8")
    for other in ("out.mcap", "hall.usda"):
        (folder / other).touch()
    verb, name, *_ = arguments
    graphrun(*arguments, code=2, out="", err=f"graphrun {verb}: {name}: {said}\n")


@pytest.mark.parametrize(
    ("scene", "at"),
    [
        ("world: flat.xml\nrobots: {r: {use: r.yaml}}", "r.yaml:2:7"),
        ("world: flat.xml\ngraphs: {g: {use: hall.usda, at: /World/g}}", "s.yaml:3:19"),
    ],
)
def test_a_usd_stage_as_a_graph_or_urdf_is_refused_with_the_supported_uses(
    graphrun: Graphrun, folder: Path, scene: str, at: str
) -> None:
    for name, text in (
        ("hall.usda", "#usda 1.0\n"),
        ("flat.xml", "<mujoco/>"),
        ("r.yaml", "robot: r\nurdf: hall.usda\n"),
    ):
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "s.yaml").write_text(f"scene: s\n{scene}\n", encoding="utf-8")
    told = graphrun("check", "s.yaml").out
    assert f"{at}: error S101: " in told
    assert f"'hall.usda' is a {STAGE}" in told
    assert "graphrun import hall.usda" in told


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "graphrun: VERB is missing\n  see"),
        (["nav2"], "graphrun nav2: VERB is missing\n  choose from: files, goals\n  see"),
        (["schema"], "graphrun schema: kind is missing\n  choose from: graph, scene, robot\n  see"),
        (["robots", "clock"], "graphrun robots: a graph alone has no robots and no robot states; give a scene with"),
        (["map", "dd100_flat"], "give its bounds: --bounds XMIN YMIN XMAX YMAX\n"),
        (["replay", "nope.mcap"], "graphrun replay: no file 'nope.mcap'\n"),
        (["snapshot", "dd100_flat", "-o", "a.png", "--page", "x"], "unrecognized arguments: --page x\n  see"),
    ],
)
def test_missing_arguments_and_files_are_named(
    graphrun: Graphrun, folder: Path, arguments: list[str], said: str
) -> None:
    assert said in graphrun(*arguments, code=2, out="").err


def test_long_messages_are_wrapped_between_words_on_a_terminal(folder: Path) -> None:
    with live("check", "xyzzy", cwd=folder, columns=80) as running:
        running.hear(lambda said: False)
    lines = running.said.replace("\r", "").splitlines()
    assert max(map(len, lines)) <= 80
    assert " ".join(running.said.split()) == " ".join(process("check", "xyzzy", cwd=folder).err.split())


def test_a_command_in_a_message_is_not_wrapped_on_a_terminal(folder: Path) -> None:
    name = f"{'long' * 20} name.urdf"
    (folder / name).touch()
    with live("run", name, cwd=folder, columns=80) as running:
        running.hear(lambda said: False)
    assert f"  graphrun import-robot '{name}' -o robots/NAME.yaml" in running.said.replace("\r", "").splitlines()


def test_a_quoted_path_with_spaces_is_not_wrapped_on_a_terminal(folder: Path) -> None:
    name = "./my folder/the hall of my robots/and its neighbours/first.yaml"
    with live("run", name, cwd=folder, columns=70) as running:
        running.hear(lambda said: False)
    assert f"  '{name}'" in running.said.replace("\r", "").splitlines()


# Control characters


STEERED = [
    [STEERING],
    [f"--{STEERING}"],
    ["run", STEERING],
    ["run", "mine.yaml", STEERING],
    ["run", "mine.yaml", f"--{STEERING}"],
    ["run", "mine.yaml", "--for", STEERING],
    ["run", "mine.yaml", "--rate", STEERING],
    ["run", "mine.yaml", "--seed", STEERING],
    ["run", "mine.yaml", "--scene", STEERING],
    ["run", "mine.yaml", "--allow", STEERING],
    ["run", "mine.yaml", "--transport", STEERING],
    ["run", "mine.yaml", "--set", STEERING],
    ["run", "mine.yaml", "--set", f"{STEERING}.a=1"],
    ["run", "mine.yaml", "--set", f"Clock.{STEERING}=1"],
    ["run", "mine.yaml", "--set", f"Clock.topicName={STEERING}"],
    ["check", STEERING],
    ["nodes", STEERING],
    ["nodes", "--import", STEERING],
    ["schema", STEERING],
    *([verb, f"{STEERING}.yaml"] for verb in ("check", "show", "topics", "run")),
    *([verb, "steering.yaml"] for verb in ("check", "topics", "run")),
    *(["show", "steering.yaml", *form] for form in ([], ["--plan"], ["--schedule"], ["--mermaid"])),
    ["check", "steering.yaml", "--format", "json"],
    ["topics", "steering.yaml", "--format", "json"],
    ["check", "broken.yaml"],
    ["run", "raising.yaml", "--import", "steering_nodes"],
    ["run", "raising.yaml", "--import", "steering_nodes", "--keep-going"],
]

ESCAPED = r"\e[31mred\a\x9b2J\x7f\n"

STEERING_GRAPH = f"""graph: g
doc: "{ESCAPED}"
at: "/World/{ESCAPED}"
nodes:
  Tick: OnPlaybackTick
  Tf: {{type: PublishRawTransformTree, inputs: {{parentFrameId: "{ESCAPED}", childFrameId: "b{ESCAPED}"}}}}
connections: [Tick.tick -> Tf.execIn]
"""

STEERING_NODES = f'''from graphengine.node import Context
from graphengine.node import ExecIn, Node


class Raises(Node, type="steering.Raises"):
    """Raises."""

    exec_in = ExecIn()

    def setup(self, context: Context) -> None:
        """Speak."""
        context.log("warning", {STEERING!r})

    def compute(self) -> None:
        """Raise."""
        raise RuntimeError({STEERING!r})
'''


@pytest.mark.parametrize("arguments", STEERED, ids=lambda arguments: ascii(shown(arguments)))
def test_the_output_has_no_control_characters(graphrun: Graphrun, project: Path, arguments: list[str]) -> None:
    (project / f"{STEERING}.yaml").write_text((project / "mine.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    (project / "steering.yaml").write_text(STEERING_GRAPH, encoding="utf-8")
    (project / "broken.yaml").write_text(f'graph: "{ESCAPED}"\n"{ESCAPED}": 1\nruns: "{ESCAPED}"\n', encoding="utf-8")
    raising = "graph: g\nnodes: {T: OnPlaybackTick, R: steering.Raises}\nconnections: [T.tick -> R.execIn]\n"
    (project / "raising.yaml").write_text(raising, encoding="utf-8")
    (project / "steering_nodes.py").write_text(STEERING_NODES, encoding="utf-8")
    runs = arguments[:1] == ["run"] and STEERING not in arguments
    result = graphrun(*arguments, *(["--transport", "memory", "--for", "100ms"] if runs else []))
    said = result.out + result.err
    assert [c for c in said if not (c.isprintable() or c == "\n")] == []
    assert "red" in said or "is missing" in said or result.code == 0


def test_ctrl_c_before_a_verb_has_begun_ends_the_program_as_later(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(verb: str, plugin: str | None) -> argparse.ArgumentParser:
        raise KeyboardInterrupt

    monkeypatch.setattr("graphengine.cli.make_parser", interrupt)
    assert main(["nodes"]) == 130


# Streams


@pytest.mark.parametrize("arguments", [["nodes"], ["schema", "graph"], ["check", "dd100_flat", "--format", "json"]])
def test_a_closed_pipe_is_no_error(arguments: list[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        command(*arguments), cwd=ROOT, env=environment(), stdout=writing, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writing)
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr


@pytest.mark.parametrize("arguments", [["schema", "graph"], ["nodes", "OnTick"], ["check", "clock"]])
def test_a_full_disk_is_reported(arguments: list[str]) -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(
            command(*arguments),
            cwd=ROOT,
            env=environment(),
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert (done.returncode, done.stderr) == (1, "error: No space left on device\n")


def test_characters_unknown_to_the_terminal_are_printed_as_numbers(project: Path) -> None:
    (project / "mine.yaml").write_text("graph: g\nnodes: {T: OnPlaybackTick}\nconnections: [T → T]\n", encoding="utf-8")
    result = process("check", "mine.yaml", cwd=project, env={"PYTHONIOENCODING": "ascii"}, code=1)
    assert "     3 | connections: [T \\u2192 T]" in result.lines


def test_a_run_needs_no_standard_error(project: Path) -> None:
    script = 'exec "$0" -m graphengine.cli run mine.yaml --for 100ms --transport memory 2>&-'
    done = subprocess.run(["sh", "-c", script, sys.executable], cwd=project, env=environment(), check=False)
    assert done.returncode == 0


def test_a_run_continues_if_its_output_cannot_be_written(project: Path) -> None:
    script = 'exec "$0" -m graphengine.cli run mine.yaml --for 100ms --transport memory --record out.mcap 2>/dev/full'
    done = subprocess.run(["sh", "-c", script, sys.executable], cwd=project, env=environment(), check=False)
    assert done.returncode == 0
    assert process("replay", "out.mcap", cwd=project).code == 0
