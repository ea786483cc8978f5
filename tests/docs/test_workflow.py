"""The workflow of the guide on many runs: its steps repeat after errors, never after failures."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.docs.pages import DOCS, blocks

SCENARIO = """
scenario: falls
scene: SCENE
expect: [{always: EXPECTED}]
stop: {after: 0.1s}
"""
NOTES = """
from pathlib import Path

def pytest_sessionfinish():
    Path("runs").open("a").write("x")
    Path("scenarios/later.yaml").write_text("{scene: later, world: world.xml}")
"""


def script() -> str:
    """Return the steps of the workflow that are commands, without the one that installs."""
    page = (DOCS / "guide/many_runs.md").read_text(encoding="utf-8")
    (block,) = [block for block in blocks(page) if block.title == ".github/workflows/scenarios.yml"]
    workflow: dict[Any, Any] = yaml.safe_load(block.text)
    steps = [step["run"] for step in workflow["jobs"]["scenarios"]["steps"] if "run" in step]
    return "\n".join(step.replace("${{ matrix.shard }}", "1") for step in steps if "pip install" not in step)


@pytest.mark.parametrize(
    ("scene", "expected", "passes", "runs"),
    [("there.yaml", "time < 9", True, 1), ("there.yaml", "time > 9", False, 1), ("later.yaml", "time < 9", True, 2)],
    ids=["passed", "failed", "error"],
)
def test_the_documented_workflow_runs_a_scenario_again_only_after_an_error(
    scene: str, expected: str, passes: bool, runs: int, tmp_path: Path
) -> None:
    folder = tmp_path / "scenarios"
    folder.mkdir()
    (folder / "world.xml").write_text("<mujoco/>", encoding="utf-8")
    (folder / "there.yaml").write_text("{scene: there, world: world.xml}", encoding="utf-8")
    text = SCENARIO.replace("SCENE", scene).replace("EXPECTED", expected)
    (folder / "falls.scenario.yaml").write_text(text, encoding="utf-8")
    (tmp_path / "conftest.py").write_text(NOTES, encoding="utf-8")
    program = tmp_path / "bin" / "graphrun"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m graphengine.cli "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    environ = {**os.environ, "PATH": f"{program.parent}:{os.environ['PATH']}"}
    commands = script().replace("-n auto", "-n 0")  # whose processes would each note their end
    done = subprocess.run(["bash", "-e", "-c", commands], cwd=tmp_path, env=environ, capture_output=True, text=True)
    assert (done.returncode == 0) == passes, done.stdout + done.stderr
    assert (tmp_path / "runs").read_text(encoding="utf-8") == "x" * runs
    assert len(list((tmp_path / "failures").glob("falls*/run.html"))) == (not passes)
