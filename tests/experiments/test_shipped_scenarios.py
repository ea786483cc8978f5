"""The shipped scenarios pass, and the same statements in Python have the same verdicts and robustness."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

import graphengine as ge
from graphengine.api.expectations.expectations import ExpectationCheck
from graphengine.experiments.case_run import run_case
from tests.experiments.harness import scenario_of

FOLDER = Path(__file__).parents[2] / "scenes" / "scenarios"
FILES = sorted(FOLDER.glob("*.scenario.yaml"))
Checks = tuple[ExpectationCheck, ...]
FORWARD = "/dd100_0000/cmd_vel"


def straight(sim: ge.Session) -> Checks:
    sim.publish(FORWARD, {"linear": {"x": 1.3}}, every=0.1)
    checks = sim.expect(
        ge.always('abs(pose("dd100").position[1]) < 0.02'), ge.within(12.0, 'pose("dd100").position[0] > 5')
    )
    sim.run(12.0, until=sim.decided)
    return checks


def stops(sim: ge.Session) -> Checks:
    speed = 'velocity("dd100").linear[0]'
    checks = sim.expect(ge.count(f"{speed} > 0.95", at_least=1), ge.settles(4.0, f"abs({speed}) < 0.01"))
    drive = sim.publish(FORWARD, {"linear": {"x": 1}}, every=0.1)
    sim.run(2.0)
    drive.close()
    sim.run(3.0, until=sim.decided)
    return checks


def recovers(sim: ge.Session) -> Checks:
    checks = sim.expect(
        ge.always('tilt("dd100") < 0.1'),
        ge.settles(4.0, 'tilt("dd100") < 0.01'),
        ge.holds(2.0, 'abs(velocity("dd100").angular[2]) < 0.02'),
    )
    sim.publish(FORWARD, {"linear": {"x": 0.5}}, every=0.1)
    sim.run(2.0)
    sim.push("dd100", force=(0, 80, 0), duration=0.5)
    sim.run(4.0, until=sim.decided)
    return checks


def scans(sim: ge.Session) -> Checks:
    checks = sim.expect(
        ge.rate("/dd100_0000/sim_lidar/scan", at_least=19, at_most=21),
        ge.latency("/dd100_0000/sim_lidar/scan", at_most=0.1),
        ge.never('contact("dd100", "rack*")'),
    )
    sim.publish(FORWARD, {"linear": {"x": 0.3}, "angular": {"z": 0.1}}, every=0.1)
    sim.run(5.0, until=sim.decided)
    return checks


def two(sim: ge.Session) -> Checks:
    checks = sim.expect(
        ge.never('contact("dd100_0000", "*", "floor") or contact("dd100_0001", "*", "floor")'),
        ge.within(10.0, 'pose("dd100_0000").position[1] > 5 and pose("dd100_0001").position[1] < 2'),
    )
    half = 0.5**0.5
    sim.move("dd100_0001", (-3.8, 6.0), orientation=(0.0, 0.0, -half, half))
    sim.move("dd100_0000", (-3.0, 1.0))
    drives = [sim.publish(f"/dd100_000{n}/cmd_vel", {"linear": {"x": 0.8}}, every=0.1) for n in (0, 1)]
    if not sim.run(6.0, until=sim.decided):
        for drive in drives:
            drive.close()
        sim.run(4.0, until=sim.decided)
    return checks


def worker(sim: ge.Session) -> Checks:
    sim.publish(FORWARD, {"linear": {"x": 0.5}}, every=0.1)
    checks = sim.expect(
        ge.never('contact("dd100", "worker")'),
        ge.within(14.0, 'pose("dd100").position[0] > 3.5'),
        ge.always('distance("dd100", "worker") > 0.5'),
    )
    sim.run(14.0, until=sim.decided)
    return checks


IN_PYTHON: Mapping[str, Callable[[ge.Session], Checks]] = {
    "drives_straight": straight,
    "keeps_its_scan_rate": scans,
    "recovers_from_a_push": recovers,
    "stops_without_commands": stops,
    "two_robots_pass": two,
    "worker_crosses": worker,
}


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name.partition(".")[0])
def test_each_case_passes_with_the_same_verdicts_in_python(path: Path) -> None:
    scenario = scenario_of(path)
    for case in scenario.cases():
        result = run_case(scenario, case)
        assert result.outcome == "passed", result.report()
        with scenario.load(case.settings).session(seed=case.seed) as sim:
            checks = IN_PYTHON[scenario.spec.scenario](sim)
            sim.judge()
        assert [check.outcome for check in result.checks] == [check.outcome for check in checks]
        own = [check.verdict.robustness for check in checks]
        assert [check.robustness for check in result.checks] == pytest.approx(own, abs=1e-8)


def test_each_scenario_has_a_twin_in_python() -> None:
    assert sorted(IN_PYTHON) == [path.name.partition(".")[0] for path in FILES]


@pytest.mark.parametrize("command", [("-m", "graphengine.cli", "test"), ("-m", "pytest")], ids=["graphrun", "pytest"])
def test_pytest_and_graphrun_test_run_the_shipped_scenarios(command: tuple[str, ...]) -> None:
    done = subprocess.run(
        [sys.executable, *command, str(FOLDER), "-k", "stops or 0.6"],
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
    assert (done.returncode, "2 passed" in done.stdout) == (0, True), done.stdout + done.stderr
