"""The recipes in `examples/`, and the examples in docstrings."""

from __future__ import annotations

import doctest
import inspect
import math
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import graphengine as ge
from graphengine import bringup
from graphengine.api import (
    mujoco_objects,
    robots,
    scene,
    scene_loading,
    sensors,
    session,
    session_control,
    session_world,
)
from graphengine.api.gym import scene_env
from graphengine.bringup import scenes

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
FINDER = doctest.DocTestFinder(exclude_empty=False)
MODULES = (
    scene_loading,
    scene,
    session,
    session_control,
    session_world,
    robots,
    sensors,
    mujoco_objects,
    scene_env,
    scenes,
)
DOCUMENTED = {test.name: test for module in MODULES for test in FINDER.find(module) if test.examples}


COMMANDS = re.findall(r"`python ([^`]+)` \|$", (EXAMPLES / "README.md").read_text(encoding="utf-8"), re.MULTILINE)


def run(command: str, *more: str, cwd: Path = ROOT) -> str:
    """Start an example as a user does; return what it prints."""
    assert command in COMMANDS
    words = [sys.executable, *shlex.split(command), *more]
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def printed(pattern: str, output: str) -> float:
    match = re.search(pattern, output)
    assert match is not None, output
    return float(match[1])


def test_each_example_has_one_command() -> None:
    programs = [path for path in EXAMPLES.rglob("*.py") if path.name != "patrol.py"]  # the node of the fleet
    named = [next(word for word in command.split() if word.endswith(".py")) for command in COMMANDS]
    assert sorted(named) == sorted(str(path.relative_to(ROOT)) for path in programs)


def test_every_recipe_has_at_most_40_lines() -> None:
    recipes = list(EXAMPLES.rglob("*.py"))
    assert len(recipes) >= 5
    for path in recipes:
        assert len(path.read_text(encoding="utf-8").splitlines()) <= 40, path


def test_a_robot_is_driven_for_five_seconds_at_half_a_metre_a_second() -> None:
    output = run("examples/drive.py")
    x, y = printed(r"x = (\S+) m", output), printed(r"y = (\S+) m", output)
    assert 2.2 < math.hypot(x, y) < 2.45


def test_a_search_from_a_checkpoint_finds_the_turn_that_leads_to_the_goal() -> None:
    output = run("examples/search.py")
    assert 0.4 < printed(r"^(\S+) rad/s", output) < 1.4
    assert printed(r"(\S+) m from the goal", output) < 0.15


def test_wheels_are_commanded_until_the_lidar_measures_half_a_metre() -> None:
    stops = re.findall(r"(\S+) m before the wall after (\S+) s", run("examples/wheels/run.py"))
    (near, slow), (near_again, fast) = [(float(ahead), float(seconds)) for ahead, seconds in stops]
    assert near == near_again == 0.51
    assert fast < slow  # the second drive is faster, from the same start


def test_a_controller_is_tuned() -> None:
    output = run("examples/tune.py")
    assert (
        1.0 < printed(r"^gain (\S+) 1/s", output) < 2.0
    )  # 2 x braking distance 1 m at 1 m/s2: above 2 / s it overshoots
    assert "50 sessions" in output


def test_the_test_of_a_graph_passes_without_plugins_of_pytest() -> None:
    plain = ("-p", "no:cacheprovider", "-p", "no:timeout", "-p", "no:xdist")
    assert "3 passed" in run("-m pytest examples/test_cmd_vel.py", *plain)


def test_a_fleet_with_an_own_node_is_recorded_and_replayed(tmp_path: Path) -> None:
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    output = run("examples/fleet/run.py fleet.mcap", cwd=tmp_path)
    assert (tmp_path / "fleet.mcap").stat().st_size > 0
    assert "'guard_0001/cmd_vel/Patrol.velocity': -0.2" in output
    assert "identical" in output


def test_a_robot_learns_to_drive_to_a_point() -> None:
    output = run("examples/learn.py")
    distances = [float(found) for found in re.findall(r"([\d.]+) m from the goal", output)]
    assert len(distances) == 5
    assert distances[-1] < 0.15 < distances[0]


def test_the_fleet_needs_no_argument() -> None:
    usage = subprocess.run(
        [sys.executable, "examples/fleet/run.py", "--help"], cwd=ROOT, capture_output=True, text=True
    )
    assert "[recording]" in usage.stdout
    assert "default fleet.mcap" in usage.stdout


@pytest.mark.parametrize("name", DOCUMENTED)
def test_examples_in_docstrings_give_the_stated_results(name: str) -> None:
    with ge.load("dd100_flat", rays="mujoco").session() as sim:
        test = DOCUMENTED[name]
        test.globs = {"ge": ge, "bringup": bringup, "scene": ge.load("dd100_flat"), "sim": sim}
        told: list[str] = []
        doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(test, out=told.append, clear_globs=False)
        assert not told, "".join(told)


def test_every_method_of_a_session_that_takes_arguments_has_an_example() -> None:
    methods = [getattr(ge.Session, name) for name in dir(ge.Session) if not name.startswith("_")]
    functions = [method for method in methods if inspect.isfunction(method)]
    without = {it.__name__ for it in functions if f"{it.__module__}.{it.__qualname__}" not in DOCUMENTED}
    assert without == {"interrupt", "close"}
