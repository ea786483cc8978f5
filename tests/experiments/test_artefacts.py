"""Files kept of a run that did not pass, each run in a folder of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.cli import main
from graphengine.experiments.artefacts import LONGEST, artefact_folder, run_and_keep
from graphengine.experiments.case_run import CaseOptions, CaseResult
from graphengine.experiments.scenario import Case
from tests.experiments.harness import DRIVING, scenario_file, scenario_of

PASSES = "expect: [always: time < 9]\nstop: {after: 0.01s}\n"
FAILS = "expect: [always: time < 0]\nstop: {after: 0.01s}\n"


def keep(path: Path) -> CaseResult:
    """Run a scenario, and keep its files below `kept`."""
    scenario = scenario_of(path)
    return run_and_keep(scenario, next(scenario.cases()), CaseOptions(), path.parent / "kept", path.name)


def kept(folder: Path) -> list[str]:
    return sorted(path.name for path in (folder / "kept").iterdir())


def test_the_files_can_be_opened_and_replayed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "kept" / "tried"
    driving = f'do: [{DRIVING}]\nexpect:\n  - always: pose("dd100").position[0] < 0.1\nstop: {{after: 0.5s}}\n'
    assert keep(scenario_file(tmp_path, driving)).kept == folder / "report.txt"
    assert f"graphrun view {folder}/run.mcap --at 0." in (folder / "report.txt").read_text()
    assert main(["replay", str(folder / "run.mcap")]) == 0
    assert "identical" in capsys.readouterr().out
    assert "Content-Security-Policy" in (folder / "run.html").read_text()
    assert main(["view", str(folder / "run.mcap"), "--html", str(tmp_path / "again.html")]) == 0


def test_an_earlier_folder_of_a_case_is_replaced_and_is_removed_when_the_case_passes(tmp_path: Path) -> None:
    keep(scenario_file(tmp_path, FAILS))
    (tmp_path / "kept/tried/9-old.txt").touch()
    keep(scenario_file(tmp_path, FAILS, scene="no_such_scene"))
    assert [path.name for path in (tmp_path / "kept/tried").iterdir()] == ["report.txt"]  # not the earlier recording
    keep(scenario_file(tmp_path, PASSES))
    assert kept(tmp_path) == []


def test_a_folder_of_the_user_is_left_alone(tmp_path: Path) -> None:
    own = tmp_path / "kept/tried/report.txt"
    own.parent.mkdir(parents=True)
    own.write_text("mine")
    for text in (PASSES, FAILS, PASSES):
        result = keep(scenario_file(tmp_path, text))
        assert ([path.name for path in own.parent.iterdir()], own.read_text()) == (["report.txt"], "mine")
        assert kept(tmp_path) == sorted({"tried", result.kept.parent.name if result.kept else "tried"})


def test_no_two_runs_share_a_folder(tmp_path: Path) -> None:
    names = ["tried", "tried[a/b]", "tried[a_b]", "tried_run2", "..", *("x" * 400 + end for end in "ab")]
    files = "tried.scenario.yaml", "sub/tried.scenario.yaml", "tried_run2.scenario.yaml"
    runs = [(file, name, run) for file in files for name in names for run in (0, 1)]
    folders = {artefact_folder(tmp_path, file, Case(name, {}, 0, {}), run) for file, name, run in runs}
    assert {folder.parent for folder in folders} == {tmp_path}
    assert len(folders) == len(runs) == 42
    assert {tmp_path / "tried", tmp_path / "tried_run2"} < folders
    assert max(len(folder.name) for folder in folders) <= LONGEST + len("_run2~0123456789")
    values = [artefact_folder(tmp_path, files[0], Case("tried[1]", {"a": value}, 0, {}), 0) for value in (1, "1")]
    assert values[0] != values[1]


def test_an_error_before_the_first_tick_is_reported(tmp_path: Path) -> None:
    result = keep(scenario_file(tmp_path, 'expect: [always: tilt("nobody") < 1]\n'))
    assert (result.outcome, "nobody" in result.reason) == ("error", True)
    assert "run.html" not in (tmp_path / "kept/tried/report.txt").read_text()


def test_a_folder_that_cannot_be_made_is_an_error_of_the_run(tmp_path: Path) -> None:
    (tmp_path / "kept").touch()
    result = keep(scenario_file(tmp_path, PASSES))
    assert (result.outcome, result.reason) == ("error", f"--record-failures {tmp_path / 'kept'}: File exists")
