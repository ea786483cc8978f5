"""Findings in colours, and as annotations of GitHub Actions."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.cli.harness import Graphrun, live, process

BROKEN = """graph: broken
nodes:
  Tick: OnPlaybackTick
  Idle: {type: PublishClock, inputs: {"100 %, a:b": 1}}
connections: [Tick.tack -> Idle.execIn]
"""
WARNED = "graph: warned\nnodes: {Tick: OnPlaybackTick, Idle: PublishClock}\n"
RED, YELLOW, RESET = "\x1b[1;31m", "\x1b[1;33m", "\x1b[0m"


@pytest.fixture
def repository(project: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository whose folder `robot, 1` is the working directory."""
    (project / ".git").mkdir()
    folder = project / "robot, 1"
    folder.mkdir()
    (folder / "broken.yaml").write_text(BROKEN, encoding="utf-8")
    (folder / "warned.yaml").write_text(WARNED, encoding="utf-8")
    monkeypatch.chdir(folder)
    return project


# Colours


def test_a_terminal_gets_the_severity_and_the_carets_in_colour(repository: Path) -> None:
    with live("check", "warned.yaml", "broken.yaml", cwd=Path.cwd(), columns=80, out=True) as running:
        running.hear(lambda said: False)
    lines = running.said.replace("\r", "").splitlines()
    assert f"warned.yaml:2:31: {YELLOW}warning W101{RESET}: no event reaches Idle" in lines
    assert f"broken.yaml:5:15: {RED}error G204{RESET}: OnPlaybackTick has no output 'tack'" in lines
    assert f"       |               {RED}^^^^^^^^^{RESET}" in lines


@pytest.mark.parametrize(
    ("variables", "colours"),
    [
        ({}, False),
        ({"FORCE_COLOR": "1"}, True),
        ({"FORCE_COLOR": "0"}, False),
        ({"FORCE_COLOR": ""}, False),
        ({"FORCE_COLOR": "1", "NO_COLOR": "1"}, False),
    ],
    ids=str,
)
def test_a_pipe_gets_colours_only_if_they_are_forced(
    repository: Path, variables: dict[str, str], colours: bool
) -> None:
    assert ("\x1b" in process("check", "broken.yaml", cwd=Path.cwd(), env=variables).out) == colours


@pytest.mark.parametrize("variables", [{"NO_COLOR": "1"}, {"TERM": "dumb"}], ids=str)
def test_a_terminal_gets_no_colours_if_they_are_not_wanted(repository: Path, variables: dict[str, str]) -> None:
    with live("check", "broken.yaml", cwd=Path.cwd(), columns=80, out=True, env=variables) as running:
        running.hear(lambda said: False)
    assert "error G204" in running.said
    assert "\x1b" not in running.said


def test_a_finding_without_colours_equals_the_text_in_a_pipe(repository: Path) -> None:
    forced = process("check", "warned.yaml", "broken.yaml", cwd=Path.cwd(), env={"FORCE_COLOR": "1"}).out
    plain = process("check", "warned.yaml", "broken.yaml", cwd=Path.cwd()).out
    assert re.sub(r"\x1b\[[0-9;]*m", "", forced) == plain != forced


# GitHub Actions


def decoded(text: str, *more: str) -> str:
    """As `ActionCommand` of GitHub's runner decodes a value."""
    for code in ("%0D", "%0A", *more):
        text = text.replace(code, chr(int(code[1:], 16)))
    return text.replace("%25", "%")


def read(line: str) -> dict[str, Any]:
    """As GitHub's runner reads a workflow command."""
    found = re.fullmatch(r"::(error|warning|notice) ([^:]*)::(.*)", line)
    assert found is not None, line
    properties = dict(each.split("=", 1) for each in found[2].split(","))
    values = {name: decoded(value, "%3A", "%2C") for name, value in properties.items()}
    return {"level": found[1], "message": decoded(found[3]), **values}


def test_annotations_have_the_findings_of_json(graphrun: Graphrun, repository: Path) -> None:
    result = graphrun("check", "broken.yaml", "warned.yaml", "--format", "github", code=1, err="")
    *lines, summary = result.lines
    records = json.loads(graphrun("check", "broken.yaml", "warned.yaml", "--format", "json").out)
    assert len(lines) == len(records) >= 3
    assert summary.endswith("2 graphs: 2 errors, 1 warning")
    for line, record in zip(lines, records, strict=True):
        given = read(line)
        assert given["level"] == record["severity"]
        assert given["title"] == f"{record['code']}: {record['title']}"
        assert given["message"].split("\n") == [*record["message"].split("\n"), *record["help"]]
        assert given["file"] == f"robot, 1/{record['path']}"
        assert (int(given["line"]), int(given["col"])) == (record["line"], record["column"])
        assert int(given["endColumn"]) == record["column"] + record["length"]


def test_paths_are_relative_to_the_workspace_of_an_action(
    graphrun: Graphrun, repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GITHUB_WORKSPACE", str(repository / "robot, 1"))
    assert read(graphrun("check", "broken.yaml", "--format", "github").lines[0])["file"] == "broken.yaml"


def test_a_note_of_an_included_file_is_a_notice_with_the_whole_path(graphrun: Graphrun, repository: Path) -> None:
    lines = graphrun("check", "dd100/joint_states", "--format", "github", code=0).lines
    notice = next(read(line) for line in lines[:-1])
    assert notice["level"] == "notice"
    assert Path(notice["file"]).is_file()
