"""docs/pictures/README.md has the command of each picture, and the pictures are small and what their commands make."""

from __future__ import annotations

import importlib
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from graphengine.cli import make_parser
from tests.cli.harness import ROOT, process
from tests.physics.pictures.harness import needs_opengl
from tests.pictures import arm

PICTURES = ROOT / "docs/pictures"
COMMANDS = dict(re.findall(r"^\| `([^`]+)` \|.*\| `([^`]+)` \|$", (PICTURES / "README.md").read_text("utf-8"), re.M))
BY_HAND = re.findall(r"^\| `([^`]+)` \|.*\| drawn by hand \|$", (PICTURES / "README.md").read_text("utf-8"), re.M)
STILL, MOVING = 300_000, 2_500_000
"""Largest sizes, bytes."""


def test_each_picture_has_its_command_and_each_command_its_picture() -> None:
    assert sorted([*COMMANDS, *BY_HAND]) == sorted(path.name for path in PICTURES.iterdir() if path.name != "README.md")
    assert [name for name, command in COMMANDS.items() if f"docs/pictures/{name}" not in shlex.split(command)] == []


def test_pictures_are_small() -> None:
    for path in PICTURES.iterdir():
        most = MOVING if path.suffix == ".webp" else STILL
        assert path.stat().st_size < most, path.name


@pytest.mark.parametrize("command", COMMANDS.values())
def test_each_command_is_one_that_runs(command: str) -> None:
    program, *words = shlex.split(command)
    if program == "graphrun":
        assert make_parser(words[0]).parse_args(words).verb == words[0]
    elif program == "python":
        option, module, *_ = words
        assert option == "-m"
        assert (ROOT / f"{module.replace('.', '/')}.py").is_file()
    else:
        assert program == "termtosvg"


def assert_alike(made: Path, kept: Path) -> None:
    with Image.open(made) as one, Image.open(kept) as other:
        assert one.size == other.size
        difference = np.abs(np.asarray(one.convert("RGB"), float) - np.asarray(other.convert("RGB"), float))
    assert np.median(difference) <= 1.0
    assert np.mean(difference) < 3.0  # of 255: drivers differ at edges and in shadows


@needs_opengl
@pytest.mark.parametrize(
    "name", ["dd100_fleet.png", "dd100_warehouse_perspective.png", "simple_warehouse_d455_colour.png"]
)
def test_a_picture_is_what_its_command_makes(name: str, tmp_path: Path) -> None:
    *words, kept = shlex.split(COMMANDS[name])[1:]
    process(*words, str(tmp_path / "made.png"), code=0)
    assert_alike(tmp_path / "made.png", ROOT / kept)


@needs_opengl
def test_the_arm_is_what_its_script_draws(tmp_path: Path) -> None:
    arm.draw(tmp_path / "made.png")
    assert_alike(tmp_path / "made.png", PICTURES / "arm.png")


def test_the_moving_picture_is_one_that_moves() -> None:
    with Image.open(PICTURES / "warehouse.webp") as film:
        assert (film.n_frames, film.size) == (150, (800, 450))  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["cloud", "map_path"])
def test_each_script_can_be_imported(name: str) -> None:
    assert callable(importlib.import_module(f"tests.pictures.{name}").draw)
