"""Ordinary Python of scripts: what they ask of the machine, and of values that only Omniverse knows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.harness import Graphrun

START = """\
import os
from pathlib import Path
import omni.client, omni.kit.test
import omni.graph.core as og
"""
BUILD = "og.Controller.edit('/World/g', {'create_nodes': ('T', 'omni.graph.action.OnTick')})\n"


Told = Callable[..., str]
"""Imports a script and returns what the command printed."""


@pytest.fixture
def told(imports: Graphrun, tmp_path: Path) -> Told:
    """What is told of a script that builds its graph at the end."""

    def run(text: str, *given: str) -> str:
        done = imports(START + text, *given)
        assert (tmp_path / "g.yaml").is_file(), done.err
        return done.out + done.err

    return run


@pytest.mark.parametrize(
    ("text", "given"),
    [
        ("folder = Path.home() / 'assets'\n", []),
        ("assert os.environ['MY_WS'] == '/ws=1'\n", ["--env", "MY_WS=/ws=1"]),
        ("assert os.environ['PATH']\n", ["--env", "PATH"]),
        ("if not Path('/assets/robot.usd').is_file(): raise FileNotFoundError\n", []),
        ("if not os.path.exists('/assets/robot.usda'): raise SystemExit(1)\n", []),
        ("assert os.path.exists('/assets/robot.urdf')\n", ["--assume", "/assets/robot.urdf"]),
        (
            (
                "class Test(omni.kit.test.AsyncTestCase):\n"
                "    def setUp(self):\n        super().setUp()\n        self.path = '/World/g'\n"
                "class More(Test):\n    def tearDown(self): super().tearDown()\n"
                "test = More()\ntest.setUp()\ntest.tearDown()\nassert test.path == '/World/g'\n"
            ),
            [],
        ),
        ("import numpy as np\nnp.testing.assert_allclose(np.fft.fft([1, 1]), [2, 0])\n", []),
        ("from numpy.testing import assert_equal\nassert_equal(1, 1)\n", []),
        ("from parts.clock import name\nfrom .parts.clock import name as same\nassert name == same == 'clock'\n", []),
    ],
)
def test_a_script_gets_what_it_asks_for(text: str, given: list[str], told: Told, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "clock.py").write_text("name = 'clock'\n")
    told(text + BUILD, *given)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("os.environ['MY_WS']\n", "set the environment variable: --env MY_WS=VALUE"),
        ("memoryview(omni.client.read_file('a')[2])\n", "unknown value of omni.client.read_file"),
        ("_, _, text = omni.client.read_file('a')\nbytes(text)\n", "not 'unknown value of omni.client.read_file'"),
    ],
)
def test_a_script_that_fails_is_told_what_it_lacks_and_imported_without(text: str, said: str, told: Told) -> None:
    everything = told(text + BUILD)
    assert "the script continues after the failed statement" in everything
    assert said in everything


def test_what_fails_in_each_turn_of_a_loop_is_told_once(told: Told) -> None:
    text = "for n in range(1500):\n    int(f'x{n}')\n{}['robot']\n"
    everything = told(text + BUILD)
    assert everything.count("invalid literal for int()") == 1
    assert "KeyError: 'robot'" in everything


def test_a_script_catches_that_a_value_cannot_be_called(told: Told) -> None:
    text = "value = None\ntry:\n    value(1)\nexcept TypeError:\n    " + BUILD.strip() + "\n"
    assert "AttributeError" not in told(text)


def test_an_iterator_of_a_script_that_fails_elsewhere_ends(told: Told) -> None:
    text = """
class Once:
    turns = 0
    def __iter__(self):
        return self
    def __next__(self):
        if self.turns:
            raise StopIteration
        self.turns += 1
        return 1
{}['robot']
for turn in Once():
    pass
"""
    assert "takes longer than its time limit" not in told(text + BUILD)


def test_what_a_script_imports_of_a_module_that_is_not_there_is_unknown(told: Told) -> None:
    everything = told("from missing import *\nmake_robot()\n" + BUILD)
    assert "warning" not in everything
    assert "script.py:5:1: note N302: module 'missing' is not imported" in everything


@pytest.mark.parametrize("given", ["=1", "MY_WS_THAT_NOBODY_SETS"])
def test_a_variable_has_a_name_and_a_value(given: str, imports: Graphrun) -> None:
    done = imports(BUILD, "--env", given)
    assert (done.code, "write NAME=VALUE" in done.err) == (2, True)


STAGE = """#usda 1.0
def Xform "World" {
    def OmniGraph "g" {
        token evaluator:type = "execution"
        def OmniGraphNode "Tick" {
            token node:type = "omni.graph.action.OnPlaybackTick"
        }
    }
}
"""
CONNECTS = """
import omni.usd
omni.usd.get_context().open_stage("robot.usda", None)
nodes = ("Clock", "isaacsim.ros2.bridge.ROS2PublishClock")
og.Controller.edit("/World/g", {"create_nodes": nodes, "connect": ("/World/g/Tick.outputs:tick", "Clock.inputs:execIn")})
"""


@pytest.mark.parametrize(("stage", "said"), [(STAGE, "2 nodes, 1 wire"), ("no USD", "USD")])
def test_a_script_finds_the_graphs_of_the_stage_beside_it_that_it_opens(
    stage: str, said: str, told: Told, tmp_path: Path
) -> None:
    pytest.importorskip("pxr")
    (tmp_path / "robot.usda").write_text(stage, encoding="utf-8")
    assert said in told(CONNECTS)
    if stage == STAGE:
        assert "Tick.tick -> Clock.execIn" in (tmp_path / "g.yaml").read_text(encoding="utf-8")


def test_a_script_of_literals_finds_the_graphs_of_a_stage_too(imports: Graphrun, tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    (tmp_path / "robot.usda").write_text(STAGE, encoding="utf-8")
    text = "import omni.graph.core as og\nimport omni.usd\nomni.usd.get_context().open_stage('robot.usda')\n"
    assert imports(text + BUILD.replace("/g'", "/h'")).code == 0
    assert sorted(path.name for path in tmp_path.glob("*.yaml")) == ["g.yaml", "h.yaml"]


NAMED = """from nowhere import Base
class Task(Base):
    def __init__(self):
        Base.__init__(self, name='task')
Task()
"""


@pytest.mark.parametrize(
    "text",
    [
        '"""Docstring."""\n\nfrom __future__ import annotations\nfrom __future__ import division\n' + START,
        START + NAMED,
    ],
    ids=["future imports below a docstring", "the __init__ of an unknown base class"],
)
def test_ordinary_beginnings_do_not_end_a_script(text: str, imports: Graphrun, tmp_path: Path) -> None:
    assert imports(text + BUILD).code == 0
    assert (tmp_path / "g.yaml").is_file()
