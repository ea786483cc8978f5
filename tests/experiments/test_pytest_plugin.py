"""`graphrun test` and the pytest plugin, as users start them. Starts are slow, so most tests share one."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import NamedTuple

import pytest
from mcap.reader import make_reader

from tests.experiments.falling import start
from tests.experiments.harness import DRIVING, scenario_file

PASSES = "expect: [always: time < 9]\nstop: {after: 0.2s}\n"
FAILS = f'do: [{DRIVING}]\nexpect:\n  - always: pose("dd100").position[0] < 0.1\nstop: {{after: 2s}}\n'
SCENARIOS = {
    "good": PASSES,
    "bad": FAILS,
    "broken": 'expect: [always: tilt("nobody") < 1]\n',
    "absent": f"requires: [nothing_here]\n{PASSES}",
    "never": "runs: 2\nexpect: [always: time < 0.1]\nstop: {after: 0.2s}\n",
}
OWN = """
import graphengine as ge
def test_good(session):
    sim = session('dd100_flat', set={'DiffController.maxLinearSpeed': 0.5}, seed=1)
    sim.expect(ge.always('tilt("dd100") < 0.1'))
    assert sim.run(0.1)
def test_missed(session):
    for limit in (0.05, 0.07, 9.0):
        sim = session('dd100_flat')
        sim.expect(ge.always(f'time < {limit}'))
        sim.run(0.1)
def test_asserted(session):
    sim = session('dd100_flat')
    sim.expect(ge.always('time < 0'))
    assert sim.run(0.1) == 'not this'
"""


class Done(NamedTuple):
    """A finished `graphrun test` of all scenarios and OWN."""

    folder: Path
    code: int
    output: str
    cases: dict[str, ElementTree.Element]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Done:
    folder = tmp_path_factory.mktemp("project")
    for name, text in SCENARIOS.items():
        scenario_file(folder, text, name=name)
    (folder / "test_own.py").write_text(OWN)
    process = start(folder, "--junit", "out.xml", "-n", "2", "--record-failures", "kept")
    output, _ = process.communicate(timeout=240)
    cases = ElementTree.parse(folder / "out.xml").iter("testcase")
    return Done(folder, process.returncode, output, {str(case.get("name")): case for case in cases})


def test_the_exit_codes_equal_the_exit_codes_of_pytest(done: Done, tmp_path: Path) -> None:
    texts = {"empty": "", "good": PASSES, "wrong": "expect: []\n"}
    for name, text in texts.items():
        (tmp_path / name).mkdir()
        if text:
            scenario_file(tmp_path / name, text, name=name)
    processes = [start(tmp_path, name) for name in (*texts, "missing")]
    outputs = [process.communicate(timeout=240)[0] for process in processes]
    assert [process.returncode for process in processes] == [5, 0, 2, 4]
    assert done.code == 1
    assert "wrong.scenario.yaml:1:1: error G109" in outputs[2]


def test_junit_distinguishes_errors_failures_and_skips(done: Done) -> None:
    kinds = {
        name: next((part.tag for part in case if part.tag != "properties"), "passed")
        for name, case in done.cases.items()
    }
    assert kinds == {
        "good": "passed",
        "bad": "failure",
        "broken": "error",
        "absent": "skipped",
        "never": "failure",
        "test_good": "passed",
        "test_missed": "failure",
        "test_asserted": "failure",
    }
    properties = {part.get("name"): part.get("value") for part in done.cases["good"].iter("property")}
    assert properties["seed"] == "0"
    assert float(properties["robustness: always time < 9"] or 0) == pytest.approx(8.8, abs=0.02)


def test_a_failure_shows_place_time_and_values_without_a_traceback(done: Done) -> None:
    assert 'bad.scenario.yaml:6: failed: always pose("dd100").position[0] < 0.1' in done.output
    assert "decided at 0." in done.output
    assert "pose('dd100') = position (0.1" in done.output
    assert "Traceback" not in done.output
    assert "pytest_plugin" not in done.output.partition("FAILURES")[2]


def test_a_share_of_the_runs_can_be_enough(done: Done) -> None:
    assert "0 of 2 runs passed; with a confidence of 95 %, 0.0% to 65.8% of all runs pass" in done.output


def test_the_fixture_reports_all_missed_expectations_of_a_test_that_passes_otherwise(done: Done) -> None:
    missed = "".join(done.cases["test_missed"].itertext())
    assert [line for line in missed.splitlines() if "failed:" in line] == [
        "failed: always time < 0.05",
        "failed: always time < 0.07",
    ]
    asserted = "".join(done.cases["test_asserted"].itertext())
    assert ("not this" in asserted, "failed: always" in asserted) == (True, False)


def test_each_run_that_did_not_pass_has_a_folder(done: Done) -> None:
    folders = sorted(path.name.partition("~")[0] for path in (done.folder / "kept").iterdir())
    assert folders == ["bad", "broken", "never", "never_run2"]
    assert "kept: kept/bad/report.txt" in done.output


def test_the_verdict_is_a_mark_of_the_recording_and_no_part_of_its_output(done: Done) -> None:
    with (done.folder / "kept/bad/run.mcap").open("rb") as file:
        ends = [one.metadata for one in make_reader(file).iter_metadata() if one.name == "graphengine:end"]
    ((tick, text),) = json.loads(ends[0]["verdicts"])
    assert text == 'failed: always pose("dd100").position[0] < 0.1'
    assert 20 < tick < 60
