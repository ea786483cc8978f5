"""What README.md and CONTRIBUTING.md tell people to write and to type works."""

from __future__ import annotations

import importlib
import re
import shlex
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from graphengine.cli import VERBS, make_parser
from graphengine.compiler.registry import default_registry
from tests.cli.harness import ROOT, live, process

README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
GATE = (ROOT / ".ci/run").read_text(encoding="utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))

PLACEHOLDERS = {
    "SCENE": "dd100_warehouse",
    "GRAPH": "dd100/cmd_vel",
    "FILE…": "dd100_warehouse",
    "FILE": "dd100/cmd_vel",
    "[NAME]": "DifferentialController",
}


def blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def quoted(text: str) -> list[str]:
    """What stands in backticks, outside of blocks."""
    return re.findall(r"`([^`\n]+)`", re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL))


def table(text: str, heading: str) -> list[list[str]]:
    """Cells of the table below a heading."""
    section = text.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in rows[2:]]


PLACES = {
    "import-robot": {"FILE": "scenes/robots/dd100/dd100.urdf"},
    "new": {"DIR": "my_robot"},
    "replay": {"FILE": "out.mcap"},
}
"""Placeholders that mean something else to a verb."""


def commands() -> Iterator[str]:
    """Every command that the two files name, and those of the table with each of their options."""
    for cell, about in table(README, "Commands"):
        (command,) = quoted(cell)
        yield command
        yield from (f"{command} {option}" for option in quoted(about) if option.startswith("--"))
    yield from (text for text in [*quoted(README), *quoted(CONTRIBUTING)] if text.startswith("graphrun "))


COMMANDS = list(dict.fromkeys(commands()))


# Commands


def test_the_table_has_every_verb_once() -> None:
    rows = sorted(quoted(cell)[0].split()[1] for cell, _ in table(README, "Commands"))
    assert rows == sorted(VERBS), "the table below `## Commands` in README.md has one row for each verb"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_one_that_the_program_takes(command: str) -> None:
    program, *words = shlex.split(command)
    words = [PLACES.get(words[0], PLACEHOLDERS).get(word, word) for word in words]
    if words[0] in ("snapshot", "import-robot") and "-o" not in words:
        words += ["-o", "out"]
    assert program == "graphrun"
    parsed = make_parser(words[0]).parse_args(words)
    assert parsed.verb == words[0]


def test_the_options_of_run_work_together() -> None:
    (row,) = [about for cell, about in table(README, "Commands") if "`graphrun run SCENE`" in cell]
    options = [word for option in quoted(row) for word in option.split()]
    result = process("run", "dd100_warehouse", *options)
    assert result.code == 0, result.err
    assert "60 Hz, embedded DDS" in result.err
    assert "warning W201: wheelRadius is 0.05 m" in result.err
    assert "600 ticks, 10.000 s of simulation" in result.err


def test_the_poses_of_the_examples_lie_in_no_obstacle(tmp_path: Path) -> None:
    placing = re.findall(r"`graphrun (ctl (?:move|spawn) [^`]+)`", README)
    assert len(placing) == 3
    own = {"XDG_RUNTIME_DIR": str(tmp_path)}
    with live("run", "dd100_warehouse", "--transport", "memory", "--paused", env=own) as run:
        assert run.hear(lambda said: " Hz, " in said)
        for command in placing:
            result = process(*shlex.split(command), env=own)
            assert (result.code, result.err) == (0, ""), command


PICTURES = [command for command in COMMANDS if command.startswith("graphrun snapshot") and " -o " in command]


@pytest.mark.parametrize("command", PICTURES)
def test_every_picture_is_what_its_command_makes(tmp_path: Path, command: str) -> None:
    *words, kept = shlex.split(command)[1:]
    made = tmp_path / "made.png"
    result = process(*words, str(made))
    if "OpenGL" in result.err and result.code:
        pytest.skip(result.err)
    assert result.code == 0, result.err
    with Image.open(made) as one, Image.open(ROOT / kept) as other:
        assert one.size == other.size
        difference = np.abs(np.asarray(one.convert("RGB"), float) - np.asarray(other.convert("RGB"), float))
    assert np.median(difference) <= 1.0
    assert np.mean(difference) < 3.0  # of 255: drivers differ at edges and in shadows


def test_all_pictures_of_the_readme_have_their_commands() -> None:
    shown = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", README)
    drawn = [command for command in COMMANDS if command.startswith("graphrun show") and "--svg docs/" in command]
    assert sorted(shown) == sorted(shlex.split(command)[-1] for command in [*PICTURES, *drawn])
    assert len(PICTURES) >= 3
    assert len(drawn) == 4  # which tests/drawing holds against what the command makes


# Blocks


def test_the_first_block_sets_up_what_the_gate_sets_up_and_runs() -> None:
    first, _ = blocks(README, "sh")
    environment, install, run = first.strip().split(" && ")
    assert environment == "python3 -m venv .venv"
    assert install == ".venv/bin/pip install -q '.[view]'"
    assert PROJECT["project"]["scripts"] == {"graphrun": "graphengine.cli:main"}
    program, *words = run.split()
    assert program == ".venv/bin/graphrun"
    assert words == ["demo"]
    order = [
        GATE.index(step) for step in ('-m venv "$scratch/clean"', 'clean/bin/pip" install', "clean/bin/graphrun demo")
    ]
    assert order == sorted(order)
    result = process(*words, "--no-view", "--for", "1s")
    assert result.code == 0, result.err
    assert "60 ticks" in result.err


def test_the_second_block_is_what_the_gate_runs() -> None:
    _, second = blocks(README, "sh")
    assert second == "sh tests/all.sh\n"
    assert second.strip() in GATE
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
    assert {language: bool(blocks(README + CONTRIBUTING, language)) for language in ("sh", "yaml", "python")} == {
        "sh": True,
        "yaml": True,
        "python": True,
    }


# Words


@pytest.mark.parametrize("text", [README, CONTRIBUTING], ids=["README", "CONTRIBUTING"])
def test_every_path_and_link_leads_somewhere(text: str) -> None:
    rooms = "|".join(path.name for path in ROOT.iterdir() if path.is_dir() and not path.name.startswith("."))
    paths = [word for word in quoted(text) if re.fullmatch(rf"({rooms})/[\w./-]*", word)]
    links = [link for link in re.findall(r"\]\(([^)]+)\)", text) if "://" not in link]
    assert paths or links
    assert [path for path in [*paths, *links] if not (ROOT / path).exists()] == []


def test_the_python_that_is_needed_is_the_one_that_the_package_asks_for() -> None:
    (needed,) = re.findall(r"needs Python (3\.\d+) or newer", README)
    assert PROJECT["project"]["requires-python"] == f">={needed}"


@pytest.mark.parametrize("word", [word for word in quoted(CONTRIBUTING) if re.fullmatch(r"graphengine(\.\w+)+", word)])
def test_what_is_named_in_python_is_there(word: str) -> None:
    module, _, name = word.rpartition(".")
    assert hasattr(importlib.import_module(module), name)


def test_the_tutorials_share_of_speed_is_the_one_that_check_tells() -> None:
    assert "with 0.1 m for a wheel of 0.049 m, the robot drives at 49 %" in README
    assert "will drive at 0.49 times the commanded speed" in process("check", "tutorial/navigation").out
