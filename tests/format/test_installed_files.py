"""Another distribution in the place of this package, and files that are not its own, are noticed and repaired."""

from __future__ import annotations

import json
import shlex
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest

from graphengine.format.installed_files import conflicts
from tests.wheels import SCRIPT, Environment, make_wheel, own_wheel

STRANGER = {"graphengine/__init__.py": b"", "graphengine/engine.py": b"class GraphEngine: ...\n"}
OWN = {"graphengine/__init__.py": b'"""Ours."""\n', "graphengine/cli.py": b"def main(): ...\n"}


def installation(environment: Environment) -> dict[str, Any]:
    checks: list[dict[str, Any]] = json.loads(environment.graphrun("doctor", "--format", "json").stdout)["checks"]
    return next(check for check in checks if check["name"] == "installation")


def test_another_projects_package_is_detected_and_two_commands_repair_it(tmp_path: Path) -> None:
    wheel, environment = own_wheel(tmp_path), Environment(tmp_path / "venv")
    put(wheel, environment.site)
    clean = environment.graphrun("--version", "--verbose").stdout
    assert clean.startswith("graphrun ")
    assert "installation:" not in clean

    environment.pip("install", make_wheel(tmp_path, "graphengine", "0.0.1", STRANGER))
    damaged = installation(environment)
    assert damaged["state"] == "problem"
    told = environment.graphrun("--version", "--verbose").stdout
    for text in (damaged["found"], told):
        assert (
            f"the distribution graphengine 0.0.1 in {environment.site}: another project with a package graphengine"
            in text
        )
        assert f"files that are not of graphrun: {environment.site}/graphengine/engine.py" in text
        assert f"files of graphrun that were changed or removed: {environment.site}/graphengine/__init__.py" in text
    uninstall, install = damaged["remedy"]
    assert f"\n  {uninstall}\n  {install}\n" in told

    environment.pip(*shlex.split(uninstall)[1:])
    assert shlex.split(install, comments=True) == ["pip", "install", "."]
    put(wheel, environment.site)  # what pip does, which here would also build the wheel
    assert environment.graphrun("--version", "--verbose").stdout == clean


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of installed packages, the only one, with a small package of ours."""
    folder = tmp_path / "site"
    put(make_wheel(tmp_path, "graphrun", "0.2.0", OWN, SCRIPT), folder)
    monkeypatch.setattr(sys, "path", [str(folder)])
    assert conflicts() == ([], [])
    return folder


def put(wheel: Path, folder: Path) -> None:
    with zipfile.ZipFile(wheel) as content:
        content.extractall(folder)


def test_the_package_under_its_old_name_is_detected(site: Path, tmp_path: Path) -> None:
    put(make_wheel(tmp_path, "graphengine", "0.1.0", {**OWN, "graphengine/gone.py": b""}, SCRIPT), site)
    found, remedies = conflicts()
    assert found == [
        f"the distribution graphengine 0.1.0 in {site}: the old name of graphrun",
        f"files that are not of graphrun: {site}/graphengine/gone.py",
    ]
    assert remedies == ["pip uninstall -y graphengine graphrun", "pip install .    # in a checkout of graphengine"]


def test_an_editable_installation_is_repaired_as_an_editable_installation(site: Path, tmp_path: Path) -> None:
    put(make_wheel(tmp_path, "graphengine", "0.1.0", {}, SCRIPT), site)
    (site / "graphrun-0.2.0.dist-info/direct_url.json").write_text(
        '{"dir_info": {"editable": true}, "url": "file:///x"}'
    )
    assert conflicts()[1][1] == "pip install -e .    # in a checkout of graphengine"


def test_foreign_files_are_reported_for_deletion_except_compiled_files(site: Path) -> None:
    (site / "graphengine/__pycache__").mkdir()
    (site / "graphengine/__pycache__/cli.cpython-311.pyc").write_bytes(b"")
    assert conflicts() == ([], [])
    for name in ("a.py", "b.py", "c.py"):
        (site / "graphengine" / name).write_text("")
    folder = site / "graphengine"
    assert conflicts() == (
        [f"files that are not of graphrun: {folder}/a.py, {folder}/b.py and 1 more"],
        ["delete the files that are not of it"],
    )


@pytest.mark.parametrize("removed", [False, True])
def test_changed_and_removed_files_are_detected(site: Path, removed: bool) -> None:
    path = site / "graphengine/cli.py"
    if removed:
        path.unlink()
    else:
        path.write_text("def main(): print('changed')\n")
    found, remedies = conflicts()
    assert found == [f"files of graphrun that were changed or removed: {path}"]
    assert remedies[0] == "pip uninstall -y graphrun"


def test_a_checkout_on_the_path_is_no_conflict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    assert conflicts() == ([], [])
