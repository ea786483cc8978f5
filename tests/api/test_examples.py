"""The recipes in `examples/`, and the examples in docstrings."""

from __future__ import annotations

import doctest
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import graphengine as ge
from graphengine.api import robots, scene, scene_loading
from graphengine.api import session as sessions

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
FINDER = doctest.DocTestFinder(exclude_empty=False)
MODULES = (scene_loading, scene, sessions, robots)
DOCUMENTED = {test.name: test for module in MODULES for test in FINDER.find(module) if test.examples}


def example(name: str) -> Any:
    return runpy.run_path(str(EXAMPLES / name))["main"]


def test_every_recipe_has_at_most_40_lines() -> None:
    recipes = list(EXAMPLES.rglob("*.py"))
    assert len(recipes) >= 5
    for path in recipes:
        assert len(path.read_text(encoding="utf-8").splitlines()) <= 40, path


def test_a_robot_is_driven_for_five_seconds_at_half_a_metre_a_second() -> None:
    assert 2.2 < example("drive.py")() < 2.45


def test_a_search_from_a_checkpoint_finds_the_turn_that_leads_to_the_goal() -> None:
    turn, missed = example("search.py")()
    assert 0.4 < turn < 1.4
    assert missed < 0.15


def test_a_controller_is_tuned() -> None:
    gain, _ = example("tune.py")()
    assert 1.0 < gain < 2.0  # 2 x braking distance 1 m at 1 m/s2: a gain above 2 / s overshoots


def test_the_test_of_a_graph_passes() -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib"]
    command.append("examples/test_cmd_vel.py")
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout
    assert "3 passed" in done.stdout


def test_a_fleet_with_an_own_node_is_recorded_and_replayed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", list(sys.path))
    places = example("fleet/run.py")(str(tmp_path / "out.mcap"))
    assert places["guard_0001"] < places["guard_0000"]


@pytest.mark.parametrize("name", DOCUMENTED)
def test_an_example_of_a_docstring_does_what_it_says(name: str) -> None:
    with ge.load("dd100_flat", rays="mujoco").session() as sim:
        test = DOCUMENTED[name]
        test.globs = {"ge": ge, "scene": ge.load("dd100_flat"), "sim": sim}
        told: list[str] = []
        doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test, out=told.append, clear_globs=False)
        assert not told, "".join(told)


def test_every_method_of_a_session_that_takes_arguments_has_an_example() -> None:
    methods = [name for name, member in vars(ge.Session).items() if callable(member) and not name.startswith("_")]
    without = {name for name in methods if f"graphengine.api.session.Session.{name}" not in DOCUMENTED}
    assert without == {"interrupt", "close"}
