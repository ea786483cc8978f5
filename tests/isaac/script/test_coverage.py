"""Branches of a script that are not taken: what they would build is told with the condition that keeps it from being built."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.isaac.script.script_reader import ScriptOptions
from tests.isaac.harness import Read, read_text

START = """\
import os, sys
import omni.graph.core as og
import omni.usd
from isaacsim.core.utils.prims import is_prim_path_valid
stage = omni.usd.get_context().get_stage()
TICK = {"create_nodes": [("Tick", "omni.graph.action.OnPlaybackTick")]}
graph = og.Controller.edit("/World/first", TICK)[0]
def build(path="/World/second"):
    og.Controller.edit(path, TICK)
class Robot:
    def __init__(self, path):
        self.path = path
    def build(self):
        if stage.GetPrimAtPath(self.path).IsValid(): self.graph()
    def graph(self):
        og.Controller.create_node((self.path + "/tick", graph), "omni.graph.action.OnPlaybackTick")
"""
LINES = START.count("\n")


def told(folder: Path, text: str, *assume: str) -> Read:
    return read_text(folder, text, START, options=ScriptOptions(assume=assume))


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ("if is_prim_path_valid('/World/robot'):\n    og.Controller.edit('/World/second', TICK)", (2, "edit", 1)),
        ("if is_prim_path_valid('/World/robot'): build()", (1, "build", 1)),
        ("if not is_prim_path_valid('/World/robot'):\n    print('no')\nelse:\n    build()", (4, "build", 1)),
        ("if 'ROS' in os.environ:\n    if stage:\n        build()\nelse:\n    pass", (3, "build", 1)),
        ("if not is_prim_path_valid('/World/robot'):\n    sys.exit()\nbuild()", (3, "build", 1)),
        ("def main():\n    if not is_prim_path_valid('/World/robot'): return\n    build()\nmain()", (3, "build", 2)),
        ("for robot in stage.Traverse():\n    if robot.GetName() == 'robot': build()", (2, "build", 2)),
        ("for camera in stage.GetCameras():\n    build()", (2, "build", 1)),
        ("while is_prim_path_valid('/World/robot'):\n    build()", (2, "build", 1)),
        (
            "try:\n    if not is_prim_path_valid('/World/robot'): raise ValueError\n    build()\nexcept ValueError: pass",
            (3, "build", 2),
        ),
        (
            "try: print()\nfinally:\n    if not is_prim_path_valid('/World/robot'): sys.exit()\n    build()",
            (4, "build", 3),
        ),
        ("match stage.there:\n    case True:\n        og.Controller.create_graph('/World/x')", (3, "create_graph", 1)),
        ("Robot('/World/robot').build()", (-2, "graph", -2)),
    ],
)  # fmt: skip
def test_what_a_condition_keeps_from_being_built_is_told(
    text: str, where: tuple[int, str, int], tmp_path: Path
) -> None:
    line, name, condition = where
    (warning,) = told(tmp_path, text).warnings
    what = f"{name}() is never reached, because of the condition at line {condition + LINES}"
    assert warning == f"{line}: {what}"


@pytest.mark.parametrize(
    "text",
    [
        "if not is_prim_path_valid('/World/robot'): build()",
        "if __name__ == '__main__': build()",
        "if __name__ == 'robot': build()",
        "try:\n    build()\nexcept ImportError:\n    og.Controller.edit('/World/third', TICK)",
        "for n in range(3):\n    if n < 2: continue\n    build()",
        "def never():\n    if False: build()\nbuild()",
        "if is_prim_path_valid('/World/robot'): stage.edit_layer()",
        "for n in (1, 2):\n    if n == 2: build()\n    else: print(n)",
    ],
)
def test_what_is_built_or_is_called_by_nobody_is_no_warning(text: str, tmp_path: Path) -> None:
    assert told(tmp_path, text).warnings == []


def test_a_prim_that_is_assumed_answers_a_condition(tmp_path: Path) -> None:
    text = "if is_prim_path_valid('/World/robot'): build()"
    assert told(tmp_path, text).findings.warnings[0].help == ("--assume /World/robot assumes that the prim exists",)
    graphs, warnings, _ = told(tmp_path, text, "/World/robot")
    assert ([graph.path for graph in graphs], warnings) == (["/World/first", "/World/second"], [])


def test_a_script_of_literals_with_a_condition_is_run(tmp_path: Path) -> None:
    text = 'import omni.graph.core as og\nROS = "no"\nif ROS == "yes":\n    og.Controller.create_graph("/World/x")\n'
    text += "og.Controller.edit('/World/y', {'create_nodes': ('T', 'x.T')})"
    assert "never reached, because of the condition at line 3" in read_text(tmp_path, text).warnings[0]


def test_a_module_beside_a_script_is_looked_at_too(tmp_path: Path) -> None:
    beside = "import omni.graph.core as og\ndef more(ask):\n    if ask: og.Controller.create_graph('/World/x')\n"
    (tmp_path / "beside.py").write_text(beside, encoding="utf-8")
    (warning,) = told(tmp_path, "from beside import more\nmore(False)").warnings
    assert "create_graph() is never reached, because of the condition at line 3" in warning


def test_functions_that_nobody_calls_are_one_note(tmp_path: Path) -> None:
    (note,) = [f for f in told(tmp_path, "").findings.items if "not called" in f.message]
    assert note.message.endswith("not called: build(path='/World/second') (line 8), Robot(path).build() (line 13)")
    assert note.code == "N302"
