"""What README.md, CONTRIBUTING.md and the first pages of the site tell people to write and to type works."""

from __future__ import annotations

import importlib
import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import pytest

from graphengine.cli import VERBS, make_parser
from graphengine.compiler.registry import default_registry
from tests.cli.harness import ROOT, live, process
from tests.docs import pages

README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
GATE = (ROOT / ".ci/run").read_text(encoding="utf-8")
NEWCOMERS = sorted(
    str(path.relative_to(ROOT)) for part in ("start", "how") for path in (ROOT / "docs" / part).glob("*.md")
)
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def blocks(text: str, language: str) -> list[str]:
    """The blocks in a language that are no files with a name."""
    return [block.text for block in pages.blocks(text) if block.language == language and not block.title]


def quoted(text: str) -> list[str]:
    """What stands in backticks, outside of blocks."""
    return [found for _, found in pages.quoted(text)]


def table(text: str, heading: str) -> list[list[str]]:
    """Cells of the table below a heading."""
    section = text.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in rows[2:]]


# Commands


def test_the_readme_is_read_in_a_few_minutes() -> None:
    assert len(README) <= 8000


def test_readme_site_and_help_say_the_same_of_the_program() -> None:
    description = (make_parser().description or "").removeprefix("Simulate ")
    for text in (README, (ROOT / "docs/index.md").read_text(encoding="utf-8")):
        assert f"graphengine simulates {description}" in text


def test_the_table_describes_verbs_in_the_words_of_the_help() -> None:
    rows = {quoted(cell)[0].removeprefix("graphrun "): about for cell, about in table(README, "Commands")}
    assert rows == {verb: VERBS[verb] for verb in rows}


def test_several_options_of_run_work_together() -> None:
    options = ("--for", "10s", "--rate", "max", "--watch", "--transport", "dds", "--robot-state")
    result = process("run", "dd100_warehouse", *options, "--set", "DiffController.wheelRadius=0.05")
    assert result.code == 0, result.err
    assert "60 Hz, embedded DDS" in result.err
    assert "warning W201: wheelRadius is 0.05 m" in result.err
    assert "600 ticks, 10.000 s of simulation" in result.err


def test_the_commands_that_disturb_a_run_are_accepted(tmp_path: Path) -> None:
    page = (ROOT / "docs/start/drive.md").read_text(encoding="utf-8")
    commands = [line for block in blocks(page, "sh") for line in block.splitlines() if line.startswith("graphrun ctl ")]
    help_text = process("ctl", "--help").out
    commands += re.findall(r"graphrun ctl (?:move|spawn) .*", help_text)  # to poses that lie in no obstacle
    assert len(commands) >= 8
    own = {"XDG_RUNTIME_DIR": str(tmp_path)}
    with live("run", "dd100_warehouse", "--transport", "memory", "--paused", env=own) as run:
        assert run.hear(lambda said: " Hz, " in said)
        for command in commands:
            result = process(*shlex.split(command)[1:], env=own)
            assert (result.code, result.err) == (0, ""), command


# Blocks


def test_the_first_block_sets_up_what_the_gate_sets_up_and_runs() -> None:
    first = blocks(README, "sh")[0]
    setup, run = first.splitlines()
    environment, activation, install = setup.split(" && ")
    assert (environment, activation) == ("python3 -m venv .venv", ". .venv/bin/activate")
    assert install == "pip install '.[view]'"
    assert PROJECT["project"]["scripts"] == {"graphrun": "graphengine.cli:main"}
    assert run == "graphrun demo"
    order = [
        GATE.index(step) for step in ('-m venv "$scratch/clean"', 'clean/bin/pip" install', "clean/bin/graphrun demo")
    ]
    assert order == sorted(order)
    result = process("demo", "--no-view", "--for", "1s")
    assert result.code == 0, result.err
    assert "60 ticks" in result.err


def test_the_test_command_is_what_the_gate_runs() -> None:
    last = blocks(README, "sh")[-1]
    assert last == "sh tests/all.sh\n"
    assert last.strip() in GATE
    subprocess.run(["sh", "-n", "tests/all.sh"], cwd=ROOT, check=True)


@pytest.mark.parametrize("text", blocks(README, "yaml") + blocks(CONTRIBUTING, "yaml"))
def test_every_yaml_block_checks(tmp_path: Path, text: str) -> None:
    (tmp_path / "block.yaml").write_text(text, encoding="utf-8")
    for scene in ((), ("--scene", "dd100_warehouse")):
        result = process("check", "block.yaml", "--strict", *scene, cwd=tmp_path)
        assert (result.code, result.err) == (0, ""), result.out


@pytest.mark.parametrize("text", blocks(README, "python") + blocks(CONTRIBUTING, "python"))
def test_every_python_block_runs(text: str) -> None:
    assert "assert " in text
    exec(compile(text, "block", "exec"), {cls.__name__: cls for cls in default_registry().types.values()})


def test_there_are_blocks_of_each_language() -> None:
    assert all(blocks(README + CONTRIBUTING, language) for language in ("sh", "yaml", "python"))


# Words


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", *NEWCOMERS])
def test_every_path_leads_somewhere(name: str) -> None:
    rooms = "|".join(path.name for path in ROOT.iterdir() if path.is_dir() and not path.name.startswith("."))
    text = (ROOT / name).read_text(encoding="utf-8")
    paths = [word for word in quoted(text) if re.fullmatch(rf"({rooms})/[\w./-]*", word)]
    assert [path for path in paths if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("name", ["README.md", "docs/start/install.md"])
def test_the_python_that_is_needed_is_the_one_that_the_package_asks_for(name: str) -> None:
    (needed,) = {*re.findall(r"Python (3\.\d+) to 3\.13", (ROOT / name).read_text(encoding="utf-8"))}
    assert PROJECT["project"]["requires-python"] == f">={needed}"


@pytest.mark.parametrize("word", [word for word in quoted(CONTRIBUTING) if re.fullmatch(r"graphengine(\.\w+)+", word)])
def test_what_is_named_in_python_is_there(word: str) -> None:
    module, _, name = word.rpartition(".")
    assert hasattr(importlib.import_module(module), name)
