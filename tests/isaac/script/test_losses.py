"""Scripts that lose a part of their graphs on the way and go on: each loss is a warning at its place."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from graphengine.isaac.script.losses import TimeIsUpError
from graphengine.isaac.script.script_reader import ScriptOptions
from graphengine.isaac.script.script_run import ScriptRun
from tests.isaac.harness import Read, read_text

START = """\
import omni.graph.core as og
from isaacsim.sensors.camera import Camera, get_camera
keys = og.Controller.Keys
TICK = {"create_nodes": [("Tick", "omni.graph.action.OnTick")]}
og.Controller.edit("/A", TICK)
def fails(text="b"):
    return {}[text]
def build(path="/B"):
    og.Controller.edit(path, TICK)
def publish(name):
    og.Controller.edit("/A", {
        keys.CREATE_NODES: [(name, "x.Publish"), (name + "_info", "x.Info")],
        keys.SET_VALUES: [(name + ".inputs:topic", "")],
    })
"""
LINES = START.count("\n")


def told(folder: Path, text: str, **options: Any) -> Read:
    return read_text(folder, text, START, seconds=5.0, options=ScriptOptions(**options))


@pytest.mark.parametrize(
    ("camera", "first", "second"),
    [
        ("Camera(prim_path=path).prim_path.split('/')[-1]", "a", "b"),
        ("Camera(path).name", "<unknown: isaacsim.sensors.camera.Camera().name>", "Camera(#2).name>"),
        ("get_camera(Camera(path))", "<unknown: isaacsim.sensors.camera.get_camera()>", "get_camera(#2)>"),
        ("Camera().names[path]", "<unknown: isaacsim.sensors.camera.Camera().names[…]>", "names[…#2]>"),
        ("Mine(path).prim_path", "/World/a", "/World/b"),
    ],
)
def test_nodes_that_are_called_by_what_a_script_gave_are_told_apart(
    camera: str, first: str, second: str, tmp_path: Path
) -> None:
    text = "class Mine(Camera):\n    def __init__(self, path):\n        super().__init__(prim_path=path)\n"
    text += f"for path in ('/World/a', '/World/b'):\n    publish('Publish_' + str({camera}).lstrip('/'))"
    (graph,), warnings, _ = told(tmp_path, text)
    assert warnings == []
    names = list(graph.nodes)[1::2]
    assert names[0] == "Publish_" + first.lstrip("/")
    assert names[1].endswith(second.lstrip("/"))


CAMERA = "<unknown: isaacsim.sensors.camera.get_camera()>"
AGAIN = "og.Controller.edit({'graph_path': '/A'}, TICK)"


@pytest.mark.parametrize(
    ("text", "line", "lost"),
    [
        (
            "for _ in range(2):\n    try: publish(str(get_camera()))\n    except Exception as error: print(error)",
            -3,
            f"create_nodes {CAMERA}, create_nodes {CAMERA}_info, set_values {CAMERA}.inputs:topic",
        ),
        (f"try: {AGAIN}\nexcept Exception: pass", 1, "create_nodes Tick"),
        (f"import contextlib\nwith contextlib.suppress(Exception):\n    {AGAIN}", 3, "create_nodes Tick"),
        ("try: og.Controller.create_node('/A/Tick', 'x.T')\nexcept Exception: pass", 1, "the failed call"),
        ("try: og.Controller.graph('/A').create_node('Tick', 'x.T')\nexcept Exception: pass", 1, "the failed call"),
    ],
)
def test_a_refused_call_names_all_that_is_lost(text: str, line: int, lost: str, tmp_path: Path) -> None:
    _, (warning,), _ = told(tmp_path, text)
    assert warning.startswith(f"{line}: there is a ")
    assert warning.endswith(f" already; the script continues, but did not execute: {lost}")


ERROR = "the error at line {}: KeyError: 'b'"
LOST = ERROR.format(7)
NEXT = f"the condition at line {LINES + 2}"
QUIET = "class Q:\n    __enter__ = print\n    def __exit__(self, *_): return True\nwith Q():\n    fails()\n    build()"
THREAD = "import threading\ndef run():\n    fails()\n    build()\nt = threading.Thread(target=run)\nt.start(), t.join()"
KEYWORD = f"the error at line {LINES + 2}: TypeError: build() got an unexpected keyword argument 'n'"
SPLIT = "try:\n    {}['b']\n    print('', og.Controller.edit('/B',\n  {'': ''}))\nexcept KeyError: pass"
TURNS = "for n in (1, 2):\n    try:\n        if n == {}\n    except KeyError: pass"


@pytest.mark.parametrize(
    ("text", "line", "name", "why"),
    [
        ("try:\n    fails()\n    build()\nexcept KeyError: pass", 3, "build", LOST),
        (SPLIT, 3, "edit", ERROR.format(LINES + 2)),
        ("try:\n    if True:\n        fails()\n    build()\nexcept KeyError: pass", 4, "build", LOST),
        ("try:\n    print()\n    og.Controller.edit('/B', fails())\nexcept KeyError: pass", 3, "edit", LOST),
        ("try:\n    fails()\nexcept KeyError: pass\nelse:\n    build()", 5, "build", LOST),
        ("def run():\n    try: fails()\n    except KeyError: return\n    build()\nrun()", 4, "build", LOST),
        ("def run():\n    fails()\n    build()\ntry: run()\nexcept KeyError: pass", 3, "build", LOST),
        (TURNS.format("1: fails()\n        build('/B')"), 4, "build", LOST),
        ("import contextlib\nwith contextlib.suppress(KeyError):\n    fails()\n    build()", 4, "build", LOST),
        (QUIET, 6, "build", LOST),
        (TURNS.format("2 or fails(): build()"), 3, "build", LOST),
        ("try:\n    if fails(): build()\nexcept KeyError: pass", 2, "build", LOST),
        (THREAD, 4, "build", LOST),
        ("try:\n    build(n=1)\nexcept TypeError: pass", 2, "build", KEYWORD),
        ("def run(): raise SystemExit\nrun()\nbuild()", 3, "build", f"the exit at line {LINES + 1}"),
        ("for n in (1, 2):\n    if fails: continue\n    build()", 3, "build", NEXT),
        ("for n in (1, 2):\n    if n: exit()\nbuild()", 3, "build", NEXT),
    ],
)
def test_what_an_error_keeps_from_being_built_is_told(
    text: str, line: int, name: str, why: str, tmp_path: Path
) -> None:
    _, (warning,), _ = told(tmp_path, text)
    assert warning == f"{line}: {name}() is never reached, because of {why}"


def test_what_a_script_caught_before_its_end_is_told_too(tmp_path: Path) -> None:
    _, warnings, _ = told(tmp_path, "try:\n    fails()\n    build()\nexcept KeyError: pass\nexit()\nbuild('/C')")
    assert warnings == [
        f"3: build() is never reached, because of {LOST}",
        f"6: build() is never reached, because of the exit at line {LINES + 5}",
    ]


@pytest.mark.parametrize(
    "text",
    [
        "try:\n    build()\n    fails()\nexcept KeyError: pass",
        "try:\n    fails()\nexcept KeyError: build()\nelse: print()",
        "for n in (1, 2):\n    try: fails()\n    except KeyError: pass\n    build(f'/B{n}')",
        "def run():\n    try: return fails()\n    except KeyError: return 1\nrun()\nbuild()",
        "def run():\n    with open(__file__): return 1\n    build()\nrun()",
    ],
)
def test_errors_that_cost_nothing_are_not_told(text: str, tmp_path: Path) -> None:
    assert told(tmp_path, text)[1] == []


@pytest.mark.parametrize(
    ("text", "from_where"),
    [
        ("from mine.utils import og", "mine.utils.og"),
        ("from mine import utils\nog = utils.og", "mine.utils.og"),
        ("import mine.things\nog = mine.things.get().og", "mine.things.get().og"),
    ],
)
def test_an_og_of_a_module_that_is_not_there_is_omnigraph(text: str, from_where: str, tmp_path: Path) -> None:
    more = "\nog.Controller.edit({'graph_path': '/B'}, {og.Controller.Keys.CREATE_NODES: [('T', 'x.T')]})"
    graphs, warnings, findings = told(tmp_path, text + more)
    assert ([graph.path for graph in graphs], warnings) == (["/A", "/B"], [])
    assert f"{from_where} is assumed to be omni.graph.core" in [finding.message for finding in findings.items]


@pytest.mark.parametrize("call", ["Controller.edit", "graphs[0].edit", "Controller().create_node", "build_ros_graphs"])
def test_graphs_that_a_module_builds_that_is_not_there_are_told_at_each_place(call: str, tmp_path: Path) -> None:
    text = f"import mine\nmine.{call}('/B', TICK)\nfor n in range(2): mine.{call}('/C', TICK)"
    _, warnings, _ = told(tmp_path, text)
    assert [warning.partition(": the effect of mine.")[0] for warning in warnings] == ["2", "3"]


ASKS = "import ros\nif not ros.is_there('x'): exit()\n"


def test_a_stand_in_that_is_assumed_to_be_true_answers_a_condition(tmp_path: Path) -> None:
    _, (warning,), findings = told(tmp_path, f"{ASKS}build()", assume=("/World/robot",))
    assert warning == f"3: build() is never reached, because of the condition at line {LINES + 2}"
    assert findings.warnings[0].help == ("--assume ros.is_there assumes that it is true",)
    graphs, warnings, _ = told(tmp_path, f"{ASKS}build()", assume=("ros.is_there",))
    assert ([graph.path for graph in graphs], warnings) == (["/A", "/B"], [])


def test_a_script_that_builds_nothing_where_a_stand_in_says_no_is_run_where_it_says_yes(tmp_path: Path) -> None:
    text = "import ros\nimport omni.graph.core as og\nif not ros.is_there(): exit()\n"
    graphs, warnings, _ = read_text(tmp_path, text + START)
    assert ([graph.path for graph in graphs], warnings) == (["/A"], [])


def test_a_script_that_catches_the_end_of_its_time_keeps_what_it_built(tmp_path: Path) -> None:
    text = "for _ in range(2): print()\ntry:\n    while True: pass\nexcept BaseException: pass"
    start = f"{START}import omni.kit.app\nfor n in range(9):\n    omni.kit.app.get_app().update()\n"
    (graph,), (warning,), _ = read_text(tmp_path, text, start, seconds=1.0)
    assert (graph.path, warning.partition(": ")[2]) == ("/A", "the script takes longer than its time limit")


def test_the_end_of_the_time_ends_nothing_but_the_script(tmp_path: Path) -> None:
    lists = dict.fromkeys(("arguments", "allowed", "types", "absent", "assume", "calls"), ())
    settings = {"assumed": False, "forgiving": False, "literals": False, "run": True, "impulse_every": 0, "stages": {}}
    run = ScriptRun({"path": str(tmp_path / "x.py"), "text": "", **settings, **lists})
    run.end()
    run.running = True
    with pytest.raises(TimeIsUpError):
        run.end()


@pytest.mark.parametrize(
    "value",
    [
        *("max(0.0, mass)", "min(mass, 1)", "round(mass / 2, 3)", "math.sqrt(mass)", "deepcopy(mass)"),
        *("np.array([mass, 1.0], dtype=float)", "np.array([1.0, 2.0]) * mass", "np.clip(float(mass), 0, 1)"),
        *("next(map(float, [mass]))", "map(float, mass)", "2.0 if mass is None else mass % 3"),
    ],
)
def test_a_number_that_is_made_of_an_unknown_one_is_unknown(value: str, tmp_path: Path) -> None:
    text = "import math\nimport numpy as np\nfrom copy import deepcopy\nmass = Camera().get_mass()\n"
    (graph,), warnings, _ = told(tmp_path, f"{text}og.Controller.set('/A/Tick.inputs:x', {value})")
    assert "inputs:x" not in graph.nodes["Tick"].values
    assert ["the value of Tick.inputs:x is left out" in warning for warning in warnings] == [True]


def test_what_decides_between_values_and_is_unknown_is_told_and_may_be_assumed(tmp_path: Path) -> None:
    text = "mass = Camera().get_mass()\nog.Controller.set('/A/Tick.inputs:x', 2 if 3 < mass else 1)"
    for assume, value in (((), 1), (("isaacsim.sensors.camera.Camera.get_mass > 3",), 2)):
        (graph,), warnings, findings = told(tmp_path, text, assume=assume)
        assert (graph.nodes["Tick"].values["inputs:x"].data, warnings) == (value, [])
        notes = [finding.message for finding in findings.items if "assumed to be false" in finding.message]
        asked = f"isaacsim.sensors.camera.Camera.get_mass > 3 (line {LINES + 2} of script.py)"
        assert [note.partition(": ")[2] for note in notes] == [asked] * (value == 1)


def test_an_output_that_a_script_reads_itself_is_noted(tmp_path: Path) -> None:
    _, warnings, findings = told(tmp_path, "print(og.Controller.attribute('/A/Tick.outputs:time').get())")
    assert warnings == []
    said = [finding.message for finding in findings.items]
    assert "the use of the output /A/Tick.outputs:time does not belong to a graph and is left out" in said


def test_a_loop_that_waits_for_something_to_be_over_ends_where_the_stage_holds_all(tmp_path: Path) -> None:
    text = "import omni.kit.app\nif not Camera().is_valid(): raise OSError\n"
    text += "while Camera().is_loading(): omni.kit.app.get_app().update()\n{}['b']\nbuild()"
    graphs, warnings, _ = told(tmp_path, text)
    assert [graph.path for graph in graphs] == ["/A", "/B"]
    assert warnings == ["4: KeyError: 'b'; the script continues after the failed statement"]
