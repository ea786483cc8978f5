"""mypy and pyright see the mistakes that authors of nodes and users of the API make, and see none where there are none."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ("node_author.py", "api_user.py")
Errors = dict[int, set[str]]
"""Codes by line."""


@pytest.fixture(params=SOURCES)
def looked_at(tmp_path: Path, request: pytest.FixtureRequest) -> Path:
    """A file as the checkers look at it: its first line, which hides it from them, is empty."""
    first, _, rest = Path(__file__).with_name(request.param).read_text("utf-8").partition("\n")
    assert first == "# mypy: ignore-errors"
    path = tmp_path / str(request.param)
    path.write_text("\n" + rest, "utf-8")
    return path


def expected(looked_at: Path, checker: int) -> Errors:
    """What the comments say: 0 for mypy's codes, 1 for pyright's rules."""
    found: Errors = {}
    for number, line in enumerate(looked_at.read_text("utf-8").splitlines(), 1):
        if told := re.search(r"  # error: (\S+) (\S+)$", line):
            found[number] = set(told[checker + 1].split(","))
    assert len(found) >= 10
    return found


def run(command: Sequence[str]) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"}
    return subprocess.run(
        [sys.executable, "-m", *command],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def test_mypy_tells_each_mistake_where_it_is(looked_at: Path) -> None:
    told = run(["mypy", "--strict", "--no-error-summary", "--no-pretty", str(looked_at)])
    found: Errors = {}
    for line in told.stdout.splitlines():
        if match := re.search(r"\.py:(\d+): error: .*\[([a-z-]+)\]$", line):
            found.setdefault(int(match[1]), set()).add(match[2])
    assert found == expected(looked_at, 0), told.stdout + told.stderr


def test_pyright_tells_each_mistake_where_it_is(looked_at: Path) -> None:
    told = run(["pyright", "--outputjson", "--pythonpath", sys.executable, str(looked_at)])
    if not told.stdout.lstrip().startswith("{"):
        pytest.skip(f"pyright needs Node.js, which it could not run or fetch: {(told.stderr or told.stdout)[-200:]!r}")
    found: Errors = {}
    for entry in json.loads(told.stdout)["generalDiagnostics"]:
        if entry["severity"] == "error":
            found.setdefault(entry["range"]["start"]["line"] + 1, set()).add(entry["rule"])
    assert found == expected(looked_at, 1), told.stdout
