"""What is imported is declared, and what cannot be installed everywhere is said in words where it is missing."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import grimp
import pytest
import yaml
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
RELEASE = (ROOT / "tests/release.sh").read_text(encoding="utf-8")

DISTRIBUTIONS = {
    "PIL": "pillow",
    "collada": "pycollada",
    "foxglove": "foxglove-sdk",
    "mujoco": "mujoco-core",
    "pxr": "usd-core",
    "rclpy": "ros-jazzy-rclpy",
    "yaml": "pyyaml",
}
"""Names of packages on PyPI, by the names of their modules where the two differ."""
OF_ROS_TYPES = {"ros-jazzy-common-interfaces"}
"""What the extra `ros` has beside rclpy: messages and services, whose modules are imported by the names of their types."""
BY_COMMAND = {"pytest-xdist"}
"""What is used by options of commands and never imported."""


def declared(*texts: str) -> set[str]:
    return {Requirement(text).name.lower() for text in texts}


def required(**system: str) -> set[str]:
    """What pip installs on a system."""
    found = (Requirement(text) for text in PROJECT["dependencies"])
    return {one.name for one in found if one.marker is None or one.marker.evaluate(dict(system))}


def run(program: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, cwd=ROOT)


def test_what_is_imported_is_declared_and_what_is_declared_is_imported() -> None:
    graph = grimp.build_graph("graphengine", include_external_packages=True)
    modules = {name for name in graph.modules if name.partition(".")[0] != "graphengine"}
    extras = PROJECT["optional-dependencies"]
    offered = [text for name, texts in extras.items() if name != "test" for text in texts]
    imported = {DISTRIBUTIONS.get(name, name) for name in modules - sys.stdlib_module_names}
    assert imported == declared(*PROJECT["dependencies"], *offered) - OF_ROS_TYPES - BY_COMMAND


@pytest.mark.parametrize(
    ("python", "system", "machine", "has_wheels"),
    [
        ("3.11", "linux", "x86_64", True),
        ("3.13", "linux", "x86_64", True),
        ("3.14", "linux", "x86_64", False),
        ("3.12", "linux", "aarch64", False),
        ("3.12", "darwin", "arm64", False),
    ],
)
def test_wheels_of_ros_are_pinned_and_required_by_their_extra_where_they_exist(
    python: str, system: str, machine: str, has_wheels: bool
) -> None:
    found = [Requirement(text) for text in PROJECT["optional-dependencies"]["ros"]]
    assert {one.name for one in found} == {"ros-jazzy-rclpy", *OF_ROS_TYPES}
    assert all(str(one.specifier).startswith("==") for one in found)
    here = {"python_version": python, "sys_platform": system, "platform_machine": machine}
    assert {one.marker is not None and one.marker.evaluate(dict(here)) for one in found} == {has_wheels}
    assert not {one.name for one in found} & required(**here)


@pytest.mark.parametrize(
    ("python", "system", "machine", "has_dds"),
    [
        ("3.11", "linux", "x86_64", True),
        ("3.13", "darwin", "arm64", True),
        ("3.11", "linux", "aarch64", False),
        ("3.12", "linux", "riscv64", False),
        ("3.14", "linux", "x86_64", False),
        ("3.14", "darwin", "arm64", False),
    ],
)
def test_cyclonedds_is_a_dependency_where_it_has_a_binary_wheel(
    python: str, system: str, machine: str, has_dds: bool
) -> None:
    found = required(python_version=python, sys_platform=system, platform_machine=machine)
    assert ("cyclonedds" in found) == has_dds
    assert {"mujoco-core", "rosbags"} <= found


def workflow(name: str) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load((ROOT / ".github/workflows" / f"{name}.yml").read_text(encoding="utf-8"))
    return content


def test_the_tests_that_run_where_it_has_none_do_not_import_it() -> None:
    *_, tests = workflow("tests")["jobs"]["without-dds"]["steps"]
    names = [word for word in tests["run"].split() if word.startswith("tests/") and word != "tests/all.sh"]
    (everywhere,) = re.findall(r'^everywhere="(.*)"$', RELEASE, re.MULTILINE)
    assert everywhere.split() == names
    assert len(names) >= 5
    rooms = [ROOT / name for name in names]
    files = [file for room in rooms for file in room.rglob("*.py")]
    assert all(room.is_dir() for room in rooms)
    imports = re.compile(r"(from|import) (cyclonedds|graphengine\.ros\.transports\.dds|tests\.ros)\b")
    assert [file for file in files if imports.search(file.read_text(encoding="utf-8"))] == []


def test_a_release_runs_the_steps_of_its_script_on_every_python_that_the_package_names() -> None:
    build, install, publish = workflow("release")["jobs"].values()
    commands = [step["run"] for job in (build, install) for step in job["steps"] if "run" in step]
    steps = [command.split()[2] for command in commands if command.startswith("sh tests/release.sh ")]
    assert steps == re.findall(r"^(\w+)\)$", RELEASE, re.MULTILINE)
    named = re.findall(r"Python :: (3\.\d+)", "\n".join(PROJECT["classifiers"]))
    assert install["strategy"]["matrix"]["python"] == named
    assert (install["needs"], publish["needs"]) == ("build", "install")


def test_only_the_publishing_of_a_tag_gets_an_identity_and_actions_are_pinned() -> None:
    release = workflow("release")
    jobs = release["jobs"]
    assert release["permissions"] == {"contents": "read"}
    assert {name: job.get("permissions") for name, job in jobs.items()} == {
        "build": None,
        "install": None,
        "publish": {"id-token": "write"},
    }
    assert jobs["publish"]["if"] == "github.ref_type == 'tag'"
    used = {step["uses"] for job in jobs.values() for step in job["steps"] if "uses" in step}
    pinned = {action for action in used if re.fullmatch(r"actions/[a-z-]+@[0-9a-f]{40}", action)}
    assert used - pinned == {"pypa/gh-action-pypi-publish@release/v1"}


@pytest.mark.parametrize("transport", ["dds", "auto"])
def test_a_run_without_cyclonedds_says_what_to_do(transport: str) -> None:
    missing = "import sys; sys.modules.update(cyclonedds=None, rclpy=None); from graphengine.cli import main; "
    result = run(f"{missing} sys.exit(main(['run', 'dd100_flat', '--for', '1s', '--transport', {transport!r}]))")
    assert result.returncode == 1
    assert "PyPI has cyclonedds for Linux" in result.stderr
    assert "a sourced ROS 2 with --transport rclpy, or no network with --transport memory" in result.stderr
    assert "Traceback" not in result.stderr


def test_a_run_in_memory_needs_no_cyclonedds() -> None:
    missing = "import sys; sys.modules.update(cyclonedds=None, rclpy=None); from graphengine.cli import main; "
    result = run(f"{missing} sys.exit(main(['run', 'dd100_flat', '--for', '1s', '--transport', 'memory']))")
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("version", ["4.0.0", "3.3.7"])
def test_a_version_of_mujoco_with_a_wrong_solver_is_refused(version: str) -> None:
    other = f"import sys, mujoco; mujoco.__version__ = {version!r}; from graphengine.cli import main; "
    result = run(f"{other} sys.exit(main(['check', 'dd100_flat']))")
    assert result.returncode == 2
    assert f"MuJoCo {version} is installed; before 4.0.1, its solver gives wrong results" in result.stderr
    assert "pip install 'mujoco-core>=4.0.1,<4.1'" in result.stderr
    assert "mujoco-core>=4.0.1,<4.1" in PROJECT["dependencies"]
