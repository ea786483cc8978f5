"""Scenario files: their keys, their cases, and what is wrong in them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.experiments.harness import findings_of, result_of, scenario_file, scenario_of

EXPECTED = 'expect: [always: tilt("dd100") < 0.1]\n'


def test_cases_have_the_names_that_pytest_gives_to_parameters(tmp_path: Path) -> None:
    text = "matrix: {seed: [0, 1], DiffController.maxLinearSpeed: [0.6, 1.3], Graph.list: [[1, 2], [3]]}\n"
    cases = list(scenario_of(scenario_file(tmp_path, text + EXPECTED)).cases())
    assert [case.name for case in cases[:3]] == ["tried[0-0.6-list0]", "tried[0-0.6-list1]", "tried[0-1.3-list0]"]
    assert len(cases) == 8
    assert (cases[-1].seed, cases[-1].settings) == (1, {"DiffController.maxLinearSpeed": 1.3, "Graph.list": [3]})


def test_a_value_of_the_matrix_wins_over_set(tmp_path: Path) -> None:
    text = "set: {A.x: 1, A.y: 2}\nmatrix: {A.x: [3]}\n"
    (case,) = scenario_of(scenario_file(tmp_path, text + EXPECTED)).cases()
    assert case.settings == {"A.x": 3, "A.y": 2}


def test_a_scene_is_found_beside_the_scenario_before_one_of_the_package(tmp_path: Path) -> None:
    path = scenario_file(tmp_path, EXPECTED, scene="dd100_flat.yaml")
    assert scenario_of(path).scene == "dd100_flat.yaml"
    (tmp_path / "dd100_flat.yaml").write_text("graph: g\nnodes: {Tick: OnPlaybackTick}\n")
    assert scenario_of(path).scene == str(tmp_path / "dd100_flat.yaml")


def test_an_error_of_a_mover_has_its_place_in_the_scenario(tmp_path: Path) -> None:
    movers = """movers:
  one: {shape: person, path: [[0, 2], [0, 8]], speed: 1.2}
  two: {shape: nothing.stl, path: [[0, 2], [0, 8]], speed: 1.2}
"""
    path = scenario_file(tmp_path, movers + EXPECTED)
    assert result_of(path).reason.startswith(f"{path}:6:16: error S101: no file 'nothing.stl'")


def test_an_error_of_the_scene_has_its_place_in_the_scene_also_with_movers(tmp_path: Path) -> None:
    scene = tmp_path / "hall.yaml"
    scene.write_text("scene: hall\nworld: nothing.xml\n")
    movers = "movers: {one: {shape: person, path: [[0, 2], [0, 8]], speed: 1.2}}\n"
    path = scenario_file(tmp_path, movers + "expect: [always: time < 9]\n", scene="hall.yaml")
    assert result_of(path).reason.startswith(f"{scene}:2:8: error")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("", ["neither steps (`do`) nor expectations (`expect`)"]),
        (
            "expect: [alwys: time < 1]\n",
            ["4:10: error G109", "expected one operator, got none; operators: always, never"],
        ),
        ("expect:\n  - {always: time < 1, never: time > 1}\n", ["5:5: error G109", "got 'always' and 'never'"]),
        ("expect: [within: 3s]\n", ["'within' needs the key 'reach'"]),
        ("expect: [{always: time < 1, reach: time > 1}]\n", ["'reach' does not belong to 'always'"]),
        ("expect: [{count: time > 1, at_least: 3, at_most: 2}]\n", ["4:10: error G109", "0 <= at_least <= at_most"]),
        ("expect: [{rate: {topc: /a, at_least: 3}}]\n", ["unknown key 'topc'", "did you mean 'topic'?"]),
        ("expect: [rate: {topic: /a}]\n", ["'rate' needs a limit: at_least, at_most or both"]),
        ("expect: [count: time > 1]\n", ["'count' needs a limit"]),
        (
            "expect: [always: tlt < 0.1]\n",
            ["4:10: error G109: tlt < 0.1: there is no name 'tlt'", "did you mean 'tilt'?"],
        ),
        ("expect: [always: rate(]\n", ["4:10: error G109: not an expression"]),
        ("do: [{parallel: [[wait: tme > 1]]}]\n", ["there is no name 'tme'"]),
        (f"matrix: {{A.x: [1, 1.0, '1']}}\n{EXPECTED}", ["2 cases have the name tried[1]"]),
        ("do: [{wait: 1s, publish: {topic: /a, message: {}}}]\n", ["a step has one key, got 'wait' and 'publish'"]),
        ("do: [fly: 3]\n", ["unknown key 'fly'", "publish, wait, call, action, start"]),
        (
            "do: [publish: {topic: /a, message: {}, every: soon}]\n",
            ["every: 'soon' is not a time; write 10, 10s, 500ms or 2min"],
        ),
        ("do: [push: {entity: a, force: [1, 2]}]\n", ["force: expected 3 values, got 2"]),
        ("do: [{parallel: [[wait: 1s], [parallel: []]]}]\n", ["unknown key 'parallel'"]),
        ("do: [{wait: {topic: /a, node: /b}}]\n", ["expected one of these", "topic, node, service, lifecycle"]),
        (f"matrix: {{seed: [a]}}\n{EXPECTED}", ["seed: expected whole numbers, got 'a'"]),
        (f"matrix: {{seed: []}}\n{EXPECTED}", ["'seed' has no values"]),
        (f"matrix: {{seed: {list(range(400))}, A.x: {list(range(400))}}}\n{EXPECTED}", ["160000 runs; at most 100000"]),
        (f"runs: 3\npass: 4\n{EXPECTED}", ["4 of 3 runs cannot pass"]),
        (f"stop: {{after: 0}}\n{EXPECTED}", ["after: expected a value > 0"]),
    ],
)
def test_a_mistake_is_a_finding_with_its_place(tmp_path: Path, text: str, found: list[str]) -> None:
    told = "\n".join(findings_of(scenario_file(tmp_path, text)))
    assert all(part in told for part in found), told


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('expect: [always: tilt("dd101") < 0.1]\n', "4: no entity 'dd101'"),
        ("expect:\n  - always: pose(5).position[0] < 0.1\n", "5: "),
        ("expect: [always: sqrt(time) * nan < 1]\n", "a side of a comparison is not a number (NaN)"),
        ("do: [publish: {topic: /cmd_vel, message: {}}]\n", "4: no graph uses topic '/cmd_vel'"),
        ("do: [wait: 3s]\nstop: {after: 1s}\n", "4: the run ended at 1.000 s before this step did"),
        ("set: {Nowhere.x: 1}\n" + EXPECTED, "Nowhere"),
        ("do: [push: {entity: dd101, impulse: [1, 0, 0]}]\n", "4: no entity 'dd101'"),
    ],
)
def test_a_mistake_that_only_a_run_can_find_is_an_error_with_its_place(tmp_path: Path, text: str, reason: str) -> None:
    result = result_of(scenario_file(tmp_path, text))
    assert (result.outcome, reason in result.report()) == ("error", True), result.report()


def test_steps_continue_after_all_expectations_passed_and_a_run_without_expectations_waits_for_its_publications(
    tmp_path: Path,
) -> None:
    met_early = "do: [wait: 1s]\nexpect:\n  - within: 10s\n    reach: time > 0.2\n"
    result = result_of(scenario_file(tmp_path, met_early))
    assert result.outcome == "passed"
    assert result.time == pytest.approx(1.0, abs=0.02)
    sends = "do: [publish: {topic: /dd100_0000/cmd_vel, message: {}, every: 0.1s, for: 0.5s}]\n"
    assert result_of(scenario_file(tmp_path, sends)).time == pytest.approx(0.5, abs=0.02)


def test_a_scene_must_be_in_the_folder_of_its_scenario_or_in_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "secret").write_text("machine h login u password s3cret\n")
    folder = tmp_path / "strange"
    folder.mkdir()
    path = scenario_file(folder, EXPECTED, scene="../secret")
    monkeypatch.chdir(folder)
    result = result_of(path)
    assert (result.outcome, "s3cret" in result.reason) == ("error", False)
    assert "lies outside of the folder of the scenario and of the current folder" in result.reason
    monkeypatch.chdir(tmp_path)
    assert "s3cret" in result_of(path).reason


def test_looking_for_a_package_imports_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        result_of(scenario_file(tmp_path, "requires: [this.x]\nstop: {after: 0.1s}\n" + EXPECTED)).outcome == "passed"
    )
    assert "Zen" not in capsys.readouterr().out


def test_a_scenario_that_requires_a_missing_package_is_skipped(tmp_path: Path) -> None:
    result = result_of(scenario_file(tmp_path, "requires: [numpy, sh, no_such_program]\n" + EXPECTED))
    assert (result.outcome, result.reason) == ("skipped", "requires no_such_program")


def test_after_a_failure_the_other_expectations_stay_open(tmp_path: Path) -> None:
    text = "expect:\n  - always: time < 0.5\n  - within: 9s\n    reach: time > 5\n  - always: time < 0.2\n"
    result = result_of(scenario_file(tmp_path, text))
    assert [check.outcome for check in result.checks] == ["open", "open", "failed"]
    assert result.outcome == "failed"
    assert "tried.scenario.yaml:8: failed: always time < 0.2" in result.report()
