"""Scenario files of tests, and their results."""

from __future__ import annotations

from pathlib import Path

from graphengine.experiments.case_run import CaseOptions, CaseResult, run_case
from graphengine.experiments.scenario import Scenario, read_scenario
from graphengine.format.diagnostics import Findings

DRIVING = "publish: {topic: /dd100_0000/cmd_vel, message: {linear: {x: 0.5}}, every: 0.1s}"


def scenario_file(folder: Path, text: str, *, scene: str = "dd100_flat", name: str = "tried") -> Path:
    path = folder / f"{name}.scenario.yaml"
    path.write_text(f"format: 1\nscenario: {name}\nscene: {scene}\n{text}")
    return path


def scenario_of(path: Path) -> Scenario:
    findings = Findings()
    scenario = read_scenario(path, findings)
    assert scenario is not None, "\n".join(finding.render() for finding in findings.items)
    return scenario


def result_of(path: Path, **options: object) -> CaseResult:
    scenario = scenario_of(path)
    return run_case(scenario, next(scenario.cases()), CaseOptions(**options))  # type: ignore[arg-type]


def findings_of(path: Path) -> list[str]:
    findings = Findings()
    assert read_scenario(path, findings) is None
    return [finding.render() for finding in findings.sorted()]
