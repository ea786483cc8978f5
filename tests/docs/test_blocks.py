"""The commands, files and programs of the pages: all are parsed or checked; those of pages that begin with `<!-- run -->` run."""

from __future__ import annotations

import contextlib
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from graphengine.scene import build
from tests.docs.commands import graphrun_commands, lines_of, refusal
from tests.docs.pages import DOCS, PAGES, SITE, blocks, is_run, name_of, quoted
from tests.docs.shell import Shell, without_end

WRITTEN = [path for path in SITE if not path.is_relative_to(DOCS / "reference/nodes")]
"""Pages without those whose examples `tests/docs/test_reference.py` checks."""
RUN = [path for path in SITE if is_run(path.read_text(encoding="utf-8"))]
LANGUAGES = {
    "console",
    "cpp",
    "csv",
    "diff",
    "dockerfile",
    "ini",
    "json",
    "mermaid",
    "python",
    "sh",
    "text",
    "toml",
    "xml",
    "yaml",
}


def read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def added_verbs(text: str) -> set[str]:
    """Return the verbs that a package on a page adds to graphrun; a page that is run executes them."""
    projects = [tomllib.loads(block.text)["project"] for block in blocks(text) if block.title == "pyproject.toml"]
    return {verb for project in projects for verb in project["entry-points"]["graphengine.verbs"]}


def refusals(script: str, added: set[str], *, whole: bool) -> list[str]:
    """Return what graphrun says of the commands in a text, without those of added verbs."""
    commands = [words for words in graphrun_commands(script) if words[0] not in added]
    return [problem for words in commands if (problem := refusal(words, whole=whole))]


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_every_graphrun_command_is_valid(path: Path) -> None:
    text, refused = read(path), []
    added = added_verbs(text)
    for block in blocks(text):
        if block.language == "sh":
            refused += [f"{block.line}: {problem}" for problem in refusals(block.text, added, whole=True)]
    for line, quote in quoted(text):
        if quote.startswith("graphrun "):
            refused += [f"{line}: {problem}" for problem in refusals(quote, added, whole=False)]
    assert refused == []


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_every_block_names_its_language(path: Path) -> None:
    assert [(block.line, block.language) for block in blocks(read(path)) if block.language not in LANGUAGES] == []


@pytest.mark.parametrize("path", WRITTEN, ids=name_of)
def test_every_yaml_block_is_yaml_and_every_whole_file_has_no_mistake(path: Path, tmp_path: Path) -> None:
    wrong = []
    found = [block for block in blocks(read(path)) if block.language == "yaml"]
    for number, block in enumerate(found):
        file = tmp_path / (block.title or f"block_{number}.yaml")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(block.text, encoding="utf-8")
        data = yaml.safe_load(block.text)
        if block.runs and not is_run(read(path)) and isinstance(data, dict) and {"graph", "scene"} & data.keys():
            wrong += [f"{block.line}: {finding.message}" for finding in build.load(file).findings.errors]
    assert wrong == []


@pytest.mark.parametrize("path", WRITTEN, ids=name_of)
def test_every_python_block_compiles_and_runs_unless_it_is_a_file(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    for block in blocks(read(path)):
        if block.language == "python":
            code = compile("\n" * block.line + block.text, name_of(path), "exec")
            if block.runs and not block.title and not is_run(read(path)):
                exec(code, {"__name__": "__main__"})


@pytest.mark.parametrize("path", RUN, ids=name_of)
def test_the_commands_of_an_executed_page_work_one_after_the_other(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", list(sys.path))
    shell = Shell(tmp_path)
    for block in blocks(read(path)):
        if block.title:
            shell.write(block.title, block.text)
        elif block.language == "sh" and block.runs:
            for line in lines_of(block.text):
                shell.run(line)
        elif block.language == "python" and block.runs:
            with contextlib.chdir(shell.folder):
                exec(compile(block.text, name_of(path), "exec"), {"__name__": "__main__"})


def test_commands_of_a_run_get_an_end_and_no_network(tmp_path: Path) -> None:
    assert without_end(["run", "x", "--view"]) == [
        "run",
        "x",
        "--for",
        "1s",
        "--rays",
        "mujoco",
        "--transport",
        "memory",
    ]
    assert without_end(["demo", "--for", "2s"]) == ["demo", "--for", "2s", "--no-view", "--transport", "memory"]
    assert without_end(["check", "x"]) == ["check", "x"]
    shell = Shell(tmp_path)
    shell.run("mkdir -p one/two && cd one")
    shell.write("two/three.txt", "3")
    shell.run("graphrun check clock && cd two")
    shell.run("test -f three.txt && graphrun --version | grep graphrun")
    with pytest.raises(AssertionError, match="exit 3"):
        shell.run("graphrun nodes OnTick && (exit 3)")


@pytest.mark.parametrize(
    ("command", "whole", "accepted"),
    [
        ("graphrun run dd100_warehouse --for 2s && graphrun check clock", True, True),
        ("ROS_DOMAIN_ID=3 .venv/bin/graphrun topic list | head", True, True),
        ("graphrun topic", False, True),
        ("graphrun topic", True, False),
        ("graphrun ctl rate FACTOR", False, True),
        ("graphrun run SCENE --foxglov 8765", False, False),
        ("graphrun fly", False, False),
        ("graphrun ctl fly", False, False),
    ],
)
def test_a_command_is_parsed_as_its_users_type_it(command: str, whole: bool, accepted: bool) -> None:
    assert all(not refusal(words, whole=whole) for words in graphrun_commands(command)) is accepted
