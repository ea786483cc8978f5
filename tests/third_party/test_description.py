"""A format of robot descriptions by somebody else, in a package of one file: found by its entry point, used like URDF."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from tests.third_party.installed import lay_out

ACME = Path(__file__).parent / "acme_sticks"
ROOT = Path(__file__).parents[2]
FIGURE = "stick base length 0.2 mass 3\nstick upper on base length 0.5 mass 1 hinge y\n"
SCENE = "scene: s\nworld: worlds/flat_grid.xml\nrobots: {man: {use: man.sticks}}\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a figure, a scene that uses it, and Acme's package in `site`."""
    site = tmp_path / "site"
    site.mkdir()
    lay_out(ACME, "acme_sticks.py", site)
    (tmp_path / "man.sticks").write_text(FIGURE)
    (tmp_path / "scene.yaml").write_text(SCENE)
    return tmp_path


def graphrun(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((str(folder / "site"), str(ROOT))), "COLUMNS": "200"}
    command = [sys.executable, "-m", "graphengine.cli", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment, cwd=folder)


def replace(folder: Path, body: str) -> None:
    """Replace Acme's reader by one with another body."""
    (folder / "site/acme_sticks.py").unlink()
    (folder / "site/acme_sticks.py").write_text(f"def read(source, findings):\n    {body}\n")


def test_a_scene_uses_a_file_of_the_format(folder: Path) -> None:
    done = graphrun(folder, "check", "scene.yaml")
    assert (done.returncode, done.stderr) == (0, "")
    assert "note N104: the description, used without a robot file, has 1 joint; graphs can use all" in done.stdout


def test_a_robot_file_names_a_file_of_the_format(folder: Path) -> None:
    (folder / "man.yaml").write_text(
        "robot: man\nurdf: man.sticks\nbase_link: base\njoints: {upper_joint: {drive: {damping: 1}}}\n"
    )
    (folder / "scene.yaml").write_text(SCENE.replace("man.sticks", "man.yaml"))
    done = graphrun(folder, "check", "scene.yaml")
    assert (done.returncode, "error" in done.stdout.replace("0 errors", "")) == (0, False)


def test_an_import_writes_a_robot_file(folder: Path) -> None:
    done = graphrun(folder, "import-robot", "man.sticks", "-o", "robots/man.yaml")
    assert done.returncode == 0
    assert "2 links, 1 joint of which" in done.stdout
    assert yaml.safe_load((folder / "robots/man.yaml").read_text())["base_link"] == "base"


def test_its_errors_and_those_of_the_tree_name_lines_of_the_file(folder: Path) -> None:
    (folder / "man.sticks").write_text(FIGURE.replace(" mass 3", ""))
    assert (
        "man.sticks:1:1: error S103: a line needs: stick NAME length L mass M"
        in graphrun(folder, "check", "scene.yaml").stdout
    )
    (folder / "man.sticks").write_text(FIGURE.replace("on base", "on bass"))
    assert (
        "man.sticks:2:1: error S103: joint 'upper_joint': no parent link 'bass'"
        in graphrun(folder, "check", "scene.yaml").stdout
    )


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("raise KeyError('x')", "man.sticks:1:1: error S103: the reader of acme-sticks failed: KeyError: 'x'"),
        ("return None", "man.sticks:1:1: error S103: the reader of acme-sticks returned nothing and no error"),
        ("return 'robot'", "error S103: the reader of acme-sticks returned a value of the type str and no error"),
    ],
)
def test_a_reader_that_fails_is_an_error_that_names_its_package(folder: Path, body: str, message: str) -> None:
    replace(folder, body)
    done = graphrun(folder, "check", "scene.yaml")
    assert (done.returncode, done.stderr) == (1, "")
    assert message in done.stdout
    assert "update acme-sticks, or uninstall it" in done.stdout


def test_a_package_that_cannot_be_imported_is_an_error(folder: Path) -> None:
    replace(folder, "pass\nimport nowhere")
    done = graphrun(folder, "check", "scene.yaml")
    assert done.returncode == 1
    assert "description format 'sticks' of acme-sticks cannot be imported: ModuleNotFoundError" in done.stdout


def test_without_the_package_the_error_says_that_nothing_reads_the_format(folder: Path) -> None:
    (folder / "site/acme_sticks.py").unlink()
    (folder / "site/acme_sticks-0.1.0.dist-info").rename(folder / "removed")
    text = "error S103: no installed package reads descriptions that end with '.sticks'"
    assert f"scene.yaml:3:21: {text}" in graphrun(folder, "check", "scene.yaml").stdout
    (folder / "man.yaml").write_text("robot: man\nurdf: man.sticks\n")
    (folder / "scene.yaml").write_text(SCENE.replace("man.sticks", "man.yaml"))
    assert f"man.sticks:1:1: {text}" in graphrun(folder, "check", "scene.yaml").stdout


def test_two_packages_with_one_suffix_are_an_error(folder: Path) -> None:
    about = folder / "site/other-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: other\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[graphengine.descriptions]\nsticks = other:read\n")
    done = graphrun(folder, "check", "scene.yaml")
    assert "several packages provide a description format 'sticks': acme_sticks:read, other:read" in done.stdout
    assert "uninstall all but one" in done.stdout
