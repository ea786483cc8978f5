"""`graphrun test` and the pytest plugin, as users start them."""

from __future__ import annotations

import json
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.experiments.harness import DRIVING, scenario_file

PASSES = "expect: [always: time < 9]\nstop: {after: 0.2s}\n"
FAILS = f'do: [{DRIVING}]\nexpect:\n  - always: pose("dd100").position[0] < 0.1\nstop: {{after: 2s}}\n'
ERRS = 'expect: [always: tilt("nobody") < 1]\n'
Run = Callable[..., "subprocess.CompletedProcess[str]"]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    def start(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "graphengine.cli", "test", *arguments]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=200, check=False)

    return start


def test_exit_codes_are_those_of_pytest(run: Run, tmp_path: Path) -> None:
    assert run().returncode == 5
    scenario_file(tmp_path, PASSES, name="good")
    assert run().returncode == 0
    assert run("-k", "nothing").returncode == 5
    assert run("missing").returncode == 4
    scenario_file(tmp_path, FAILS, name="bad")
    assert run().returncode == 1
    scenario_file(tmp_path, "expect: []\n", name="wrong")
    done = run()
    assert (done.returncode, "wrong.scenario.yaml:1:1: error G109" in done.stdout) == (2, True), done.stdout


def test_junit_tells_errors_failures_and_skips_apart(run: Run, tmp_path: Path) -> None:
    for name, text in (
        ("good", PASSES),
        ("bad", FAILS),
        ("broken", ERRS),
        ("absent", f"requires: [nothing_here]\n{PASSES}"),
    ):
        scenario_file(tmp_path, text, name=name)
    assert run("--junit", "out.xml", "-n", "2").returncode == 1
    cases = {case.get("name"): case for case in ElementTree.parse(tmp_path / "out.xml").iter("testcase")}
    told = {
        name: next((part.tag for part in case if part.tag != "properties"), "passed") for name, case in cases.items()
    }
    assert told == {"good": "passed", "bad": "failure", "broken": "error", "absent": "skipped"}
    properties = {part.get("name"): part.get("value") for part in cases["good"].iter("property")}
    assert properties["seed"] == "0"
    assert float(properties["robustness: always time < 9"] or 0) == pytest.approx(8.8, abs=0.02)


def test_a_failure_shows_place_time_and_values_without_a_traceback(run: Run, tmp_path: Path) -> None:
    scenario_file(tmp_path, FAILS)
    out = run().stdout
    assert 'tried.scenario.yaml:6: failed: always pose("dd100").position[0] < 0.1' in out
    assert "decided at 0." in out
    assert "pose('dd100') = position (0.1" in out
    assert "Traceback" not in out
    assert "pytest_plugin" not in out.partition("FAILURES")[2]


def test_a_share_of_the_runs_can_be_enough(run: Run, tmp_path: Path) -> None:
    text = "runs: 4\n{}expect: [always: time < 0.1]\nstop: {{after: 0.2s}}\n"
    scenario_file(tmp_path, text.format(""), name="none")
    out = run().stdout
    assert "0 of 4 runs passed; with a confidence of 95 %, 0.0% to 49.0% of all runs pass" in out


def test_the_fixture_judges_the_sessions_of_a_test(run: Run, tmp_path: Path) -> None:
    (tmp_path / "test_own.py").write_text(
        "import graphengine as ge\n"
        "def test_good(session):\n"
        "    sim = session('dd100_flat', set={'DiffController.maxLinearSpeed': 0.5}, seed=1)\n"
        "    sim.expect(ge.always('tilt(\"dd100\") < 0.1'))\n"
        "    assert sim.run(0.1)\n"
        "def test_bad(session):\n"
        "    sim = session('dd100_flat')\n"
        "    sim.expect(ge.always('time < 0.05'))\n"
        "    sim.run(0.1)\n"
    )
    out = run().stdout
    assert "2 passed, 1 error" in out, out
    assert "failed: always time < 0.05" in out


def test_the_verdict_is_a_mark_of_the_recording_and_no_part_of_its_output(run: Run, tmp_path: Path) -> None:
    from mcap.reader import make_reader

    scenario_file(tmp_path, FAILS)
    run("--record-failures", "kept")
    with (tmp_path / "kept/tried/run.mcap").open("rb") as file:
        ends = [one.metadata for one in make_reader(file).iter_metadata() if one.name == "graphengine:end"]
    ((tick, text),) = json.loads(ends[0]["verdicts"])
    assert text == 'failed: always pose("dd100").position[0] < 0.1'
    assert 20 < tick < 60
