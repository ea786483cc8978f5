"""Nothing tells users to install by a name that this project does not own; one constant says whether it does."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path

import pytest

from graphengine.api import viewing
from graphengine.format import distribution
from graphengine.format.errors import UsageError
from tests.instructions import by_name

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
KINDS = {".cfg", ".css", ".html", ".js", ".json", ".md", ".py", ".svg", ".toml", ".txt", ".xml", ".yaml", ".yml", ""}
"""Suffixes of files that users read or run."""
HISTORY = "CHANGELOG.md"
"""Names the commands of each version as they were."""
FRONT = ["README.md", "docs/start/install.md", "ros/graphengine_ros/graphengine_ros/engine.py"]
"""Texts written by hand that install this project; with the constant turned, they install by its name."""


def shipped() -> list[Path]:
    """Texts of the repository that users get, without the tests."""
    folders = [path for path in ROOT.iterdir() if path.is_dir() and path.name not in ("tests", "build", "dist", "site")]
    seen = [path for folder in folders if folder.name[0] != "." for path in folder.rglob("*")]
    seen += [*ROOT.iterdir(), *(ROOT / ".github").rglob("*")]
    found = [path for path in seen if path.is_file() and path.suffix in KINDS and path.name != HISTORY]
    return [path for path in found if not path.name.startswith(".") and "__pycache__" not in path.parts]


@pytest.mark.parametrize(
    "text",
    [
        "pip install graphrun",
        "python -m pip install -U 'graphengine[view]'",
        "~/venv/bin/pip install -q graphrun[view]==0.2.0 && graphrun demo",
        "uvx graphrun demo",
        "uv tool install graphrun",
        "graphengine[view]==0.1.0",
        "  - graphrun >= 0.2",
    ],
)
def test_an_instruction_that_takes_the_name_from_an_index_is_found(text: str) -> None:
    assert by_name(f"First:\n{text}\n")


@pytest.mark.parametrize(
    "text",
    [
        "python3 -m venv ~/graphengine && ~/graphengine/bin/pip install .    # in a checkout of graphengine",
        ".venv/bin/pip install -q '.[view]' && .venv/bin/graphrun demo",
        "pip install '/path/to/graphengine[view]'",
        "pip install ./graphrun-0.2.0-py3-none-any.whl",
        "pip uninstall -y graphengine graphrun",
        "`pip install '.[fast]'`, then `graphrun run SCENE`",
    ],
)
def test_an_instruction_that_takes_a_checkout_or_a_wheel_is_not(text: str) -> None:
    assert by_name(text) == []


def test_no_shipped_text_installs_by_name_before_the_name_is_ours() -> None:
    texts = shipped()
    names = {path.relative_to(ROOT).as_posix() for path in texts}
    assert {
        "README.md",
        "docs/guide/ros_workspace.md",
        "graphengine/cli/project.py",
        "nodes/lidar.py",
        FRONT[-1],
    } <= names
    found = {str(path.relative_to(ROOT)): by_name(path.read_text(encoding="utf-8", errors="replace")) for path in texts}
    assert distribution.ON_PYPI or {path: lines for path, lines in found.items() if lines} == {}
    assert [path for path, lines in found.items() for line in lines if "graphengine" in line] == [], "a stranger's name"


@pytest.mark.parametrize("path", FRONT)
def test_the_texts_with_which_users_begin_install_by_name_exactly_if_it_is_ours(path: str) -> None:
    if (ROOT / path).exists():
        assert bool(by_name((ROOT / path).read_text(encoding="utf-8"))) == distribution.ON_PYPI


@pytest.mark.parametrize(
    ("ours", "command"),
    [(False, "pip install '.[view]'    # in a checkout of"), (True, "pip install 'graphrun[view]'")],
)
def test_messages_of_the_program_follow_the_constant(ours: bool, command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(distribution, "ON_PYPI", ours)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UsageError, match=re.escape(command)) as raised:
        viewing.check_packages()
    assert bool(by_name(str(raised.value))) == ours
    assert bool(by_name(distribution.requirement("view"))) == ours
    assert bool(by_name(distribution.reinstall_command())) == ours
    assert not by_name(distribution.reinstall_command(editable=True))


def test_messages_name_extras_that_exist() -> None:
    sources = [path.read_text(encoding="utf-8") for path in shipped() if path.suffix == ".py"]
    named = {name for text in sources for name in re.findall(r"install_command\(.(\w+).\)", text)}
    assert named == PROJECT["optional-dependencies"].keys() - {"test"}


def test_the_distribution_has_the_name_that_messages_say() -> None:
    assert PROJECT["name"] == distribution.NAME
