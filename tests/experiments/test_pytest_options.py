"""The options of the pytest plugin for parts of the tests and for failed cases."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.experiments.falling import FAILS, PASSES, write_scenario


def pytest_says(folder: Path, *arguments: str) -> str:
    command = [sys.executable, "-m", "pytest", "-q", "--allow-scenario-scripts", "-p", "no:cacheprovider", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=240).stdout


def test_shards_of_pytest_share_the_tests_of_all_kinds(tmp_path: Path) -> None:
    write_scenario(tmp_path, range(4), [PASSES])
    (tmp_path / "test_own.py").write_text("def test_one(): pass\ndef test_two(): pass\n")
    parts = [pytest_says(tmp_path, "--collect-only", "--shard", f"{number}/3") for number in (1, 2, 3)]
    tests = [{line for line in part.splitlines() if "::" in line} for part in parts]
    assert [len(part) for part in tests] == [2, 2, 2]
    assert len(set.union(*tests)) == 6
    assert (
        "expected NUMBER/TOTAL"
        in subprocess.run(
            [sys.executable, "-m", "pytest", "--shard", "4/3"], cwd=tmp_path, capture_output=True, text=True
        ).stderr
    )


@pytest.mark.parametrize("more", [(), ("-n", "2"), ("--collect-only",)])
def test_a_shard_without_tests_passes_and_says_so(tmp_path: Path, more: tuple[str, ...]) -> None:
    write_scenario(tmp_path, [0], [PASSES])
    command = [sys.executable, "-m", "pytest", "--shard", "2/2", *more]
    ended = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=240)
    assert ended.returncode == 0
    assert "shard 2/2 has no cases" in ended.stdout


def test_a_folder_without_tests_has_the_same_exit_code_with_a_shard(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "pytest", "--shard", "1/2"]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=240).returncode == 5


def test_a_failed_scenario_says_how_often_it_fails(tmp_path: Path) -> None:
    write_scenario(tmp_path, [0], [PASSES, FAILS])
    said = pytest_says(tmp_path, "--rerun", "3")
    assert "failed always, in 3 of 3" in said
    assert "1 failed, 1 passed" in said
