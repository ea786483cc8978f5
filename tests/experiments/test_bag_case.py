"""Scenarios that are judged over bags."""

from __future__ import annotations

import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from graphengine.cli import main
from graphengine.experiments.bag_case import IGNORED, bag_case, judge_on_bag
from tests.api.expectations.bag_writing import LENGTH, driving, write_bag
from tests.experiments.harness import DRIVING, scenario_file, scenario_of

X = 'message("/position").point.x'
MET = f"expect:\n  - within: 3s\n    reach: {X} > 1.2\n"
MISSED = f"expect:\n  - always: {X} < 2\n"


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_bag(tmp_path_factory.mktemp("bags") / "real", driving())


def test_steps_scene_and_matrix_are_ignored(tmp_path: Path, bag: Path) -> None:
    path = scenario_file(tmp_path, f"do: [{DRIVING}]\nmatrix: {{seed: [0, 1]}}\nruns: 3\n{MET}", scene="missing")
    scenario = scenario_of(path)
    assert bag_case(scenario, bag).name == "tried[real]"
    result = judge_on_bag(scenario, bag)
    assert (result.outcome, result.time) == ("passed", LENGTH)
    assert {"scene", "set", "matrix", "pass", "do"} <= {*IGNORED}


def test_a_bag_is_judged_up_to_the_end_of_the_run_that_the_scenario_states(tmp_path: Path, bag: Path) -> None:
    whole = judge_on_bag(scenario_of(scenario_file(tmp_path, MISSED)), bag)
    assert whole.outcome == "failed"
    assert whole.checks[0].decided == pytest.approx(4.0)  # x = 0.5 t
    early = judge_on_bag(scenario_of(scenario_file(tmp_path, f"{MISSED}stop: {{after: 3.5s}}\n")), bag)
    assert (early.outcome, early.time) == ("passed", 3.5)


def test_an_expectation_that_a_bag_cannot_answer_is_an_error_with_its_place_and_the_others_are_judged(
    tmp_path: Path, bag: Path
) -> None:
    path = scenario_file(tmp_path, f'{MET}  - always: tilt("dd100") < 0.1\n  - never: message("/odom").x > 1\n')
    result = judge_on_bag(scenario_of(path), bag)
    assert (result.outcome, [check.outcome for check in result.checks]) == ("error", ["passed", "error", "error"])
    assert f"{path}:7: error: always tilt" in result.report()
    assert (
        "tilt: a bag has only topics; use a message, such as message('/odom').pose.pose.position.x" in result.report()
    )
    assert f"{path}:8: error: never message" in result.report()


def test_a_bag_that_cannot_be_read_is_an_error(tmp_path: Path) -> None:
    result = judge_on_bag(scenario_of(scenario_file(tmp_path, MET)), tmp_path / "none.mcap")
    assert (result.outcome, "none.mcap: no such file" in result.reason) == ("error", True)


def test_graphrun_test_writes_the_same_junit(tmp_path: Path, bag: Path) -> None:
    scenario_file(tmp_path, MET, name="met")
    scenario_file(tmp_path, MISSED, name="missed")
    scenario_file(tmp_path, 'expect: [always: tilt("dd100") < 0.1]\n', name="unfit")
    scenario_file(tmp_path, f"do: [{DRIVING}]\n", name="steps")
    command = [sys.executable, "-m", "graphengine.cli", "test", "--bag", str(bag), "--junit", "out.xml"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 1, done.stderr
    assert f"bag: {bag}; nothing is simulated; ignored in scenarios: scene, set, matrix" in done.stdout
    assert "Traceback" not in done.stdout
    (suite,) = ElementTree.parse(tmp_path / "out.xml").getroot()
    found = {case.get("name"): {child.tag for child in case} - {"properties"} for case in suite}
    assert found == {
        "met[real]": set(),
        "missed[real]": {"failure"},
        "unfit[real]": {"error"},
        "steps[real]": {"skipped"},
    }


@pytest.mark.parametrize("option", [("--results", "rows.jsonl"), ("--rerun", "3"), ("--record-failures", "kept")])
def test_options_that_need_a_simulation_are_refused_with_a_bag(
    bag: Path, option: tuple[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["test", "--bag", str(bag), *option]) == 4
    assert f"{option[0]}: not with --bag, which simulates nothing" in capsys.readouterr().err
