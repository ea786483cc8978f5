"""Judges the expectations of a scenario over a bag, such as a recording of the real robot; there is no simulation."""

from __future__ import annotations

import math
from contextlib import closing
from pathlib import Path

from graphengine.api.expectations.bags import Bag
from graphengine.api.expectations.expectations import ExpectationCheck
from graphengine.experiments.case_run import CaseResult, CheckResult, check_result
from graphengine.experiments.scenario import Case, Scenario, ScenarioSpec
from graphengine.format.errors import GraphError
from graphengine.format.spec_reader import keys_of

_JUDGED = ("format", "scenario", "doc", "seed", "expect", "stop")
IGNORED = tuple(key for key in keys_of(ScenarioSpec) if key not in _JUDGED)
"""Keys of a scenario that concern simulations only."""


def bag_case(scenario: Scenario, bag: Path) -> Case:
    """Return the only case of a scenario that is judged over a bag."""
    return Case(f"{scenario.spec.scenario}[{bag.name}]", {}, scenario.spec.seed, {})


def judge_on_bag(scenario: Scenario, bag: Path) -> CaseResult:
    """Judge the expectations over a bag; a mistake in the files is an outcome, not an exception.

    The bag is judged up to the time of `stop` if the file has that key, else to its end. An expectation for which the bag has no
    values is an error; the others are judged all the same.

    Args:
        scenario: the scenario; its simulation keys (IGNORED) are ignored.
        bag: path of the bag, as for `judge_bag`.
    """
    result = CaseResult(bag_case(scenario, bag).name, {}, scenario.spec.seed)
    if not scenario.spec.expect:
        result.outcome, result.reason = "skipped", "the scenario has no expectations (`expect`)"
        return result
    try:
        with closing(Bag(bag)) as played:
            _judge(scenario, played, result)
    except GraphError as error:
        result.outcome, result.reason = "error", f"{scenario.path}: {error}"
    return result


def _judge(scenario: Scenario, bag: Bag, result: CaseResult) -> None:
    checks: list[ExpectationCheck | CheckResult] = []
    for index, entry in enumerate(scenario.spec.expect):
        expectation, place = entry.expectation(), scenario.place("expect", index)
        try:
            checks.append(bag.expect(expectation))
        except GraphError as error:
            report = f"error: {expectation.text}\n  {error}"
            checks.append(CheckResult(expectation.text, place, "error", math.nan, None, report))
    spec = scenario.spec
    bag.play(spec.stop.after if "stop" in spec.model_fields_set else math.inf)
    result.time = bag.time
    result.checks = [
        check if isinstance(check, CheckResult) else check_result(scenario, index, check)
        for index, check in enumerate(checks)
    ]
    outcomes = {check.outcome for check in result.checks}
    result.outcome = "error" if "error" in outcomes else "failed" if "failed" in outcomes else "passed"
